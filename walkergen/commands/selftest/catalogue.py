"""Catalogue of the hard cases of `walkergen selftest`: closed forms, space and geometry."""

from walkergen.commands.selftest import any_walker, geometry, impacts, meshes, space_contact, space_motion, space_rest
from walkergen.commands.selftest.case import Case


def _sort_key(case: Case) -> tuple[int, ...]:
    """Return the sort key of a case: its section of docs/physics.md by numbers, geometry last."""
    numbers = case.section.split(".")
    return tuple(int(n) for n in numbers) if numbers[0].isdigit() else (99,)


_CASE_MODULES = impacts, space_motion, space_contact, space_rest, any_walker, geometry, meshes

CASES: tuple[Case, ...] = tuple(sorted((case for module in _CASE_MODULES for case in module.CASES), key=_sort_key))
"""Every case, sorted by its section of docs/physics.md."""
