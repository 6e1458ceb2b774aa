"""Quantities: their bounds hold, and noise makes no two of them agree."""

import math
from itertools import product

import numpy as np
import pytest
from scipy import stats

from evidence.quantities import compare, ratio
from walkergen.core.numerics.quantity import Quantity, Verdict, exact, mean


def test_bounds_are_students_and_of_a_variance_chi_squared():
    speed = Quantity("speed", "mm_s", 56.5, 0.5, freedom=7)
    assert speed.interval(0.95) == pytest.approx(stats.t.interval(0.95, 7, 56.5, 0.5))
    assert speed.column == "speed_mm_s"
    assert speed.pair == (56.5, 0.5)
    with pytest.raises(ValueError, match="no headings"):
        _ = Quantity("turning", "rad2_s", None, refused="no headings").pair
    variance = Quantity("scatter", "mm2", 4.0, 1.0, freedom=9, noise=1.0)
    low, high = variance.interval(0.95)
    assert (low + 1.0, high + 1.0) == pytest.approx((45.0 / stats.chi2.ppf(0.975, 9), 45.0 / stats.chi2.ppf(0.025, 9)))
    root = variance._replace(value=2.0, power=2)
    assert root.interval(0.95) == pytest.approx((math.sqrt(low), math.sqrt(high)))
    time = variance._replace(value=0.25, noise=0.0, power=-1)  # 1 over a rate that is a variance of 4
    assert time.interval(0.95) == pytest.approx([stats.chi2.ppf(tail, 9) / 36.0 for tail in (0.025, 0.975)])
    assert exact("g", "mm_s2", 9806.65).interval() == (9806.65, 9806.65)
    assert Quantity("turning", "rad2_s", None, refused="no headings").interval() is None
    assert speed.number == 56.5
    with pytest.raises(ValueError, match="no headings"):
        _ = Quantity("turning", "rad2_s", None, refused="no headings").number


def test_a_variance_reported_only_when_large_keeps_its_lower_bound():
    """Of 5000 variances of 3 values, those above a threshold: without it 11 % lie wholly above the truth."""
    rng = np.random.default_rng(3)
    totals = 2.0 * rng.chisquare(2, 5000) / 2.0
    told = [
        Quantity("scatter", "mm2", total - 1.0, 1.0, freedom=2, noise=1.0, least=4.0) for total in totals if total > 4.0
    ]
    above = np.mean([number.interval()[0] > 1.0 for number in told])
    assert above == pytest.approx(0.025, abs=3.5 * math.sqrt(0.025 / len(told)))
    naive = np.mean([number._replace(least=0.0).interval()[0] > 1.0 for number in told])
    assert naive > 0.1
    assert all(number.interval()[1] == number._replace(least=0.0).interval()[1] for number in told)


def test_a_bias_widens_bounds_in_squares_and_stays_in_differences():
    one = Quantity("speed", "mm_s", 5.0, 1.0, freedom=7)
    half, biased = one.half_width(), one._replace(bias=3.0)
    assert biased.half_width() == pytest.approx(math.hypot(half, 3.0))
    assert biased.half_width(0.68) == pytest.approx(math.hypot(one.half_width(0.68), 1.5))
    assert biased.minus(biased).bias == pytest.approx(math.sqrt(18.0))
    assert one._replace(bias=math.inf).interval() is None


def test_ninety_five_of_a_hundred_bounds_of_a_mean_hold_the_truth():
    random, tries = np.random.default_rng(1), 4000
    ends = [mean("x", "", random.normal(3.0, 2.0, 6)).interval(0.95) for _ in range(tries)]
    inside = sum(low <= 3.0 <= high for low, high in ends) / tries
    assert abs(inside - 0.95) < 4.0 * math.sqrt(0.95 * 0.05 / tries)  # four standard errors of a share


def test_the_noisier_a_number_the_less_it_agrees():
    published = exact("speed", "mm_s", 60.0)
    for se, verdict in ((0.5, Verdict.AGREE), (4.0, Verdict.UNDECIDED), (100.0, Verdict.UNDECIDED)):
        assert compare(Quantity("speed", "mm_s", 61.0, se), published, margin=0.1) == verdict
    assert compare(Quantity("speed", "mm_s", 80.0, 1.0), published, margin=0.1) == Verdict.DISAGREE
    assert compare(Quantity("speed", "mm_s", 61.0, 0.0), published) == Verdict.DISAGREE
    assert compare(Quantity("speed", "mm_s", 61.0), published, margin=0.1) == Verdict.UNDECIDED
    assert compare(Quantity("speed", "mm_s", None, refused="fell"), published) == Verdict.MISSING
    assert Quantity("order", "", 0.3, 0.01).compare_with_range(-math.inf, 0.5) == Verdict.AGREE


def test_differences_and_ratios_carry_both_errors():
    one, two = mean("a", "mm", [1.0, 2.0, 4.0]), mean("a", "mm", [7.0, 9.0, 8.0, 6.0])
    welch = stats.ttest_ind([1.0, 2.0, 4.0], [7.0, 9.0, 8.0, 6.0], equal_var=False)
    gap = one.minus(two)
    assert gap.freedom == pytest.approx(welch.df)
    assert gap.value / gap.se == pytest.approx(welch.statistic)
    quotient = ratio(Quantity("a", "mm", 10.0, 0.3), Quantity("b", "mm", 5.0, 0.1))
    drawn = np.random.default_rng(2).normal([10.0, 5.0], [0.3, 0.1], (20000, 2))
    # Of 20 000 draws 0.5 %, second order 1 %
    assert quotient.se == pytest.approx(np.std(drawn[:, 0] / drawn[:, 1]), rel=0.03)


@pytest.mark.parametrize("power", [-1, 1, 2])
@pytest.mark.parametrize("freedom", [0.0, 1e-6, 1e-3, 0.3, 1.0, 15.0, 1e30, math.inf])
def test_bounds_are_finite_or_there_are_none(freedom, power):
    """JSON has no infinity, and a variance with hardly any degrees of freedom has no upper bound that is a double."""
    values, errors, biases, floors = (1e-100, 1e-12, 1.0, 1e100), (0.0, 1e-9, 1e9), (0.0, 1.0, math.inf), (0.0, 1.0)
    for value, se, bias, noise, least in product(values, errors, biases, (None, 0.0, 1.0), floors):
        number = Quantity("x", "s", value, se, freedom, noise=noise, power=power, least=least, bias=bias)
        ends = number.interval()
        assert ends is None or all(map(math.isfinite, ends)), number
        assert ends is None or noise is None or freedom > 1e-6, number
        assert not math.isnan(number.half_width())


def test_bounds_of_draws_are_their_ends_and_rows_have_columns():
    drawn = Quantity("speed", "mm_s", 50.0, 1.0, ends=(40.0, 45.0, 57.0, 70.0))
    assert (drawn.interval(), drawn.interval(0.68), drawn.half_width()) == ((40.0, 70.0), (45.0, 57.0), 15.0)
    assert drawn._replace(value=None).interval() is None
    names = "speed_mm_s", "speed_se_mm_s", "speed_low_95_mm_s", "speed_high_95_mm_s"
    assert drawn.row(95) == dict(zip(names, (50.0, 1.0, 40.0, 70.0), strict=True))
    assert list(drawn.row(95, stem="")) == ["speed_mm_s", "se_mm_s", "low_95_mm_s", "high_95_mm_s"]
    assert Quantity("ratio", "", 2.0).row() == {"ratio": 2.0, "ratio_se": None}
