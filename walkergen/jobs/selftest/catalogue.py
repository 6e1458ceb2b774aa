"""The list of hard cases: one registry for the tests and for `walkergen selftest`."""

from walkergen.jobs.selftest import (
    bounces,
    extremes,
    friction,
    geometry,
    impacts,
    landings,
    symmetries,
)
from walkergen.jobs.selftest.case import Case


def _place(case: Case) -> tuple[int, ...]:
    """Sections of physics.md by their numbers, geometry last."""
    numbers = case.section.split(".")
    return tuple(int(n) for n in numbers) if numbers[0].isdigit() else (99,)


_MODULES = (impacts, friction, bounces, landings, symmetries, extremes, geometry)

CASES: tuple[Case, ...] = tuple(
    sorted((case for module in _MODULES for case in module.CASES), key=_place)
)
"""Every case, by the section of physics.md it answers."""
