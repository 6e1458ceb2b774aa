"""Every hard case of `walkergen selftest`, told apart; by day its command, in the README's tour, runs them as well."""

import pytest

from walkergen.commands.selftest.case import SPACE, run_case
from walkergen.commands.selftest.catalogue import CASES

BY_DAY = "space: undamped smooth feet keep their energy", "space: 1e5 s at rest"
"""Cases in space that show by day whether steps give energy, and whether a walker at rest has rates."""


def each(cases):
    """Cases, named; when they run is told by marks."""
    for case in cases:
        nightly = case.on == SPACE and case.name not in BY_DAY
        yield pytest.param(case, id=f"{case.section} {case.name}", marks=[pytest.mark.nightly] * nightly)


@pytest.mark.parametrize("case", [*each(CASES)])
def test_hard_case(case):
    result = run_case(case)
    assert result.holds, [result.error, *result.failing]


def test_names_are_unique_and_sources_named():
    assert len({case.name for case in CASES}) == len(CASES)
    assert all(len(case.source) > 10 for case in CASES)
