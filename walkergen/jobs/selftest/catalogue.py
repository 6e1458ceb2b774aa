"""Catalogue of hard cases: a single list for the tests and for `walkergen selftest`."""

from walkergen.jobs.selftest import (
    any_walker,
    bounces,
    extremes,
    friction,
    geometry,
    impacts,
    landings,
    space,
    space_contact,
    space_rest,
    steps,
    symmetries,
)
from walkergen.jobs.selftest.case import Case


def _place(case: Case) -> tuple[int, ...]:
    """Sort key of a case: its section of docs/physics.md by numbers, geometry last."""
    numbers = case.section.split(".")
    return tuple(int(n) for n in numbers) if numbers[0].isdigit() else (99,)


_MODULES = (
    impacts, friction, bounces, landings, steps, symmetries, extremes,
    space, space_contact, space_rest, any_walker, geometry,
)  # fmt: skip

CASES: tuple[Case, ...] = tuple(
    sorted((case for module in _MODULES for case in module.CASES), key=_place)
)
"""Every case, sorted by the section of docs/physics.md that it answers."""
