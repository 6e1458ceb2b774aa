"""Every hard case over every model to which it applies: planar ones, and those of `selftest`.

A case is written once: here are those that test the code alone, in `selftest` those that people run as
well. By day `walkergen selftest`, in the README's tour, runs its own in space; here each is told apart.
"""

import pytest
from hard import balls, bounces, cascades, extremes, friction, landings, steps, symmetries

from walkergen.jobs.trust.selftest.case import SPACE
from walkergen.jobs.trust.selftest.catalogue import CASES

MODULES = balls, bounces, cascades, extremes, friction, landings, steps, symmetries
PLANAR = [case for module in MODULES for case in module.CASES]
QUICK = [case for case in CASES if case.runs_on != SPACE]
IN_SPACE = [case for case in CASES if case.runs_on == SPACE]


def each(cases):
    """Cases with each of their models, named."""
    return [
        pytest.param(case, model, id=f"{case.section} {case.name}-{model}") for case in cases for model in case.runs_on
    ]


def check(case, model):
    checks = list(case.check(model))
    assert checks
    failed = [check for check in checks if not check.holds]
    assert not failed, "\n".join(
        f"{check.what}: {check.value!r} > {check.limit!r} ({check.reason})" for check in failed
    )


@pytest.mark.slow
@pytest.mark.parametrize(("case", "model"), each(PLANAR))
def test_planar_hard_case(case, model):
    check(case, model)


@pytest.mark.parametrize(("case", "model"), each(QUICK))
def test_hard_case_of_an_impact_or_a_solid(case, model):
    check(case, model)


def test_steps_give_no_energy_to_an_undamped_walker_without_friction():
    """The shortest case of contacts in space that would show it, by day."""
    (case,) = [case for case in IN_SPACE if case.name == "space: undamped smooth feet keep their energy"]
    check(case, "space")


def test_a_walker_at_rest_has_no_rates_and_its_energy_is_booked():
    (case,) = [case for case in IN_SPACE if case.name == "space: 1e5 s at rest"]
    check(case, "space")


@pytest.mark.nightly
@pytest.mark.parametrize(("case", "model"), each(IN_SPACE))
def test_hard_case_in_space(case, model):
    check(case, model)


def test_names_are_unique_sources_named_and_every_section_is_covered():
    cases = [*PLANAR, *CASES]
    assert len({case.name for case in cases}) == len(cases)
    assert all(len(case.source) > 10 for case in cases)
    assert {case.section for case in cases} >= {"7", *(f"6.{number}" for number in range(1, 16))}
