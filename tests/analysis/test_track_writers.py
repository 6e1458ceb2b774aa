"""Tracks as the programs themselves write them: tests/data/tracks says which, and what was put in."""

from pathlib import Path

import numpy as np
import pytest
from test_track_programs import BY_SECONDS, FPS, PIXELS, SCALE, WALKERS

from walkergen.analysis import track_files
from walkergen.analysis.track_files import Units

FILMS = Path(__file__).parents[1] / "data" / "tracks"
UNSEEN = [4, 5]
"""Frames in which the second walker is not seen."""

ORIGIN, PER_UNIT = (20.0, 300.0), 2.0
"""Origin of Tracker's axes, pixels, and pixels to its unit."""


def as_put_in(down=True):
    """Places of the walkers, mm, with y upward."""
    places = [SCALE * walker * (1, -1 if down else 1) for walker in WALKERS]
    places[1][UNSEEN] = np.nan
    return places


def of_tracker(turned=0.0):
    """Places of the walkers in Tracker's axes, which are turned counterclockwise."""
    cos, sin = np.cos(np.radians(turned)), np.sin(np.radians(turned))
    places = [(walker - ORIGIN) * (1, -1) / PER_UNIT @ [[cos, -sin], [sin, cos]] for walker in WALKERS]
    places[1][UNSEEN] = np.nan
    return places


MILLIMETRES = Units(unit="mm")


@pytest.mark.parametrize(
    ("name", "units", "places", "told"),
    [
        ("sleap.csv", PIXELS, as_put_in(), "headings from tail to head; walkers are numbered: 0 walker_0, 1 walker_1"),
        ("sleap.analysis.h5", PIXELS, as_put_in(), "headings from tail to head; walkers are numbered: 0 walker_0"),
        ("movement.nc", BY_SECONDS, as_put_in(), "taken for a file of movement"),
        ("movement3.nc", BY_SECONDS, as_put_in(), "walkers are numbered: 0 ann, 1 bob"),
        ("deeplabcut_one.csv", PIXELS, as_put_in()[:1], "taken for a file of DeepLabCut"),
        ("deeplabcut_many.csv", PIXELS, as_put_in(), "walkers are numbered: 0 ann, 1 bob"),
        ("idtracker.csv", BY_SECONDS, as_put_in(), "taken for a file of idtracker.ai"),
        ("idtracker_one.csv", BY_SECONDS, as_put_in()[:1], "taken for a file of idtracker.ai"),
        ("idtracker_tidy.csv", BY_SECONDS, as_put_in(), "2 bad rows left out"),
        ("idtracker.h5", BY_SECONDS, as_put_in(), "taken for a file of idtracker.ai"),
        ("trackpy.csv", PIXELS, as_put_in(down=False), "y is taken to grow upward"),
        ("trackmate.csv", BY_SECONDS, as_put_in(), "line 27: TRACK_ID is 'ø'"),
        ("trackmate_tracks.xml", BY_SECONDS, as_put_in(), "taken for a file of TrackMate"),
        ("tracker_one.txt", MILLIMETRES, of_tracker()[:1], "y grows upward, as in Tracker"),
        ("tracker_two.txt", MILLIMETRES, of_tracker(), "walkers are numbered: 0 mass A, 1 mass B"),
        ("tracker_turned.txt", MILLIMETRES, of_tracker(30.0), "walkers are numbered: 0 mass A, 1 mass B"),
        ("tracker.trk", MILLIMETRES, of_tracker(), "walkers are numbered: 0 mass A, 1 mass B"),
        ("tracker_turned.trk", MILLIMETRES, of_tracker(30.0), "taken for a file of Tracker"),
    ],
)
def test_what_was_put_in_comes_out_of_what_programs_write(name, units, places, told):
    if name.endswith((".h5", "movement.nc")):
        pytest.importorskip("h5py")
    found = track_files.read_tracks(FILMS / name, units)
    assert found.interval == pytest.approx(1.0 / FPS)
    assert told in found.note
    assert len(found.tracks) == len(places)
    for track, place in zip(found.tracks, places, strict=True):
        # Tracker writes seven digits
        np.testing.assert_allclose(track.position, place, atol=1e-4)
        if "headings" in told:
            np.testing.assert_allclose(track.heading[np.isfinite(track.heading)], 0.0, atol=1e-12)
