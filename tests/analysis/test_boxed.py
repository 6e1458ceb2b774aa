"""Walkers between walls: these are found, kept out of the numbers, and never made up."""

import pytest
from boxed_tracks import Boxed, films
from synthetic_tracks import Walker, film

from walkergen.analysis import motion, walls
from walkergen.core.dish import OPEN_GROUND, Dish

BUG = Boxed(290.0, 3.0, (800.0, 450.0), noise=0.5)
"""What two public films show: a bug in a box, px in place of mm."""

BOX = films(1, 1, 300.0)[0]


def test_walls_are_found_and_free_motion_is_measured():
    blind = motion.analyse(BOX).estimates
    found = walls.find_walls(BOX)
    assert found.extent == pytest.approx((150.0, 150.0), rel=0.02)
    assert 0.05 < found.contacts.value < 0.3
    seen = motion.analyse(BOX, found_walls=found)
    assert "walls about 15" in seen.doubts[0]
    assert "equal times of free motion" in seen.method
    for name, truth in (("speed", 60.0), ("persistence_time", 2.0)):
        low, high = seen.estimates[name].interval(0.95)
        assert low <= truth <= high, name
        assert not blind[name].interval(0.95)[0] <= truth <= blind[name].interval(0.95)[1], name
    assert seen.estimates["speed"].se < 1.0


def test_headings_between_walls_tell_rotational_diffusion():
    tracks = films(2, 1, 200.0, headed=True)[0]
    numbers = motion.analyse(tracks, found_walls=walls.find_walls(tracks)).estimates
    for name, truth in (("speed", 60.0), ("rotational_diffusion", 0.5)):
        low, high = numbers[name].interval(0.95)
        assert low <= truth <= high, name


@pytest.mark.parametrize("wall", ["slide", "turn", "mirror"])
def test_a_bug_s_walls_are_found_in_each_film_and_make_up_no_number(wall):
    """Of 6 films an interval of 95 % misses twice or less in 97 %; without walls speeds are half the truth."""
    made = films(3, 6, 60.0, BUG._replace(wall=wall))
    inside = {"speed": [], "persistence_time": []}
    for tracks in made:
        found = walls.find_walls(tracks)
        assert found is not None
        assert found.extent == pytest.approx(BUG.box, rel=0.03)
        numbers = motion.analyse(tracks, found_walls=found).estimates
        for name, truth in (("speed", BUG.speed), ("persistence_time", BUG.persistence)):
            ends = numbers[name].interval()
            if ends is None:
                assert numbers[name].refused
            else:
                inside[name].append(ends[0] <= truth <= ends[1])
    for name, hits in inside.items():
        assert hits.count(False) <= 2, name


def test_walls_may_be_told():
    told = walls.find_walls(BOX, Dish("rectangle", (170.0, 170.0)))
    assert told.closest == pytest.approx(10.0, abs=0.5)  # a walker is no point
    assert "of ‹arena=›rectangle:170x170" in told.description
    assert walls.find_walls(BOX, OPEN_GROUND) is None


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
        assert walls.find_walls(film(seed, 1, 40.0, walker, 0.04)) is None
        assert walls.find_walls(film(seed, 8, 20.0, walker, 0.04)) is None
