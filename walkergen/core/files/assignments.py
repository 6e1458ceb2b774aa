"""Assignments KEY=VALUE to the keys of a TOML file, from a command line or Python, validated as the file is.

Keys are dotted, entries of lists numbered from 1 as in messages: legs[2].tilt_deg.
"""

import copy
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from walkergen.core.errors import InputError
from walkergen.core.files.config import Model, Section, describe_unknown_key, parse_toml, read_data, validate

STEP_PATTERN = r"[A-Za-z_]\w*(\[[0-9]{1,4}\])?"
KEY_PATTERN = re.compile(rf"{STEP_PATTERN}(\.{STEP_PATTERN})*")
MAX_CHARACTERS = 10_000

BARE_NUMBER_PATTERN = re.compile(r"[+-]?(\d+\.|\.\d+)([eE][+-]?\d+)?")
"""Numbers that begin or end with the point, which TOML does not read."""


def split_key_value(text: str) -> tuple[str, str]:
    """Split "KEY=VALUE" into the texts of key and value. Raises InputError for other text."""
    key, sign, value = (part.strip() for part in text.partition("="))
    if len(text) > MAX_CHARACTERS:
        raise InputError(
            f"‹set› {text[:60]!r}...: {len(text)} letters. At most {MAX_CHARACTERS}: write long values into "
            "the TOML file"
        )
    if not sign or not value or not KEY_PATTERN.fullmatch(key):
        raise InputError(
            f"‹set› {text[:60]!r}: write KEY=VALUE with a key of the TOML file, as in "
            "legs.tilt_deg=12, legs[2].friction=0.1 or scene.drive.gamma=2.2"
        )
    return re.sub(r"\[0+(?=[0-9])", "[", key), value


def parse_value(text: str, key: str = "...") -> Any:
    """Return the TOML value of a text, or the text itself if it is no TOML, such as the bare word braced.

    Numbers may begin or end with the point: .25 and 2. Messages name `key`.

    Raises InputError for an invalid list or table: a shell removes quotes.
    """
    if BARE_NUMBER_PATTERN.fullmatch(text):
        return float(text)
    try:
        data = parse_toml(f"value = {text}")
    except ValueError:  # no TOML; a number of more digits than Python reads
        if text.startswith(("[", "{")):
            raise InputError(
                f"‹set› {key[:60]}={text[:60]!r}: is not a list or table of TOML. Put words in "
                f"quotes, and in a shell quote all: ‹set› 'family.legs=[\"braced\"]'"
            ) from None
        return text
    return data["value"] if len(data) == 1 else text


def check_key(key: str, model: type[Section], source: str, prefix: str = "") -> None:
    """Raise InputError, whose message begins with `source`, for a dotted key that a file of this model cannot have.

    The message lists known keys after `prefix`.
    """
    _check_key_form(key, f"{source}: ")
    if reason := describe_unknown_key(tuple(key.split(".")), model, prefix):
        raise InputError(f"{source}: {reason}")


def read_with_values(
    path: Path, model: type[Model], values: Mapping[str, Any], source: str = "‹set›", prefix: str = ""
) -> Model:
    """Return the validated contents of a TOML file, in which `values`, by dotted keys, replace those of the file.

    Relative paths in the values start from the working directory. Raises InputError, or
    GeometryError, with a line for every mistake: in the file, otherwise in the values. Lines on
    values begin with `source` and list keys after `prefix`.
    """
    return read_with_data(path, model, values, source, prefix)[0]


def read_with_data(
    path: Path, model: type[Model], values: Mapping[str, Any], source: str = "‹set›", prefix: str = ""
) -> tuple[Model, dict[str, Any]]:
    """Return the result of `read_with_values`, and the file's tables with these values before validation."""
    data, text = read_data(path, model)
    try:
        settings = validate(data, model, str(path), text)
    except InputError as error:
        if not values:
            raise
        return _repair_with_values(error, data, model, values, source, prefix), data
    return (assign_values(settings, data, values, source, prefix) if values else settings), data


def _repair_with_values(
    error: InputError, data: dict[str, Any], model: type[Model], values: Mapping[str, Any], source: str, prefix: str
) -> Model:
    """Return the validated contents of a faulty file, if `values`, by dotted keys, replace all that is wrong in it.

    Raises the file's own error if the values do not change it, otherwise the error of file and values.
    """
    try:
        return assign_values(model.model_construct(), data, values, source, prefix)
    except InputError as new_error:
        old, new = ([line.partition(": ")[2] for line in each.text.splitlines()] for each in (error, new_error))
        raise (error if old == new else new_error) from None


def replace_values(section: Model, values: Mapping[str, Any], source: str = "‹set›", prefix: str = "") -> Model:
    """Return a validated copy of `section`, a file's contents, with `values` set by dotted keys.

    Raises InputError, or GeometryError, with a line for every mistake, which begins with `source` and names the key
    after `prefix`.
    """
    if not values:
        return section
    return assign_values(section, section.model_dump(exclude_unset=True), values, source, prefix)


def assign_values(
    section: Model, data: dict[str, Any], values: Mapping[str, Any], source: str, prefix: str = ""
) -> Model:
    """Set dotted keys of `data` to values, in place, and return the validated result.

    `section` has the validated contents of `data` before the change. Raises InputError, or GeometryError, with lines
    that begin with `source` and name keys after `prefix`.
    """
    for key, value in values.items():
        _check_key_form(key, f"{source}: {prefix}")
        try:
            _set_value(data, key.split("."), _to_toml_value(value))
        except InputError as error:
            raise InputError(f"{source}: {prefix}{key}: {error.text}", prefix + key) from None
    return validate(section.adjust_other_keys(data, values), type(section), source, prefix=prefix)


def _check_key_form(key: str, message_start: str) -> None:
    """Raise InputError, whose message begins with `message_start`, for text that has not the form of a dotted key."""
    if not KEY_PATTERN.fullmatch(key):
        reason = "must be a key of the TOML file, as legs.tilt_deg or legs[2].friction"
        raise InputError(f"{message_start}{key[:60]!r}: {reason}")


def _to_toml_value(value: Any) -> Any:
    """Convert NumPy numbers, arrays and paths to values of TOML. Return a copy of another value."""
    if isinstance(value, (np.generic, np.ndarray)):
        return value.tolist()
    return str(value) if isinstance(value, Path) else copy.deepcopy(value)


def _set_value(data: dict[str, Any], path: list[str], value: Any) -> None:
    """Set the value at the end of a path of keys, in place. Missing tables on the way are made.

    Raises InputError if a key on the way holds no table, or if a list has no such entry.
    """
    table, last = data, path[-1]
    for step in path[:-1]:
        name, number = _split_index(step)
        inner = table.setdefault(name, {}) if number is None else _find_list(table, step)[number - 1]
        if not isinstance(inner, dict):
            listed = isinstance(inner, list)
            reason = f"is a list: number its entry, as in {step}[1]" if listed else f"has no keys. Set {step} itself."
            raise InputError(f"{step} {reason}")
        table = inner
    name, number = _split_index(last)
    if number is None:
        table[name] = value
    else:
        _find_list(table, last)[number - 1] = value


def _split_index(step: str) -> tuple[str, int | None]:
    """Split a step of a path into its name and the number of its entry: 2 for legs[2], None without a number."""
    name, _, number = step.rstrip("]").partition("[")
    return name, int(number) if number else None


def _find_list(table: Mapping[str, Any], step: str) -> list[Any]:
    """Return the list in `table` that a step such as legs[2] refers to. Raises InputError without such an entry."""
    name, number = _split_index(step)
    entries = table.get(name)
    if not isinstance(entries, list):
        raise InputError(f"there is no {step}: {name} is not a list. Leave the number out.")
    if number is None or not 1 <= number <= len(entries):
        raise InputError(f"there is no {step}: {name} has {len(entries)} entries, numbered 1 to {len(entries)}")
    return entries
