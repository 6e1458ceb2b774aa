"""Walkers between walls: these are found, kept out of the numbers, and never made up."""

import numpy as np
import pytest
from synthetic_tracks import Walker, film

from walkergen.analysis import motion, walls
from walkergen.analysis.tracks import Track, Tracks
from walkergen.dish import OPEN, Dish

FPS, SUBSTEPS = 25.0, 3


def boxed(seed, speed, persistence, size, seconds, reflecting=False, headed=False):
    """Active particle in a box: it slides along walls, or these turn it back."""
    rng, h = np.random.default_rng(seed), 1.0 / FPS / SUBSTEPS
    place, heading, rows = rng.uniform(0, size), rng.uniform(0, 2 * np.pi), []
    kicks = np.sqrt(2 * h / persistence) * rng.normal(size=round(seconds / h))
    for step, kick in enumerate(kicks):
        x, y = place[0] + speed * h * np.cos(heading), place[1] + speed * h * np.sin(heading)
        if reflecting:
            heading = np.pi - heading if not 0 <= x <= size[0] else heading
            heading = -heading if not 0 <= y <= size[1] else heading
        place = min(max(x, 0.0), size[0]), min(max(y, 0.0), size[1])
        heading += kick
        if step % SUBSTEPS == 0:
            rows.append((*place, heading))
    rows = np.array(rows)
    position = rows[:, :2] + 0.1 * rng.normal(size=(len(rows), 2))
    position[rng.random(len(rows)) < 0.05] = np.nan
    return Tracks((Track(0, position, rows[:, 2] if headed else None),), 1.0 / FPS, 0, "")


BOX = boxed(1, 60.0, 2.0, (150.0, 150.0), 200.0)


def test_walls_are_found_and_free_motion_is_measured():
    blind = motion.analyse(BOX).estimates
    found = walls.of(BOX)
    assert found.extent == pytest.approx((150.0, 150.0), rel=0.02)
    assert 0.05 < found.contacts.value < 0.3
    seen = motion.analyse(BOX, found=found)
    assert "walls about 15" in seen.doubts[0]
    for name, truth in (("speed", 60.0), ("persistence_time", 2.0)):
        low, high = seen.estimates[name].interval(0.95)
        assert low <= truth <= high, name
        assert not blind[name].interval(0.95)[0] <= truth <= blind[name].interval(0.95)[1], name
    assert seen.estimates["speed"].se < 1.0


def test_headings_between_walls_tell_rotational_diffusion():
    tracks = boxed(2, 60.0, 2.0, (150.0, 150.0), 200.0, headed=True)
    numbers = motion.analyse(tracks, found=walls.of(tracks)).estimates
    for name, truth in (("speed", 60.0), ("rotational_diffusion", 0.5)):
        low, high = numbers[name].interval(0.95)
        assert low <= truth <= high, name


def test_walls_that_turn_walkers_back_are_found():
    assert walls.of(boxed(3, 60.0, 2.0, (150.0, 100.0), 100.0, reflecting=True)) is not None


def test_walls_may_be_told():
    told = walls.of(BOX, Dish("rectangle", (170.0, 170.0)))
    assert told.closest == pytest.approx(10.0, abs=0.5)  # a walker is no point
    assert "of --arena rectangle:170x170" in told.said
    assert walls.of(BOX, OPEN) is None


@pytest.mark.parametrize(
    "walker",
    [
        Walker(lost=0.0),
        Walker(lost=0.0, turn=2.0, drift=3.0),
        Walker(lost=0.0, turn=8.0, rate=0.05),
        Walker(lost=0.0, diffusion=20.0),
        Walker(lost=0.0, rate=50.0, noise=0.0),
    ],
    ids=["active", "chiral", "circling", "jittering", "diffusive"],
)
def test_free_walkers_have_no_walls(walker):
    for seed in range(4):
        assert walls.of(film(seed, 1, 40.0, walker, 0.04)) is None
        assert walls.of(film(seed, 8, 20.0, walker, 0.04)) is None
