"""Assignments as on a command line: any key of a TOML file, validated as its line is.

Keys are dotted, entries of lists numbered from 1 as in messages: legs[2].tilt_deg.
"""

import copy
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from walkergen.core.errors import InputError
from walkergen.core.files.config import Model, Section, contents, toml_of, unknown, validate

STEP = r"[A-Za-z_]\w*(\[[0-9]{1,4}\])?"
KEY = re.compile(rf"{STEP}(\.{STEP})*")
MOST_LETTERS = 10_000


def split(text: str) -> tuple[str, str]:
    """Key and value, as written, of KEY=VALUE. Raises InputError."""
    key, sign, value = (part.strip() for part in text.partition("="))
    if len(text) > MOST_LETTERS:
        raise InputError(
            f"‹set› {text[:60]!r}...: {len(text)} letters; at most {MOST_LETTERS}: write long values into the TOML file"
        )
    if not sign or not value or not KEY.fullmatch(key):
        raise InputError(
            f"‹set› {text[:60]!r}: write KEY=VALUE with a key of the TOML file, as in "
            "legs.tilt_deg=12, legs[2].friction=0.1 or scene.drive.gamma=2.2"
        )
    return re.sub(r"\[0+(?=[0-9])", "[", key), value


def value_of(text: str) -> Any:
    """Value that a text stands for: a TOML value, or the text itself where it is none (braced).

    Raises InputError for what begins as a list or a table and is none: a shell takes quotes away.
    """
    try:
        data = toml_of(f"value = {text}")
    except ValueError:  # no TOML; a number of more digits than Python reads
        if text.startswith(("[", "{")):
            raise InputError(
                f"‹set› ...={text[:60]!r}: no list or table of TOML, in which words have "
                f"quotes; in a shell quote all: ‹set› 'family.legs=[\"braced\"]'"
            ) from None
        return text
    return data["value"] if len(data) == 1 else text


def check(key: str, model: type[Section], source: str, prefix: str = "") -> None:
    """Raise InputError, which begins with `source`, for a key that a file has not.

    Known keys are told after a prefix.
    """
    _check_form(key, f"{source}: ")
    if reason := unknown(tuple(key.split(".")), model, prefix):
        raise InputError(f"{source}: {reason}")


def read(path: Path, model: type[Model], values: Mapping[str, Any], source: str = "‹set›", prefix: str = "") -> Model:
    """Contents of a TOML file in which these keys have other values, as if they stood in it.

    Files that values name are found from the folder that walkergen runs in. Raises InputError, or
    GeometryError, with a line for every mistake: in the file, else in the values, which begins
    with `source` and tells keys after a prefix.
    """
    return with_data(path, model, values, source, prefix)[0]


def with_data(
    path: Path, model: type[Model], values: Mapping[str, Any], source: str = "‹set›", prefix: str = ""
) -> tuple[Model, dict[str, Any]]:
    """As `read`, with the data that the contents were validated from, for `assigned`."""
    data, text = contents(path, model)
    try:
        settings = validate(data, model, str(path), text)
    except InputError as error:
        if not values:
            raise
        return _mended(error, data, model, values, source, prefix), data
    return (assigned(settings, data, values, source, prefix) if values else settings), data


def _mended(
    error: InputError, data: dict[str, Any], model: type[Model], values: Mapping[str, Any], source: str, prefix: str
) -> Model:
    """Contents of a file with values of which something mends what is wrong in it.

    Raises the error of the file alone where they leave that as it is, else that of all together.
    """
    try:
        return assigned(model.model_construct(), data, values, source, prefix)
    except InputError as other:
        alone, beside = ([line.partition(": ")[2] for line in each.text.splitlines()] for each in (error, other))
        raise (error if alone == beside else other) from None


def changed(section: Model, values: Mapping[str, Any], source: str = "‹set›", prefix: str = "") -> Model:
    """Return a validated copy of a file's contents with other values of these keys.

    Raises InputError, or GeometryError, with a line for every mistake, which begins with `source` and names the key
    after `prefix`.
    """
    if not values:
        return section
    return assigned(section, section.model_dump(exclude_unset=True), values, source, prefix)


def assigned(section: Model, data: dict[str, Any], values: Mapping[str, Any], source: str, prefix: str = "") -> Model:
    """Set keys of data to values, in place, and validate the result; `section` is what the data held before.

    Raises as `changed` does.
    """
    for key, value in values.items():
        _check_form(key, f"{source}: {prefix}")
        try:
            _put(data, key.split("."), _plain(value))
        except InputError as error:
            raise InputError(f"{source}: {prefix}{key}: {error.text}", prefix + key) from None
    return validate(section.without_stale_keys(data, values), type(section), source, prefix=prefix)


def _check_form(key: str, before: str) -> None:
    """Raise InputError for what is not written as a key."""
    if not KEY.fullmatch(key):
        reason = "must be a key of the TOML file, as legs.tilt_deg or legs[2].friction"
        raise InputError(f"{before}{key[:60]!r}: {reason}")


def _plain(value: Any) -> Any:
    """Value as a TOML file gives it: numbers of numpy and paths, which Python's users have, too."""
    if isinstance(value, (np.generic, np.ndarray)):
        return value.tolist()
    return str(value) if isinstance(value, Path) else copy.deepcopy(value)


def _put(data: dict[str, Any], path: list[str], value: Any) -> None:
    """Set the value at the end of a path of keys. Raises InputError for entries that are not there.

    Below a key that holds no table nothing is set that validation would not name.
    """
    place, last = data, path[-1]
    for step in path[:-1]:
        name, number = _numbered(step)
        inner = place.setdefault(name, {}) if number is None else _entries(place, step)[number - 1]
        if not isinstance(inner, dict):
            listed = isinstance(inner, list)
            reason = "is a list: number its entry, from 1" if listed else "is a value, not a table"
            raise InputError(f"{step} {reason}")
        place = inner
    name, number = _numbered(last)
    if number is None:
        place[name] = value
    else:
        _entries(place, last)[number - 1] = value


def _numbered(step: str) -> tuple[str, int | None]:
    """Name of a step of a path, and the number of its entry: 2 of legs[2]; None without."""
    name, _, number = step.rstrip("]").partition("[")
    return name, int(number) if number else None


def _entries(place: Mapping[str, Any], step: str) -> list[Any]:
    """List whose entry a step numbers. Raises InputError where it has no such entry."""
    name, number = _numbered(step)
    entries = place.get(name)
    if not isinstance(entries, list):
        raise InputError(f"there is no {step}: {name} is no list")
    if number is None or not 1 <= number <= len(entries):
        raise InputError(f"there is no {step}: {name} has {len(entries)} entries, from 1")
    return entries
