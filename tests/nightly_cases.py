"""Cases for nightly runs: those that take long, or are much like others."""

import pytest


def mostly_nightly(cases, *some):
    """Mark the cases of a parametrized test as nightly, except some."""
    return [case if case in some else _nightly_case(case) for case in cases]


def _nightly_case(case):
    return pytest.param(*(case if isinstance(case, tuple) else (case,)), marks=pytest.mark.nightly)
