"""Landings counted by hand: corners, edges, feet, and types by impulse."""

import numpy as np

from walkergen.analysis import landings
from walkergen.theory.impact import Kind

US = 1e-6


def count(rows, duration=2.0):
    """Landings of rows (time in us, corner, impulse, kind)."""
    time, corner, impulse, kind = np.array(rows, dtype=float).reshape(-1, 4).T
    return landings.count(US * time, corner.astype(int), impulse, kind.astype(int), duration)


def test_corners_edges_and_feet_are_told_apart():
    found = count([
        (0, 0, 1.0, Kind.I),
        (1000, 0, 1.0, Kind.I), (1030, 1, 1.0, Kind.I),  # the back edge
        (2000, 3, 1.0, Kind.I), (2060, 2, 1.0, Kind.I),  # too late for an edge
        (3000, 1, 1.0, Kind.I), (3020, 2, 1.0, Kind.I),  # one corner of each foot
        (4000, 2, 1.0, Kind.I), (4010, 3, 1.0, Kind.I), (4045, 0, 1.0, Kind.I),
    ])  # fmt: skip
    assert found.corners.tolist() == [3, 2, 3, 2]
    assert found.groups == 6
    assert found.alone == 3
    assert found.edges.tolist() == [1, 1]
    assert found.pairs == 2


def test_order_of_the_rows_does_not_matter():
    rows = [(0, 1, 1.0, Kind.I), (40, 0, 2.0, Kind.II), (80, 2, 1.0, Kind.III), (85, 3, 1.0, 1)]
    for one, two in zip(count(rows), count(rows[::-1]), strict=True):
        np.testing.assert_array_equal(one, two)


def test_shares_by_impulse_are_not_those_by_number():
    found = count([(0, 0, 1.0, Kind.I), (500, 1, 1.0, Kind.I), (900, 2, 6.0, Kind.II_MIRRORED)])
    assert landings.shares_by_impulse(found) == {Kind.I: 0.25, Kind.II_MIRRORED: 0.75}
    assert dict(zip(found.kinds, found.numbers, strict=True)) == {Kind.I: 2, Kind.II_MIRRORED: 1}


def test_totals_add_up_over_walkers_with_other_types():
    one = count([(0, 0, 1.0, Kind.I), (20, 1, 2.0, Kind.III)], 2.0)
    two = count([(0, 3, 5.0, Kind.II)], 3.0)
    whole = landings.total([one, two])
    assert whole.duration == 5.0
    assert whole.corners.tolist() == [1, 1, 0, 1]
    assert whole.edges.tolist() == [1, 0]
    assert landings.shares_by_impulse(whole) == {Kind.I: 1 / 8, Kind.II: 5 / 8, Kind.III: 2 / 8}


def test_no_landing_is_no_share():
    none = count([])
    assert none.groups == 0
    assert landings.shares_by_impulse(landings.total([none, none])) == {}
