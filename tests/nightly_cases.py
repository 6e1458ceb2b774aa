"""Cases that wait for the night: those that take long, or are much like others."""

import pytest


def mostly_nightly(cases, *some):
    """Cases of a parametrized test, of which only some run by day."""
    return [case if case in some else _nightly_case(case) for case in cases]


def _nightly_case(case):
    return pytest.param(*(case if isinstance(case, tuple) else (case,)), marks=pytest.mark.nightly)
