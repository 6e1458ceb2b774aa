"""The normal distribution in numpy against scipy's."""

import numpy as np
import pytest
from scipy.special import ndtr, ndtri

from walkergen.numerics import normal


def test_quantiles_and_shares_are_those_of_scipy():
    shares = np.r_[1e-300, 1e-12, np.linspace(0.001, 0.999, 999), 1.0 - 1e-15]
    assert normal.quantiles(shares) == pytest.approx(ndtri(shares), rel=1e-13, abs=1e-15)
    for value in (-np.inf, -8.0, -1.0, 0.0, 2.5, np.inf):
        assert normal.below(value) == pytest.approx(ndtr(value), rel=1e-13)
