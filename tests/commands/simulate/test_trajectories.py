"""Trajectories of all runs: one file for trackpy, analyse, numpy and OVITO."""

import re

import numpy as np
import pytest
from scipy.io import netcdf_file
from scipy.spatial.transform import Rotation

from walkergen.analysis import track_files
from walkergen.analysis.track_files import Units
from walkergen.commands.simulate import make, trajectories
from walkergen.commands.simulate.trajectories import TrajectoryData
from walkergen.core.files.progress import silent
from walkergen.core.scene import Scene
from walkergen.core.simulation.plan import prepare
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.files import extended_xyz
from walkergen.points import poses
from walkergen.points.trajectory import Trajectory

WALKER = Design().variant(tilt_deg=10.0)
INTERVAL = 0.01

OVITO = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
"""From the simulation's axes (forward, up, right) to those of the file (forward, left, up)."""


def asked_of(arena, runs=2, seconds=0.06):
    run = {"runs": runs, "seconds": seconds, "discard_seconds": 0.0, "seed": 5}
    scene = Scene.model_validate({"arena": {"kind": arena}, "run": run})
    return make.make_walker(scene, WALKER, solids.mass_of(WALKER), INTERVAL)


def simulated(one):
    return trajectories.collect(one, make.measure(one, silent).results, silent)


def frames_of(text):
    """Extended XYZ as numbers: time, and rows of id, place, quaternion, half axes, of each frame.

    A reader of its own, by the format's definition: a count, a line of keys, a line a particle.
    """
    lines, found = text.splitlines(), []
    while lines:
        count, keys, rows = int(lines[0]), lines[1], lines[2 : 2 + int(lines[0])]
        assert f"Properties={extended_xyz.PROPERTIES}" in keys
        values = np.array([[float(cell) for cell in row.split()[1:]] for row in rows])
        assert values.shape == (count, 11)
        found.append((float(re.search(r"Time=(\S+)", keys)[1]), values))
        lines = lines[2 + count :]
    return found


def test_xarray_reads_all_runs_in_the_layout_of_movement(tmp_path):
    found = simulated(asked_of("plane"))
    own = dict(zip(found.columns, found.rows.T, strict=True))
    path = tmp_path / "all.nc"
    path.write_bytes(trajectories.to_nc(TrajectoryData(found, WALKER)))
    with netcdf_file(path, "r", mmap=False) as file:
        position, heading = file.variables["position"], file.variables["heading"]
        assert position.dimensions == ("time", "space", "keypoint", "individual")
        assert (file.ds_type, file.time_unit) == (b"poses", b"seconds")
        assert file.fps == pytest.approx(1.0 / INTERVAL)
        names = [b"".join(row).rstrip(b"\0").decode() for row in file.variables["individual"][:]]
        for place, name in enumerate(names):
            mine = own["particle"] == int(name.removeprefix("run_"))
            np.testing.assert_array_equal(position[:, 1, 0, place], own["y"][mine])
            np.testing.assert_array_equal(heading[:, place], own["theta"][mine])
        np.testing.assert_array_equal(file.variables["time"][:], own["t_s"][mine])
    xarray = pytest.importorskip("xarray")
    with xarray.open_dataset(path) as data:
        assert list(data.individual.values) == names
        assert list(data.space.values) == ["x", "y"]


def test_all_runs_are_read_back_as_a_film_in_mm_and_as_ours(tmp_path):
    found = simulated(asked_of("plane"))
    path = tmp_path / "all.csv"
    path.write_bytes(trajectories.to_csv(TrajectoryData(found, WALKER)))
    ours = track_files.read_tracks(path, Units())
    assert [one.particle for one in ours.tracks] == [0, 1]
    film = tmp_path / "film.csv"  # as trackpy would have it: its columns alone
    rows = [line.split(",")[:5] for line in path.read_text().splitlines()]
    film.write_text("\n".join(",".join(row) for row in rows))
    theirs = track_files.read_tracks(film, Units(fps=1.0 / INTERVAL, mm_per_px=1.0))
    assert theirs.interval == pytest.approx(ours.interval)
    for one, other in zip(ours.tracks, theirs.tracks, strict=True):
        np.testing.assert_array_equal(one.position, other.position)
        np.testing.assert_array_equal(one.heading, other.heading)


def test_ovito_sees_the_walker_as_it_stood():
    """Places and turns of the file are those of the body, as the movies have them."""
    one = asked_of("plane", runs=1)
    frames = frames_of(trajectories.to_xyz(TrajectoryData(simulated(one), WALKER)).decode())
    seen = poses.sample(prepare(one.scene, WALKER, one.mass), INTERVAL)
    assert [time for time, _ in frames] == pytest.approx(seen.times)
    rows = np.concatenate([rows for _, rows in frames])
    turned = Rotation.from_quat(rows[:, 4:8]).as_matrix()
    np.testing.assert_allclose(turned, OVITO @ seen.rotations @ OVITO.T, atol=1e-8)
    places = rows[:, 1:4] - (rows[0, 1], rows[0, 2], 0.0)
    np.testing.assert_allclose(places, seen.places @ OVITO.T, atol=1e-6)
    assert np.abs(rows[:, 5]).max() > 1e-5  # it did pitch
    np.testing.assert_allclose(rows[:, 8:], len(rows) * [[14.0, 4.0, 1.5]])


def test_large_turns_are_those_of_three_rotations_one_after_the_other():
    angles = np.random.default_rng(3).uniform(-3.0, 3.0, (50, 3))
    heading, pitch, roll = angles.T
    found = extended_xyz.to_quaternions(heading, pitch, roll)
    rival = Rotation.from_euler("ZYX", angles * (1, -1, 1)).as_quat()
    np.testing.assert_allclose(np.abs((found * rival).sum(axis=1)), 1.0, atol=1e-12)
    # By the words of the docstring: the nose up by the pitch, the left side up by the roll.
    forward, left = (Rotation.from_quat(found).apply(axis) for axis in ((1, 0, 0), (0, 1, 0)))
    np.testing.assert_allclose(forward[:, 2], np.sin(pitch), atol=1e-12)
    np.testing.assert_allclose(left[:, 2], np.cos(pitch) * np.sin(roll), atol=1e-12)


def test_a_run_that_ended_early_is_absent_from_later_frames_and_no_run_is_no_frame():
    columns = ("t_s", "particle", "x_mm", "y_mm", "theta_rad", "height_mm", "pitch_rad", "roll_rad")
    rows = np.zeros((3, len(columns)))
    rows[:, 0], rows[:, 1], rows[:, 2], rows[:, 5] = (0.0, 0.01, 0.0), (0, 0, 1), (0.0, 1.0, 5.0), 9.0
    found = trajectories.with_film_columns(Trajectory(columns, rows), 0.01)
    frames = frames_of(trajectories.to_xyz(TrajectoryData(found, WALKER)).decode())
    assert [values[:, 0].tolist() for _, values in frames] == [[0, 1], [0]]
    none = trajectories.with_film_columns(Trajectory(columns, rows[:0]), 0.01)
    assert trajectories.to_xyz(TrajectoryData(none, WALKER)) == b""
    assert trajectories.to_csv(TrajectoryData(none, WALKER)).count(b"\n") == 1


def test_samples_kept_are_not_simulated_again(monkeypatch):
    one = asked_of("lane")
    point = make.measure(one, silent).results
    monkeypatch.setattr(trajectories.walkers, "simulate", None)
    assert len(trajectories.collect(one, point, silent).rows) == 14
