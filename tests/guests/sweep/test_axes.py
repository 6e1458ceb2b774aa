"""Axes of an exploration: what people write, hostile writing, and samples within their bounds."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from walkergen.core.errors import InputError
from walkergen.guests.sweep import axes
from walkergen.guests.sweep.axes import Axis, Sample, Space, Span


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("0:45:15", (0, 15, 30, 45)),
        ("0:1:0.1", (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)),
        ("3:-1:-2", (3, 1, -1)),
        ("0:1:0.4", (0.0, 0.4, 0.8)),
        ("5:5:1", (5,)),
        ("1e3:1.2e3:100", (1000.0, 1100.0, 1200.0)),
        ("0.0001:1e6:5e5", (0.0001, 500000.0001)),
        ("2.5", (2.5,)),
        ("0:2:1,10,20:10:-5", (0, 1, 2, 10, 20, 15)),
        ("1,2,1,2.0", (1, 2)),
        ("1,true", (1, True)),
        ("flexible,braced", ("flexible", "braced")),
        ('"a,b",c', ("a,b", "c")),
        ("'1',1", ("1", 1)),
        ("[[0,0],[1,1]],[[2,2]]", ([[0, 0], [1, 1]], [[2, 2]])),
        ("{a=1,b=2}", ({"a": 1, "b": 2},)),
        ("a:b", ("a:b",)),
    ],
)
def test_values_are_what_was_written(text, values):
    found = axes.parse(f"legs.tilt_deg={text}")
    assert found == Axis("legs.tilt_deg", values)
    assert [type(one) for one in found.values] == [type(one) for one in values]


def test_two_numbers_are_bounds():
    assert axes.parse("legs[2].tilt_deg = -2:4e1") == Span("legs[2].tilt_deg", -2.0, 40.0)


def test_a_key_is_given_once():
    with pytest.raises(InputError, match=r"set b: given 2 times"):
        axes.check_keys([Axis("a", (1,)), Axis("b", (1,)), Span("b", 0, 1)])
    axes.check_keys([Axis("a", (1,)), Axis("b", (1,))])


@given(st.integers(-300, 300), st.integers(0, 200), st.sampled_from([1, 2, 5]), st.integers(-8, 8))
@settings(max_examples=200, deadline=None)
def test_a_range_is_the_decimal_numbers_that_a_person_counts(first, count, step, power):
    """Rival: whole numbers, written with an exponent, so that no sum is rounded."""
    written = [f"{first + step * number}e{power}" for number in range(count + 1)]
    found = axes.parse(f"a={written[0]}:{written[-1]}:{step}e{power}")
    np.testing.assert_array_equal(found.values, [float(word) + 0.0 for word in written])


def test_points_are_all_combinations_the_last_key_fastest():
    grid = (Axis("a", (1, 2)), Axis("b", ("x", "y", "z")))
    space = Space(grid)
    assert list(space.rows()) == list(itertools.product((1, 2), "xyz"))
    assert (space.keys, space.point_count) == (("a", "b"), 6)
    space = Space(grid, Sample((Span("c", 0.0, 1.0), Span("d", 5.0, 6.0)), 3, "latin", 1))
    rows = list(space.rows())
    assert (space.keys, space.point_count, len(rows)) == (("a", "b", "c", "d"), 18, 18)
    assert len({row[2:] for row in rows}) == 3
    assert list(Space(()).rows()) == [()]


SPANS = (Span("a", -2.0, 40.0), Span("b", 1e-7, 3e-7), Span("c", 0.1, 1 / 3), Span("d", 0.0, 3e5))


@pytest.mark.parametrize("method", ["sobol", "latin"])
def test_samples_are_the_same_again_within_bounds_and_even(method):
    count = 64
    space = Space((), Sample(SPANS, count, method, 7))
    rows = np.array(list(space.rows()))
    assert list(Space((), Sample(SPANS, count, method, 7)).rows()) == list(space.rows())
    assert list(Space((), Sample(SPANS, count, method, 8)).rows()) != list(space.rows())
    low, high = np.array([span[1:] for span in SPANS]).T
    assert ((low <= rows) & (rows <= high)).all()
    # One point in each of as many slices, of every key.
    slices = np.floor((rows - low) / (high - low) * count).clip(0, count - 1)
    for column in slices.T:
        np.testing.assert_array_equal(np.sort(column), np.arange(count))


@pytest.mark.parametrize("method", ["sobol", "latin"])
@pytest.mark.parametrize("count", [1, 2, 3, 100])
def test_any_number_of_samples_is_given(method, count):
    rows = list(Space((), Sample(SPANS, count, method, 1)).rows())
    assert len(set(rows)) == count


def test_samples_have_no_more_digits_than_a_table_shows():
    for row in Space((), Sample(SPANS, 200, "sobol", 1)).rows():
        assert all(float(f"{value:.9g}") == value for value in row)
