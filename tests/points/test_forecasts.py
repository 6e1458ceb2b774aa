"""Told times of jobs of seconds, against the clock: the one test that needs a machine to itself."""

import os
import time
from types import SimpleNamespace

import pytest

from walkergen.command_table import load_request
from walkergen.core import core_count
from walkergen.core.files.progress import silent
from walkergen.points import store

MAX_LOAD = 0.3
"""Largest load of the machine, per core, at which times mean something."""

LOW, HIGH = 0.67, 1.5
"""Bounds of told over real time: nobody minds to wait half as long again."""

JOBS = {
    "simulate": {"tilt": "10", "runs": 16, "seconds": 40},
    "simulate a turning walker": {"design": "rotator", "runs": 8, "seconds": 80},
    "simulate many legs": {"design": "bristle", "runs": 8, "seconds": 8},
    "simulate a motor": {"design": "coinbot", "runs": 8, "seconds": 80},
    "simulate several tilts": {"tilt": "5,10,15", "runs": 8, "seconds": 40},
    "simulate to an error": {"tilt": "10", "error": "0.5%"},
    "simulate on an open plate": {"scene": "plane-90hz", "tilt": "10", "runs": 8, "seconds": 120},
    "sweep": {"set": ["legs.tilt_deg=5:20:2.5", "scene.run.seconds=8"], "model": "space"},
    "crowd": {"count": 12, "arena": "disc:120", "seconds": 4, "runs": 4},
    "movie": {"seconds": 0.2, "slow": 40.0},
}
"""Values of the requests, by the name of their command and what is special. Each takes 3 to 20 s on two cores."""


def time_job(name, values, folder, monkeypatch):
    """Return the told and the real time of a job from the moment it was told, s; with an empty store of points."""
    folder.mkdir()
    monkeypatch.setattr(store, "caches", SimpleNamespace(folder=lambda name: folder))
    command, told = name.split()[0], []
    out = {"out": folder / ("film.gif" if command == "movie" else "out")} if command in ("movie", "crowd") else {}
    asked = load_request(command).from_values(values | out)
    asked.register_time_callback(lambda find: told.append((find(), time.monotonic())))
    asked.run(silent)
    (expected, at), *_ = told
    return expected.seconds, time.monotonic() - at


@pytest.mark.nightly
def test_told_times_hold(tmp_path, monkeypatch):
    """In one run, so that no job runs beside another."""
    if os.getloadavg()[0] > MAX_LOAD * core_count():
        pytest.skip("other programs are running: no time means anything")
    shares = {}
    for name, values in JOBS.items():
        time_job(name, values, tmp_path / name, monkeypatch)  # compiles kernels, imports matplotlib
        told, real = time_job(name, values, tmp_path / f"{name} again", monkeypatch)
        shares[name] = told / real
    assert {name: share for name, share in shares.items() if not LOW < share < HIGH} == {}
