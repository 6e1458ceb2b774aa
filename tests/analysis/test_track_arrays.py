"""Tracks in files of arrays: our own in three formats, movement's in every order, and what is not read."""

import io

import numpy as np
import pytest
from scipy.io import netcdf_file
from test_track_programs import BY_SECONDS, FPS, PIXELS, SCALE, WALKERS
from test_trajectories import WALKER, asked_of, simulated

from walkergen import extras
from walkergen.analysis import track_files
from walkergen.analysis.track_files import Units
from walkergen.commands.simulate import trajectories
from walkergen.commands.simulate.trajectories import TrajectoryData
from walkergen.core.errors import InputError

PLACES = np.stack(WALKERS, axis=-1)[:, :, None]
"""Places of walkers as movement has them: time, space, keypoint, individual."""


def same(tracks, places=WALKERS):
    for track, place in zip(tracks.tracks, places, strict=True):
        np.testing.assert_allclose(track.position, SCALE * place * (1, -1))


@pytest.mark.parametrize(("arena", "lane"), [("plane", False), ("lane", False)])
def test_our_own_runs_are_the_same_from_every_format(tmp_path, arena, lane):
    written = TrajectoryData(simulated(asked_of(arena)), WALKER)
    csv, *others = (_read_back(tmp_path / f"all{suffix}", written) for suffix in (".csv", ".npz", ".nc"))
    assert csv.lane is lane
    for other in others:
        assert other.interval == pytest.approx(csv.interval)
        for one, two in zip(csv.tracks, other.tracks, strict=True):
            assert one.particle == two.particle
            np.testing.assert_array_equal(one.position, two.position)


def _read_back(path, written):
    path.write_bytes(trajectories.FORMATS[path.suffix](written))
    return track_files.read_tracks(path, Units())


def data_set(order=("time", "space", "keypoint", "individual"), plural="", **attributes):
    """File of movement, as its versions before (plural "s") or since 0.17 name dimensions, in some order."""
    stream = io.BytesIO()
    file = netcdf_file(stream, "w", version=2)
    for name, value in ({"ds_type": "poses", "time_unit": "seconds", "source_software": "SLEAP"} | attributes).items():
        setattr(file, name, value)
    full = ("time", "space", "keypoint", "individual")
    named = {name: name + plural * (name in ("keypoint", "individual")) for name in full}
    for name, count in zip(full, PLACES.shape, strict=True):
        file.createDimension(named[name], count)
    for name, words in (("space", ("x", "y")), ("keypoint", ("body",)), ("individual", ("ann", "bob"))):
        trajectories._write_names(file, named[name], words)
    values = {"time": np.arange(12) / FPS if file.time_unit == "seconds" else np.arange(12.0)}
    values["position"] = PLACES.transpose([full.index(name) for name in order])
    file.createVariable("time", "d", ("time",))[:] = values["time"]
    file.createVariable("position", "d", tuple(named[name] for name in order))[:] = values["position"]
    file.createVariable("confidence", "d", ("time",))[:] = np.where(np.arange(12) == 3, 0.1, 0.9)
    return file, stream


def saved(path, held):
    file, stream = held
    file.flush()
    path.write_bytes(stream.getvalue())
    return path


@pytest.mark.parametrize("plural", ["", "s"], ids=["since 0.17", "before"])
@pytest.mark.parametrize(
    "order", [("time", "space", "keypoint", "individual"), ("individual", "keypoint", "space", "time")]
)
def test_dimensions_of_movement_count_by_their_names(tmp_path, order, plural):
    found = track_files.read_tracks(saved(tmp_path / "a.nc", data_set(order, plural)), BY_SECONDS)
    assert found.interval == pytest.approx(1.0 / FPS)
    same(found)


def test_a_data_set_says_its_frames_its_unit_and_how_sure_it_is(tmp_path):
    frames = saved(tmp_path / "frames.nc", data_set(time_unit="frames"))
    with pytest.raises(InputError, match="counts frames"):
        track_files.read_tracks(frames, BY_SECONDS)
    same(track_files.read_tracks(frames, PIXELS))
    held = data_set()
    held[0].variables["position"].space_unit = "cm"
    centimetres = track_files.read_tracks(saved(tmp_path / "cm.nc", held), Units())
    np.testing.assert_allclose(centimetres.tracks[0].position, 10.0 * WALKERS[0] * (1, -1))
    likely = track_files.read_tracks(saved(tmp_path / "dlc.nc", data_set(source_software="DeepLabCut")), BY_SECONDS)
    assert np.flatnonzero(np.isnan(likely.tracks[0].position[:, 0])).tolist() == [3]
    held = data_set()
    held[0].variables["position"].scale_factor = 0.1
    with pytest.raises(InputError, match="position is packed"):
        track_files.read_tracks(saved(tmp_path / "packed.nc", held), BY_SECONDS)


def test_sleaps_arrays_count_by_the_names_of_their_dimensions(tmp_path):
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["tracks"] = PLACES.transpose(0, 3, 2, 1)
        file["tracks"].attrs["dims"] = '["frame", "track", "node", "xy"]'
        file["node_names"], file["track_names"] = [b"body"], [b"ann", b"bob"]
    same(track_files.read_tracks(tmp_path / "a.h5", PIXELS))


def test_columns_of_trex_are_in_its_centimetres(tmp_path):
    x, y = WALKERS[0].T.copy()
    x[3] = np.inf  # TRex's word for not seen
    own = {
        "X#wcentroid": x,
        "Y#wcentroid": y,
        "X": x + 3.0,
        "Y": y,
        "ANGLE": np.full(12, np.inf),
        "time": np.arange(12) / FPS,
        "frame": np.arange(12.0),
    }
    np.savez(
        tmp_path / "film_id0.npz", cm_per_pixel=np.array([0.1]), id=np.array([0]), tracklets=np.ones((2, 2)), **own
    )
    found = track_files.read_tracks(tmp_path / "film_id0.npz", Units())
    place = 10.0 * WALKERS[0] * (1, -1)
    place[3] = np.nan
    np.testing.assert_allclose(found.tracks[0].position, place)
    assert "TRex's cm are such only where its cm_per_pixel was set" in found.note


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (b"\x93NUMPY\x01\x00v\x00", "is an array of numpy: give the table as CSV (idtracker.ai"),
        (b"PAR1\x15\x04", "is a Parquet table"),
        (b"SQLite format 3\x00", "is a database: save the table as CSV (FastTrack: its tracking.txt)"),
        (b"\x80\x04\x95", "is a pickle of Python"),
        (b"PK\x03\x04 and so on", "is a spreadsheet or another archive"),
        (b"PK\x03\x04\x61\x00" + bytes(40), "is a spreadsheet or another archive"),
        (b"CDF\x01 and so on", "is no sound NetCDF file"),
    ],
)
def test_files_of_bytes_that_are_not_read_say_what_to_give(tmp_path, content, told):
    path = tmp_path / "tracks"
    path.write_bytes(content)
    with pytest.raises(InputError) as refused:
        track_files.read_tracks(path, PIXELS)
    assert told in str(refused.value)


@pytest.mark.parametrize(
    ("names", "told"),
    [
        (("frames", "instances", "pred_points"), "is SLEAP's project: give its analysis CSV or HDF5"),
        (("table",), "is an HDF5 file of a layout that is not read; it holds table"),
        (("position", "time"), "no position in x and y with its time"),
    ],
)
def test_other_files_of_hdf5_say_what_to_give(tmp_path, names, told):
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "a.h5", "w") as file:
        for name in names:
            file[name] = np.zeros(3)
    with pytest.raises(InputError, match=told):
        track_files.read_tracks(tmp_path / "a.h5", PIXELS)


def test_hdf5_without_its_extra_is_refused_in_a_line(tmp_path, monkeypatch):
    monkeypatch.setitem(extras.PACKAGES, "poses", {"no_such_module": "h5py"})
    (tmp_path / "a.nc").write_bytes(b"\x89HDF\r\n\x1a\n and so on")
    with pytest.raises(InputError, match=r"a\.nc: HDF5: h5py not installed\. Run pip install 'walkergen"):
        track_files.read_tracks(tmp_path / "a.nc", PIXELS)
