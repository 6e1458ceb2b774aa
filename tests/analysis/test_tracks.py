"""Track files as people and programs write them: units, gaps, bad rows, refusals."""

import numpy as np
import pytest

from walkergen.analysis import track_files
from walkergen.analysis.track_files import Units
from walkergen.core.errors import InputError

FILM = Units(fps=100.0, mm_per_px=0.5)


def write(tmp_path, text, name="tracks.csv"):
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    return path


def read(tmp_path, text, units=FILM):
    return track_files.read_tracks(write(tmp_path, text), units)


def test_trackpys_columns_in_any_order_with_its_index_and_brightness(tmp_path):
    # DataFrame.to_csv of trackpy.link: an unnamed index, y before x, mass a brightness.
    text = ",y,x,mass,size,ecc,frame,particle\n"
    text += "0,10.0,2.0,1e9,3.1,0.1,0,0\n7,30.0,8.0,5,3,0,1,1\n3,11.0,4.0,-5,3,0,1,0\n"
    text += "9,31.0,9.0,5,3,0,2,1\n"
    found = read(tmp_path, text)
    assert found.interval == pytest.approx(0.01)
    assert not found.lane
    np.testing.assert_allclose(found.tracks[0].position, [[1.0, 5.0], [2.0, 5.5]])
    np.testing.assert_allclose(found.tracks[1].position, [[4.0, 15.0], [4.5, 15.5]])
    assert found.tracks[0].heading is None


def test_gaps_are_kept_as_gaps(tmp_path):
    (one,) = read(tmp_path, "frame,particle,x,y\n4,1,0,0\n9,1,2,0\n5,1,1,0\n").tracks
    assert one.position.shape == (6, 2)
    assert np.flatnonzero(np.isnan(one.position[:, 0])).tolist() == [2, 3, 4]


def test_every_third_frame_is_a_coarser_film_without_gaps(tmp_path):
    found = read(tmp_path, "frame,particle,x,y\n3,1,0,0\n6,1,2,0\n9,1,1,0\n5,2,1,1\n11,2,2,2\n")
    assert found.interval == pytest.approx(0.03)
    assert [len(one.position) for one in found.tracks] == [3, 3]


@pytest.mark.parametrize(("column", "angle"), [("theta", np.pi / 6), ("theta_deg", 30.0)], ids=["rad", "deg"])
def test_y_down_turns_positions_and_headings_over(tmp_path, column, angle):
    text = f"frame,particle,x,y,{column}\n0,0,1,2,{angle}\n1,0,1,4,\n"
    (up,) = read(tmp_path, text).tracks
    (down,) = read(tmp_path, text, FILM._replace(y_down=True)).tracks
    np.testing.assert_allclose(down.position, up.position * [1, -1])
    np.testing.assert_allclose(up.heading, [np.pi / 6, np.nan])
    np.testing.assert_allclose(down.heading, -up.heading)


def test_an_open_quote_spoils_no_other_line(tmp_path):
    text = 'frame,particle,x,y\n0,0,1,1\n1,0,2,"1\n2,0,3,1\n3,0,4,1\n'
    found = read(tmp_path, text)
    np.testing.assert_allclose(found.tracks[0].position[[0, 2, 3], 0], [0.5, 1.5, 2.0])


def test_a_simulated_trajectory_is_a_lane_whose_height_is_no_coordinate(tmp_path):
    text = "t_s,x_mm,y_mm,pitch_rad\n0,0,9,0\n0.001,0.1,9.5,0.2\n0.002,0.3,9,0\n"
    found = read(tmp_path, text, Units())
    assert found.lane
    assert found.interval == pytest.approx(0.001)
    np.testing.assert_allclose(found.tracks[0].position[:, 0], [0, 0.1, 0.3])
    assert found.tracks[0].heading is None


def test_bad_rows_are_counted_named_and_left_out(tmp_path):
    text = "frame,particle,x,y\n0,0,1,1\n1,0,abc,1\n2,0,1\n\n3,0,nan,1\n4.5,0,1,1\n"
    text += "5,0,1,1\n5,0,2,2\n6,,1,1\n7,0,inf,1\n8,0,1,1\n"
    found = read(tmp_path, text)
    assert found.bad_rows == 7
    assert np.count_nonzero(~np.isnan(found.tracks[0].position[:, 0])) == 3
    for told in ("7 bad rows", "line 3: x is 'abc'", "line 4: y is missing", "line 9", "and 2 more"):
        assert told in found.note, found.note


POGO = "time,x,y,theta,particle\n"


def test_a_table_with_times_is_read_in_the_units_that_are_given(tmp_path):
    # Rows of Pogotrack's results/tracking.csv: s, cm, degrees; then a frame that it skipped.
    text = POGO + (
        "0.0,76.87377589939182,70.8736212761571,60.96184860035945,0\n"
        "0.04452359750667854,76.87377589939182,70.8736212761571,61.18282319543838,0\n"
        "0.08904719501335707,,,,\n"
        "0.13357079252003562,77.07890939078445,71.13003814039789,59.32456958652914,0\n"
    )
    with pytest.raises(InputError, match="Pogotrack's files are in cm and degrees: unit=cm,deg"):
        read(tmp_path, text, Units())
    found = read(tmp_path, text, Units(unit="cm,deg"))
    (one,) = found.tracks
    assert found.interval == pytest.approx(1 / 22.46)  # its default frame rate
    for told in ("1 bad row left out: line 4: x is '', not a number", "places are in cm", "time is taken as seconds"):
        assert told in found.note
    np.testing.assert_allclose(one.position[0], [768.7377589939182, 708.736212761571])
    np.testing.assert_allclose(np.degrees(one.heading[[0, 3]]), [60.96184860, 59.32456959])
    assert np.isnan(one.position[2]).all()


def test_a_table_with_times_as_a_lane_turned_over_and_with_ids(tmp_path):
    text, units = POGO + "0,1,2,30,0\n0.1,2,4,30,0\n", Units(unit="cm,deg")
    down = read(tmp_path, text, units._replace(y_down=True))
    np.testing.assert_allclose(down.tracks[0].position, [[10, -20], [20, -40]])
    np.testing.assert_allclose(np.degrees(down.tracks[0].heading), -30)
    assert "y counts rows downward, by ‹y_down›: turned over" in down.note
    lane = read(tmp_path, text, units._replace(lane=True))
    assert lane.lane
    assert lane.tracks[0].heading is None
    numbered = "time,x,y,id\n0,1,2,5\n0,1,3,7\n0.1,2,4,5\n"
    assert [one.particle for one in read(tmp_path, numbered, Units(unit="cm")).tracks] == [5, 7]
    with pytest.raises(InputError, match=r"fps=100: .* has its own time\. Leave out fps"):
        read(tmp_path, text)
    with pytest.raises(InputError, match="Link the positions first"):
        read(tmp_path, "time,x,y\n0,1,2\n0,1,3\n0.1,2,4\n", Units(unit="mm"))


@pytest.mark.parametrize(
    ("header", "factor"),
    [
        ("time (s),x (mm),y (mm)", 1.0),
        ("t_s,X [cm],Y [cm]", 10.0),
        ("time_s,x_m,y_m", 1000.0),
        ("t (s),x (pixels),y (pixels)", 0.5),
    ],
)
def test_units_stand_in_headers(tmp_path, header, factor):
    units = Units(mm_per_px=0.5) if "pixels" in header else Units()
    found = read(tmp_path, f"{header}\n0,1,2\n0.5,2,4\n", units)
    assert found.interval == 0.5
    np.testing.assert_allclose(found.tracks[0].position, np.array([[1, 2], [2, 4]]) * factor)


@pytest.mark.parametrize("text", ['"frame","x","y"\n"1",0,2,4\n"2",1,4,8\n', '"frame" "x" "y"\n"1" 0 2 4\n"2" 1 4 8\n'])
def test_rs_header_is_one_field_short(tmp_path, text):
    np.testing.assert_allclose(read(tmp_path, text).tracks[0].position, [[1, 2], [2, 4]])


def test_times_that_are_rounded_are_one_rate(tmp_path):
    # idtracker.ai writes times to a millisecond: at 28 frames a second neighbours are 35 or 36 ms apart.
    rows = "".join(f"{round(frame / 28, 3)},{frame},0\n" for frame in range(200))
    found = read(tmp_path, "time,x,y\n" + rows, Units(unit="mm"))
    assert found.interval == pytest.approx(1 / 28, rel=1e-4)
    np.testing.assert_allclose(found.tracks[0].position[:, 0], np.arange(200))


def test_a_place_without_a_heading_counts(tmp_path):
    text = "t_s,x_mm,y_mm,theta_rad\n0,0,0,0.1\n0.1,1,0,\n0.2,2,0,0.2\n"
    found = read(tmp_path, text, Units())
    assert found.bad_rows == 0
    np.testing.assert_allclose(found.tracks[0].heading, [0.1, np.nan, 0.2])
    assert read(tmp_path, "t_s,x_mm,y_mm,theta_rad\n0,0,0,\n1,1,1,\n", Units()).tracks[0].heading is None
