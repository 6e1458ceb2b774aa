"""Doubts: raised by tracks that are wrong, and by no others."""

import numpy as np
import pytest
from synthetic_tracks import Walker, film

from walkergen.analysis import motion
from walkergen.analysis.tracks import Track

KINDS = {
    "active": Walker(),
    "jittering": Walker(diffusion=100.0),
    "at rest": Walker(speed=0.0, noise=0.2),
    "diffusing": Walker(speed=0.0, diffusion=50.0),
    "chiral": Walker(turn=3.0),
    "inertial": Walker(inertia=0.15),
    "gaps": Walker(lost=0.3, gap=15.0),
}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("walkers", [1, 8])
def test_sound_tracks_raise_no_doubt(kind, walkers):
    heard = [
        doubt for seed in range(6) for doubt in motion.analyse(film(seed, walkers, 20.0, KINDS[kind], 1 / 30)).doubts
    ]
    # A misfit, or a scatter, of one in a hundred may come by chance.
    assert len(heard) <= 1, heard
    assert not any("theta" in doubt or "jump" in doubt or "tracks," in doubt for doubt in heard)


@pytest.mark.parametrize(("turned", "words"), [(90, "at -90 deg"), (-90, "at 90 deg"), (180, "back")])
def test_headings_turned_against_the_tracks_are_noticed(turned, words):
    one = film(1, 8, 10.0)
    changed = tuple(t._replace(heading=t.heading + np.radians(turned)) for t in one.tracks)
    assert any(words in doubt for doubt in motion.analyse(one._replace(tracks=changed)).doubts)


def test_a_jump_of_200_mm_is_noticed_with_its_time():
    one = film(2, 8, 20.0, Walker(lost=0.1), 1 / 30)
    places = one.tracks[3].position.copy()
    places[300:] += [200.0, 0.0]
    tracks = (*one.tracks[:3], one.tracks[3]._replace(position=places), *one.tracks[4:])
    (doubt,) = [d for d in motion.analyse(one._replace(tracks=tracks)).doubts if "jump" in d]
    for words in ("1 in all", "particle 3", "at 10 s"):
        assert words in doubt


def test_walkers_taken_for_one_another_are_noticed():
    one = film(4, 2, 20.0, Walker(lost=0.0), 1 / 30)
    left, right = (t.position for t in one.tracks)
    right = right + np.array([60.0, 0.0])
    swapped = [
        one.tracks[n]._replace(position=np.concatenate([a[:200], b[200:]]))
        for n, (a, b) in enumerate(((left, right), (right, left)))
    ]
    doubts = motion.analyse(one._replace(tracks=tuple(swapped))).doubts
    assert any("2 in all" in doubt for doubt in doubts)


def test_fragments_are_not_taken_for_walkers_without_a_word():
    one = film(3, 8, 20.0, interval=1 / 30)
    parts = [Track(8 + n, t.position[200:], t.heading[200:], None, 200) for n, t in enumerate(one.tracks[:6])]
    first = [t._replace(position=t.position[:190], heading=t.heading[:190]) for t in one.tracks[:6]]
    broken = one._replace(tracks=(*first, *one.tracks[6:], *parts))
    (doubt,) = motion.analyse(broken).doubts
    assert doubt.startswith("14 tracks, but never more than 8 at once")
    assert not motion.analyse(one).doubts
