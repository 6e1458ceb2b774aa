"""Every hard case over every model to which it applies, from the one list.

By day `walkergen selftest`, in the README's tour, runs them all; here each is told apart.
"""

import pytest

from walkergen.jobs.selftest.catalogue import CASES

JOBS = [(case, model) for case in CASES for model in case.runs_on]


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("case", "model"), JOBS, ids=[f"{case.section} {case.name}-{model}" for case, model in JOBS]
)
def test_hard_case(case, model):
    checks = list(case.check(model))
    assert checks
    failed = [check for check in checks if not check.holds]
    assert not failed, "\n".join(
        f"{check.what}: {check.value!r} > {check.limit!r} ({check.reason})" for check in failed
    )


def test_names_are_unique_and_every_section_is_covered():
    names = [case.name for case in CASES]
    assert len(set(names)) == len(names)
    assert {case.section for case in CASES} >= {"7", *(f"6.{number}" for number in range(1, 15))}
