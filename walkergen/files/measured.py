"""Measured numbers as people write them: 0.05, or with an error 0.05±0.001 or 0.05+-0.001."""

import re

from walkergen.errors import InputError
from walkergen.files import plain, words

SIGN = re.compile(r"±|\+/?-")
"""Sign before an error."""


def measured(entry: float | str | None, name: str) -> tuple[float | None, float | None]:
    """Read a number above 0 and its standard error in the same unit; None for what is not given.

    Raises InputError, which calls the number by its `name`.
    """
    if entry is None:
        return None, None
    value, *errors = map(words.value, SIGN.split(str(entry)))
    error = errors[0] if errors else 0.0
    if value is None or value <= 0 or len(errors) > 1 or error is None or not 0 <= error < value:
        raise InputError(
            f"{name} {plain.line(str(entry))[:40]}: must be a number above 0, as 0.05, or with its "
            "standard error, at least 0 and below the number, as 0.05±0.001 or 0.05+-0.001"
        )
    return value, error if errors else None
