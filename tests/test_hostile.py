"""Hostile tries by class: refused in one clear line or done, nothing half-written."""

import os
import sys

import hostile
import pytest

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="forks, and limits memory")

SEED = int(os.environ.get("WALKERGEN_HOSTILE_SEED", "16"))
TRIES = int(os.environ.get("WALKERGEN_HOSTILE_TRIES", "2400"))


def judged(tries, folder):
    """Faults of tries, with what was tried."""
    found = []
    for number, one in enumerate(tries):
        place = folder / f"t{number}"
        place.mkdir()
        seen = hostile.run(one, place)
        if told := hostile.faults(one, seen):
            found.append((number, one.label, told, one.words, seen.err[-500:]))
    return found


@pytest.mark.parametrize("kind", ["keys", "names", "kinds", "cells", "commands"])
def test_a_few_hostile_tries_of_each_kind(kind, tmp_path):
    assert not judged(hostile.drawn(SEED, 8, kind), tmp_path)


@pytest.mark.nightly
def test_thousands_of_hostile_tries(tmp_path):
    family = tmp_path / "family"
    family.mkdir()
    hostile.make_family(family)
    assert not judged(hostile.drawn(SEED, TRIES), tmp_path)
