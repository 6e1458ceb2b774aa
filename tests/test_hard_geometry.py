"""Geometry's hard cases, from the package's own list."""

import pytest

from walkergen.hard_cases.geometry import CASES


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_a_hard_case_of_geometry_holds(case):
    for model, method in case.runs_on:
        checks = list(case.check(model, method))
        assert checks
        for check in checks:
            assert check.value <= check.limit, check
