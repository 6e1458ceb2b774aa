"""Tracks as other programs write them, by their documented layouts: the same walkers come out of each."""

import numpy as np
import pytest

from walkergen.analysis import motion, track_files
from walkergen.analysis.track_files import Units
from walkergen.core.errors import InputError

FPS, SCALE = 25.0, 0.5
FRAMES = np.arange(12)
WALKERS = (
    np.stack([100.0 + 3.25 * FRAMES, 80.0 + 1.5 * FRAMES], axis=1),
    np.stack([300.0 - 2.0 * FRAMES, 40.0 + 0.5 * FRAMES**2], axis=1),
)
"""Places of two walkers, pixels."""

PIXELS = Units(fps=FPS, mm_per_px=SCALE)
ALL = [(frame, number) for frame in FRAMES for number in (0, 1)]


def rows(line):
    return "".join(line(frame, number, *WALKERS[number][frame]) + "\n" for frame, number in ALL)


TRACKMATE = (
    "LABEL,ID,TRACK_ID,QUALITY,POSITION_X,POSITION_Y,POSITION_Z,POSITION_T,FRAME,RADIUS,VISIBILITY\n"
    "Label,Spot ID,Track ID,Quality,X,Y,Z,T,Frame,Radius,Visibility\n"
    "Label,Spot ID,Track ID,Quality,X,Y,Z,T,Frame,R,Visibility\n"
    ",,,(quality),(pixel),(pixel),(pixel),(sec),,(pixel),\n"
)


def trackmate():
    return TRACKMATE + rows(lambda f, n, x, y: f"ID{7 * f + n},{7 * f + n},{n},1.0,{x},{y},0.0,{f / FPS},{f},4.0,1")


def trackmate_xml():
    spots = ("".join(f'<detection t="{f}" x="{x}" y="{y}" z="0.0" />' for f, (x, y) in enumerate(w)) for w in WALKERS)
    particles = "".join(f'<particle nSpots="12">{inner}</particle>' for inner in spots)
    top = f'<Tracks nTracks="2" spaceUnits="pixel" frameInterval="{1 / FPS}" timeUnits="sec">'
    return f'<?xml version="1.0" encoding="UTF-8"?>{top}{particles}</Tracks>'


def trackmate_whole():
    spots, tracks = [], []
    for n, walker in enumerate(WALKERS):
        ids = [100 * n + f for f in FRAMES]
        spots += [
            f'<Spot ID="{i}" FRAME="{f}" POSITION_X="{x}" POSITION_Y="{y}" POSITION_T="{f / FPS}" />'
            for i, f, (x, y) in zip(ids, FRAMES, walker, strict=True)
        ]
        edges = (f'<Edge SPOT_SOURCE_ID="{a}" SPOT_TARGET_ID="{a + 1}" />' for a in ids[:-1])
        tracks.append(f'<Track TRACK_ID="{n}">{"".join(edges)}</Track>')
    spots.append('<Spot ID="999" FRAME="0" POSITION_X="1" POSITION_Y="1" POSITION_T="0" />')  # of no track
    return (
        f'<TrackMate version="7"><Model spatialunits="pixel" timeunits="sec"><AllSpots>{"".join(spots)}</AllSpots>'
        f'<AllTracks>{"".join(tracks)}</AllTracks><FilteredTracks><TrackID TRACK_ID="0" /><TrackID TRACK_ID="1" />'
        f'</FilteredTracks></Model><Settings><ImageData timeinterval="{1 / FPS}" /></Settings></TrackMate>'
    )


def mtrackj():
    tracks = "".join(
        f"Track {n + 1} FF0000 true\n"
        + "".join(f"Point {f + 1} {x} {y} 1.0 {f + 1}.0 1.0\n" for f, (x, y) in enumerate(w))
        for n, w in enumerate(WALKERS)
    )
    return f"MTrackJ 1.5.1 Data File\nAssembly 1 FF0000\nCluster 1 FF0000\n{tracks}End of MTrackJ Data File\n"


def mtrackj_table():
    return "Nr,TID,PID,x [pixel],y [pixel],t [sec],I [val]\n" + rows(
        lambda f, n, x, y: f"{2 * f + n},{n + 1},{f + 1},{x},{y},{f / FPS},255"
    )


def deeplabcut_single():
    names = [",".join(("scorer", *["DLC_resnet50"] * 9)), "bodyparts," + ",".join(p for p in PARTS for _ in range(3))]
    lines = [*names, "coords" + 3 * ",x,y,likelihood"]
    lines += [f"{f}," + ",".join(f"{x + d},{y},0.99" for d in (8, 0, -8)) for f, (x, y) in enumerate(WALKERS[0])]
    return "\n".join(lines) + "\n"


PARTS = ("head", "body", "tail")


def deeplabcut_many():
    owned = [(who, part) for who in ("ann", "bob") for part in PARTS]
    lines = ["scorer" + 18 * ",DLC_dlcrnet"]
    lines.append("individuals," + ",".join(who for who, _ in owned for _ in range(3)))
    lines.append("bodyparts," + ",".join(part for _, part in owned for _ in range(3)))
    lines.append("coords" + 6 * ",x,y,likelihood")
    for f in FRAMES:
        cells = (f"{w[f, 0] + d},{w[f, 1]},0.99" for w in WALKERS for d in (8, 0, -8))
        lines.append(f"{f},{','.join(cells)}")
    return "\n".join(lines) + "\n"


def sleap():
    head = "track,frame_idx,instance.score,head.x,head.y,head.score,tail.x,tail.y,tail.score\n"
    return head + rows(lambda f, n, x, y: f"mouse_{n},{f},0.95,{x + 8},{y},0.98,{x - 8},{y},0.92")


def idtracker(first="time"):
    lines = [f"{first},x1,y1,x2,y2" if first else "x1,y1,x2,y2"]
    for f in FRAMES:
        cells = ",".join(f"{x},{y}" for x, y in (w[f] for w in WALKERS))
        lines.append(f"{round(f / FPS, 3)},{cells}" if first else cells)
    return "\n".join(lines) + "\n"


def idtracker_tidy():
    return "frame,time,individual,x,y,probability\n" + rows(lambda f, n, x, y: f"{f},{f / FPS},{n + 1},{x},{y},1.0")


def trex():
    """As its Graph.cpp exports them: the frame first and among the fields, inf for what was not seen, x of the head."""
    head = "frame,ANGLE,SPEED (cm/s),X#wcentroid (cm),X (cm),Y#wcentroid (cm),Y (cm),frame,missing,time,timestamp"
    lines = (
        f"{f},inf,1.20,{x},{x + 8},{y},inf,{f},0,{f / FPS},{1e6 * f / FPS:.0f}" for f, (x, y) in enumerate(WALKERS[0])
    )
    return head + "\n" + "\n".join(lines) + "\n"


def fasttrack():
    head = ("xHead", "yHead", "tHead", "xBody", "yBody", "tBody", "imageNumber", "id")
    return "\t".join(head) + "\n" + rows(lambda f, n, x, y: f"{x + 1}\t{y}\t0.1\t{x}\t{y}\t0\t{f}\t{n}")


def tracker(mark="\t"):
    lines = (mark.join(map(repr, map(float, (f / FPS, x, y)))) for f, (x, y) in enumerate(WALKERS[0]))
    return "mass_A\n" + mark.join("txy") + "\n" + "\n".join(lines) + "\n"


def animalta():
    lines = ["Frame;Time;X_Arena0_Ind0;Y_Arena0_Ind0;X_Arena0_Ind1;Y_Arena0_Ind1"]
    for f in FRAMES:
        lines.append(";".join(map(str, (f, f / FPS, *WALKERS[0][f], *WALKERS[1][f]))))
    return "\n".join(lines) + "\n"


BY_SECONDS = Units(mm_per_px=SCALE)


@pytest.mark.parametrize(
    ("text", "units", "count", "down", "told"),
    [
        (trackmate(), BY_SECONDS, 2, True, "taken for a file of TrackMate"),
        (trackmate(), PIXELS, 2, True, "y counts rows downward, as TrackMate does: turned over"),
        (trackmate_xml(), BY_SECONDS, 2, True, "taken for a file of TrackMate"),
        (trackmate_whole(), BY_SECONDS, 2, True, "taken for a file of TrackMate"),
        (mtrackj(), PIXELS, 2, True, "taken for a file of MTrackJ"),
        (mtrackj_table(), BY_SECONDS, 2, True, "taken for a file of MTrackJ"),
        (deeplabcut_single(), PIXELS, 1, True, "places are those of the part body, headings from tail to head"),
        (deeplabcut_many(), PIXELS, 2, True, "walkers are numbered: 0 ann, 1 bob"),
        (sleap(), PIXELS, 2, True, "places are the mean of all 2 parts"),
        (idtracker(), BY_SECONDS, 2, True, "taken for a file of idtracker.ai"),
        (idtracker("seconds"), BY_SECONDS, 2, True, "taken for a file of idtracker.ai"),
        (idtracker(""), PIXELS, 2, True, "rows are taken for frames"),
        (idtracker_tidy(), BY_SECONDS, 2, True, "taken for a file of idtracker.ai"),
        (trex(), Units(unit="px", mm_per_px=SCALE), 1, True, "TRex's cm are such only where its cm_per_pixel was set"),
        (fasttrack(), PIXELS, 2, True, "taken for a file of FastTrack"),
        (tracker(), BY_SECONDS, 1, False, "y grows upward, as in Tracker"),
        (tracker(","), BY_SECONDS, 1, False, "taken for a file of Tracker"),
        (tracker(" "), BY_SECONDS, 1, False, "taken for a file of Tracker"),
        (animalta(), PIXELS, 2, False, "walkers are numbered: 0 Arena0_Ind0, 1 Arena0_Ind1"),
    ],
)
def test_the_same_walkers_come_out_of_every_layout(tmp_path, text, units, count, down, told):
    path = tmp_path / "tracks.txt"
    path.write_text(text, encoding="utf-8")
    found = track_files.read_tracks(path, units)
    assert found.interval == pytest.approx(1 / FPS)
    assert len(found.tracks) == count
    assert found.bad_rows == 0
    assert told in found.note
    for track, walker in zip(found.tracks, WALKERS, strict=False):
        np.testing.assert_allclose(track.position, SCALE * walker * (1, -1 if down else 1))
    if "head" in told or "mean of all" in told:
        np.testing.assert_allclose(found.tracks[0].heading, 0.0, atol=1e-12)


def test_units_of_trackmate_count(tmp_path):
    path = tmp_path / "spots.csv"
    path.write_text(trackmate().replace("(pixel)", "(micron)"))
    found = track_files.read_tracks(path, Units())
    np.testing.assert_allclose(found.tracks[0].position, 1e-3 * WALKERS[0] * (1, -1))
    path.write_text(trackmate().replace("(sec)", "(pixel)"))  # no unit of times: they are taken as seconds
    assert track_files.read_tracks(path, BY_SECONDS).interval == pytest.approx(1 / FPS)


def test_parts_that_deeplabcut_is_not_sure_of_do_not_count(tmp_path):
    path = tmp_path / "pose.csv"
    lines = deeplabcut_single().splitlines()
    lines[5] = lines[5].replace("0.99", "0.1")
    path.write_text("\n".join(lines))
    (track,) = track_files.read_tracks(path, PIXELS).tracks
    assert np.flatnonzero(np.isnan(track.position[:, 0])).tolist() == [2]


def test_headings_of_fasttrack_count_counterclockwise_though_its_y_goes_down(tmp_path):
    """As its tracking.cpp has them: 2 pi less the angle in the picture, whose rows go down."""
    ways = [np.arctan2(*reversed(np.gradient(walker, axis=0).T)) for walker in WALKERS]  # in the picture
    path = tmp_path / "tracking.txt"
    lines = rows(lambda f, n, x, y: f"{x}\t{y}\t{(2.0 * np.pi - ways[n][f]) % (2.0 * np.pi)}\t{f}\t{n}")
    path.write_text("xBody\tyBody\ttBody\timageNumber\tid\n" + lines)
    for track, way in zip(track_files.read_tracks(path, PIXELS).tracks, ways, strict=True):
        np.testing.assert_allclose(np.exp(1j * track.heading), np.exp(-1j * way), atol=1e-12)


@pytest.mark.parametrize("mark", ["\t", ",", ";", " "])
def test_tracker_names_one_track_or_several_above_its_columns(tmp_path, mark):
    """As its ExportDataDialog writes them, the marks' frames alone filled in; copied tables have names in one word."""
    path = tmp_path / "data.txt"
    title = ["", "mass A", "", "mass B", "", ""]
    lines = [[f / FPS, *WALKERS[0][f], *(WALKERS[1][f] if f < 9 else ("", ""))] for f in FRAMES]
    table = [title, ["t", *"xyxy", ""], *lines]
    path.write_text("#multi:\n" + "\n".join(mark.join(map(str, row)) for row in table) + "\n")
    one, two = track_files.read_tracks(path, BY_SECONDS).tracks
    np.testing.assert_allclose(one.position, SCALE * WALKERS[0])
    np.testing.assert_allclose(two.position, SCALE * WALKERS[1][:9])
    path.write_text("\n".join(mark.join(map(str, row[:3])) for row in (["", "mass_A"], *table[1:])) + "\n")
    (alone,) = track_files.read_tracks(path, BY_SECONDS).tracks
    np.testing.assert_allclose(alone.position, SCALE * WALKERS[0])


@pytest.mark.parametrize("folders", ["labeled-data/film2.png/", "labeled-data,film2,"])
def test_deeplabcut_names_pictures_in_place_of_frames(tmp_path, folders):
    """Tables of labels, whose rows are pictures: by their paths, or folder by folder as newer versions have them."""
    blank = "," * folders.count(",")
    path = tmp_path / "CollectedData_me.csv"
    head = [f"scorer{blank},me,me", f"bodyparts{blank},body,body", f"coords{blank},x,y"]
    path.write_text(
        "\n".join([*head, *(f"{folders}img{3 * f:04d}.png,{x},{y}" for f, (x, y) in enumerate(WALKERS[0]))])
    )
    found = track_files.read_tracks(path, PIXELS)
    assert found.interval == pytest.approx(3.0 / FPS)
    np.testing.assert_allclose(found.tracks[0].position, SCALE * WALKERS[0] * (1, -1))
    assert "frames are numbered by the names of pictures" in found.note


def test_clusters_of_mtrackj_each_count_their_own_tracks(tmp_path):
    path = tmp_path / "points.csv"
    line = rows(lambda f, n, x, y: f"{2 * f + n},{n + 1},1,{f + 1},{x},{y},{f / FPS}")
    path.write_text("Nr,CID,TID,PID,x [pixel],y [pixel],t [sec]\n" + line)
    found = track_files.read_tracks(path, BY_SECONDS)
    assert "walkers are numbered: 0 TID 1 of CID 1, 1 TID 1 of CID 2" in found.note
    for track, walker in zip(found.tracks, WALKERS, strict=True):
        np.testing.assert_allclose(track.position, SCALE * walker * (1, -1))


@pytest.mark.parametrize("rate", [23.976, 25.0, 29.97, 30.0, 59.94, 60.0, 119.88, 239.76])
def test_times_in_whole_milliseconds_are_of_one_rate(tmp_path, rate):
    """idtracker.ai's of one animal: at 29.97 a second they were refused as irregular."""
    path = tmp_path / "trajectories.csv"
    times = "".join(f"{f / rate:.3f},{f:.3f},1.000\n" for f in range(400))
    path.write_text("time,trajectories1,trajectories2\n" + times)
    found = track_files.read_tracks(path, BY_SECONDS)
    assert found.interval == pytest.approx(1.0 / rate, rel=1e-3)
    np.testing.assert_allclose(found.tracks[0].position[:, 0], SCALE * np.arange(400))


@pytest.mark.parametrize(
    ("header", "line", "told"),
    [
        ("frame,track_id,x1,y1,x2,y2", "{f},{n},{x},{y},{x},{y}", "x1, y1, x2, y2 are corners of boxes"),
        ("frame,xmin,ymin,xmax,ymax", "{f},{x},{y},{x},{y}", "xmin, ymin, xmax, ymax are corners of boxes"),
        ("frame,id,x_mm,y_cm", "{f},{n},{x},{y}", "x_mm and y_cm are of different units"),
        ("frame,id,x_px,y_mm", "{f},{n},{x},{y}", "x_px and y_mm are of different units"),
        ("PK\x03\x04", "", "is a spreadsheet"),
    ],
)
def test_what_would_be_taken_for_walkers_is_named(tmp_path, header, line, told):
    path = tmp_path / "t.csv"
    path.write_text(header + "\n" + rows(lambda f, n, x, y: line.format(f=f, n=n, x=x, y=y)))
    with pytest.raises(InputError, match=told):
        track_files.read_tracks(path, PIXELS)


def test_frames_come_before_times_where_their_rate_is_given_and_it_is_said(tmp_path):
    path = tmp_path / "t.csv"
    path.write_text("frame,t_s,id,x_mm,y_mm\n" + rows(lambda f, n, x, y: f"{f},{f / 50},{n},{x},{y}"))
    tracks = track_files.read_tracks(path, Units(fps=25.0))
    assert tracks.interval == pytest.approx(0.04)
    assert "times are those of frames by ‹fps›, not of t_s" in tracks.note


def test_walkers_whose_run_sets_in_at_once_are_analysed(tmp_path):
    """Three on circles, at 60 mm/s and 0.437 rad/s: the fit's second rate went to infinity, of one seed in thirty."""
    times, rng = np.arange(500) / 50.0, np.random.default_rng(7)
    angle = 0.3 + np.arange(3)[:, None] + 0.437 * times
    x, y = np.sin(angle), -np.cos(angle)
    x, y = (60.0 / 0.437 * (own - own[:, :1]) + rng.normal(0.0, 0.01, (3, 500)) for own in (x, y))
    rows = [f"{t:.4f},{n},{1e3 * x[n, at]:.4f},{1e3 * y[n, at]:.4f}" for n in range(3) for at, t in enumerate(times)]
    path = tmp_path / "t.csv"
    path.write_text("\n".join(["t_s,id,x_um,y_um", *rows]))
    found = motion.analyse(track_files.read_tracks(path, Units())).estimates
    assert found["speed"].value == pytest.approx(60.0, rel=0.001)
    assert found["turning_bias"].value == pytest.approx(0.437, abs=0.001)
