"""Doubts: raised by tracks that are wrong, and by no others."""

import numpy as np
import pytest
from nightly_cases import mostly_nightly
from synthetic_tracks import Walker, film

from walkergen.analysis import motion, track_warnings
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


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("walkers", mostly_nightly([1, 8], 1))
def test_sound_tracks_raise_no_doubt(kind, walkers):
    films = [film(seed, walkers, 20.0, KINDS[kind], 1 / 30) for seed in range(6)]
    assert not any(map(track_warnings.find_all, films))
    heard = [doubt for one in films for doubt in motion.analyse(one).doubts]
    # A misfit, or a scatter, of one in a hundred may come by chance.
    assert len(heard) <= 1, heard


@pytest.mark.parametrize(
    ("turned", "words"),
    [
        (lambda rng, theta: theta + 0.5 * np.pi, "at -90 deg"),
        (lambda rng, theta: theta - 0.5 * np.pi, "at 90 deg"),
        (lambda rng, theta: theta + np.pi, "backwards"),
        (lambda rng, theta: -theta, "mirrored"),
        (lambda rng, theta: theta + np.pi * rng.integers(0, 2, len(theta)), "half turn"),
    ],
)
def test_headings_that_cannot_be_right_are_doubted(turned, words):
    rng, one = np.random.default_rng(1), film(1, 8, 10.0)
    changed = tuple(track._replace(heading=turned(rng, track.heading)) for track in one.tracks)
    assert any(words in doubt for doubt in track_warnings.find_all(one._replace(tracks=changed)))


def test_a_jump_of_200_mm_is_noticed_with_its_time():
    one = film(2, 8, 20.0, Walker(lost=0.1), 1 / 30)
    places = one.tracks[3].position.copy()
    places[300:] += [200.0, 0.0]
    tracks = (*one.tracks[:3], one.tracks[3]._replace(position=places), *one.tracks[4:])
    (doubt,) = [d for d in track_warnings.find_all(one._replace(tracks=tracks)) if "jump" in d]
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
    assert any("2 in all" in doubt for doubt in track_warnings.find_all(one._replace(tracks=tuple(swapped))))


def test_fragments_are_not_taken_for_walkers_without_a_word():
    one = film(3, 8, 20.0, interval=1 / 30)
    parts = [Track(8 + n, t.position[200:], t.heading[200:], None, 200) for n, t in enumerate(one.tracks[:6])]
    first = [t._replace(position=t.position[:190], heading=t.heading[:190]) for t in one.tracks[:6]]
    broken = one._replace(tracks=(*first, *one.tracks[6:], *parts))
    (doubt,) = track_warnings.find_all(broken)
    assert doubt.startswith("14 tracks, but at most 8 at one time")
    assert not track_warnings.find_all(one)
