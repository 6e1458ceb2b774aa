"""Quantiles of t, tails of F and lengths of transforms, held against scipy's, which starting commands do without."""

import math
import subprocess
import sys

import numpy as np
import pytest
from scipy import fft, special

from walkergen.analysis.lag_sums import fft_length
from walkergen.core.numerics.distributions import fisher_tail, student_quantile

FREEDOMS = (0.5, 1.0, 2.0, 3.0, 10.9, 31.0, 100.0, 9.9e3, 1e4)


@pytest.mark.parametrize("freedom", [*FREEDOMS, 1e5, 1e8])
def test_quantiles_of_student_are_those_of_scipy(freedom: float) -> None:
    for probability in (1e-5, 0.025, 0.16, 0.501, 0.84, 0.975, 0.995, 1.0 - 1e-6):
        assert student_quantile(freedom, probability) == pytest.approx(special.stdtrit(freedom, probability), rel=1e-12)
    assert student_quantile(freedom, 0.5) == 0.0


def test_many_degrees_of_freedom_are_normal_and_zero_give_no_bounds() -> None:
    assert student_quantile(math.inf, 0.975) == pytest.approx(special.ndtri(0.975), rel=1e-15)
    assert [student_quantile(1e-3, 0.025), student_quantile(1e-300, 0.975)] == [-math.inf, math.inf]
    assert np.isnan([student_quantile(0.0, 0.975), student_quantile(math.nan, 0.975)]).all()
    assert np.isnan([fisher_tail(3.0, 0.0, 1.0), fisher_tail(3.0, 4.0, math.nan)]).all()


@pytest.mark.parametrize("many", FREEDOMS)
def test_tails_of_fisher_are_those_of_scipy(many: float) -> None:
    for few in (1.0, 2.0, 7.5, 31.0, 1e3):
        for ratio in (0.0, 1e-3, 0.3, 1.0, 1.5, 4.0, 30.0, math.inf):
            assert fisher_tail(few, many, ratio) == pytest.approx(special.fdtrc(few, many, ratio), rel=1e-12)


def test_lengths_that_transform_quickly_are_those_of_scipy() -> None:
    for size in (*range(1, 300), 100_001, 2**20 + 1):
        assert fft_length(size) == fft.next_fast_len(size, real=True)


def test_motion_is_analysed_without_scipy() -> None:
    code = "import sys; from walkergen.analysis import motion, track_warnings; assert 'scipy' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)
