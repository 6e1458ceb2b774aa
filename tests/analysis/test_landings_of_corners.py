"""Landings counted by hand: corners, edges and feet."""

import numpy as np

from walkergen.analysis import landings

US = 1e-6


def count(rows, duration=2.0):
    """Landings of rows (time in us, corner)."""
    time, corner = np.array(rows, dtype=float).reshape(-1, 2).T
    return landings.count(US * time, corner.astype(int), duration)


def test_corners_edges_and_feet_are_told_apart():
    found = count(
        [
            (0, 0),
            (1000, 0),
            (1030, 1),  # the back edge
            (2000, 3),
            (2060, 2),  # too late for an edge
            (3000, 1),
            (3020, 2),  # one corner of each foot
            (4000, 2),
            (4010, 3),
            (4045, 0),
        ]
    )
    assert found.corners.tolist() == [3, 2, 3, 2]
    assert found.groups == 6
    assert found.alone == 3
    assert found.edges.tolist() == [1, 1]
    assert found.pairs == 2


def test_order_of_the_rows_does_not_matter():
    rows = [(0, 1), (40, 0), (80, 2), (85, 3)]
    for one, two in zip(count(rows), count(rows[::-1]), strict=True):
        np.testing.assert_array_equal(one, two)


def test_no_landing_is_no_group():
    none = count([])
    assert none.groups == none.pairs == none.corners.sum() == 0
