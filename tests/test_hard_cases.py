"""Every hard case over every model to which it applies: planar ones, and those of `selftest`.

A case is written once and run in one way: here are those that test the code alone, in `selftest` those that people
run as well. By day `walkergen selftest`, in the README's tour, runs its own in space; here each is told apart.
"""

import pytest
from hard import balls, bounces, cascades, extremes, friction, landings, steps, symmetries

from walkergen.jobs.trust.selftest.case import SPACE, run_case
from walkergen.jobs.trust.selftest.catalogue import CASES

MODULES = balls, bounces, cascades, extremes, friction, landings, steps, symmetries
PLANAR = [case for module in MODULES for case in module.CASES]

BY_DAY = "space: undamped smooth feet keep their energy", "space: 1e5 s at rest"
"""Cases in space that show by day whether steps give energy, and whether a walker at rest has rates."""


def each(cases):
    """Cases with each of their models, named; when they run is told by marks."""
    for case in cases:
        marks = [pytest.mark.slow] if case in PLANAR else []
        marks += [pytest.mark.nightly] if case.runs_on == SPACE and case.name not in BY_DAY else []
        for model in case.runs_on:
            yield pytest.param(case, model, id=f"{case.section} {case.name}-{model}", marks=marks)


@pytest.mark.parametrize(("case", "model"), [*each([*PLANAR, *CASES])])
def test_hard_case(case, model):
    result = run_case(case, model)
    assert result.holds, [result.error, *result.failing]


def test_names_are_unique_sources_named_and_every_section_is_covered():
    cases = [*PLANAR, *CASES]
    assert len({case.name for case in cases}) == len(cases)
    assert all(len(case.source) > 10 for case in cases)
    assert {case.section for case in cases} >= {"7", *(f"6.{number}" for number in range(1, 16))}
