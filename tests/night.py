"""Cases that wait for the night: each compiles a kernel of its own, for half a minute."""

import pytest


def at_night(cases, but):
    """Cases of a parametrized test, of which by day only `but` runs."""
    return [case if case == but else pytest.param(case, marks=pytest.mark.nightly) for case in cases]
