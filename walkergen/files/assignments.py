"""Assignments KEY=VALUE, as on a command line: any key of a TOML file, validated as its line is.

Keys are dotted, entries of a list of tables numbered from 1 as in messages: legs[2].tilt_deg.
"""

import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from walkergen.errors import InputError
from walkergen.files.config import Model, Section, unknown, validate

KEY = re.compile(r"[A-Za-z_]\w*(\[[0-9]{1,4}\])?(\.[A-Za-z_]\w*(\[[0-9]{1,4}\])?)*")
MOST_LETTERS = 10_000


def split(text: str, option: str = "--set") -> tuple[str, str]:
    """Key and value, as written, of KEY=VALUE. Raises InputError."""
    key, sign, value = (part.strip() for part in text.partition("="))
    if not sign or not value or not KEY.fullmatch(key) or len(text) > MOST_LETTERS:
        raise InputError(
            f"{option} {text[:60]!r}: write KEY=VALUE with a key of the TOML file, as in "
            "legs.tilt_deg=12, legs[2].friction=0.1 or scene.drive.gamma=2.2"
        )
    return key, value


def value_of(text: str) -> Any:
    """Value that a text stands for: a TOML value, or the text itself where it is none (braced)."""
    try:
        found = tomllib.loads(f"value = {text}")
    except (tomllib.TOMLDecodeError, RecursionError):
        return text
    return found["value"] if len(found) == 1 else text  # lines of their own below it are no value


def check(key: str, model: type[Section], source: str) -> None:
    """Raise InputError, which begins with `source`, for a key that a file has not."""
    if told := unknown(tuple(key.split(".")), model):
        raise InputError(f"{source}: {told}")


def changed(section: Model, values: Mapping[str, Any], source: str = "--set") -> Model:
    """Validated copy of a file's contents with other values of these keys.

    Raises InputError, or GeometryError, with a line for every mistake, which begins with `source`.
    """
    if not values:
        return section
    data: dict[str, Any] = section.model_dump(exclude_unset=True)
    for key, value in values.items():
        _put(data, key, value, source)
    data = section.settled(data, values)
    return validate(section.beside(data, Path()), type(section), source)


def _put(data: dict[str, Any], key: str, value: Any, source: str) -> None:
    """Set the value at the end of a dotted key. Raises InputError for entries that are not there.

    Below a key that holds no table nothing is set that validation would not name.
    """
    *path, last = key.split(".")
    place: Any = data
    for step in path:
        name, _, number = step.rstrip("]").partition("[")
        if not number:
            place = place.setdefault(name, {})
        else:
            entries = place.get(name)
            count = len(entries) if isinstance(entries, list) else 0
            if not 1 <= int(number) <= count:
                raise InputError(
                    f"{source}: {key}: there is no {step}: "
                    + (f"{name} has {count} entries" if count else f"{name} is no list of tables")
                )
            place = entries[int(number) - 1]
        if not isinstance(place, dict):
            told = (
                "is a list: number its entry, from 1" if isinstance(place, list) else "is a value"
            )
            raise InputError(f"{source}: {key}: {step} {told}, not a table")
    place[last] = value
