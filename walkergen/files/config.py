"""TOML files that people write: read, validated once, and every mistake reported at once.

A mistake is one line: file and line, key, value seen, what is allowed, and a spelling hint.
"""

import difflib
import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar, get_args, get_origin

import annotated_types
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from walkergen.errors import GeometryError, InputError
from walkergen.files import reading

MOST_BYTES = 1_000_000
NAME_PATTERN = r"^[A-Za-z0-9][A-Za-z0-9_-]{0,63}$"

Name = Annotated[str, Field(pattern=NAME_PATTERN)]
Fraction = Annotated[float, Field(ge=0, le=1)]


class Section(BaseModel):
    """A table of a TOML file: frozen, strict numbers, unknown keys and NaN refused."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)


Model = TypeVar("Model", bound=Section)


def read(path: Path, model: type[Model]) -> Model:
    """Read and validate a TOML file; its stem is the default of `name`.

    Raises InputError that lists every mistake with its line.
    """
    text = reading.text(path, "a TOML file", MOST_BYTES)
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{path}: not valid TOML: {error}") from None
    except RecursionError:
        raise InputError(f"{path}: not valid TOML: nested too deeply") from None
    if not data:
        raise InputError(
            f"{path}: the file sets nothing; start from a template: walkergen templates copy NAME"
        )
    if "name" in model.model_fields:
        data.setdefault("name", path.stem)
    return validate(data, model, str(path), text)


def validate(data: Mapping[str, Any], model: type[Model], source: str, text: str = "") -> Model:
    """Validate plain data; `source` (a file, a flag) and the file's text locate the mistakes."""
    try:
        return model.model_validate(data)
    except GeometryError as error:
        lines = []
        for told in str(error).splitlines():  # each begins with its key
            line = _line_of(_split_key(told.split(" ", 1)[0]), text)
            lines.append(f"{source}:{line}: {told}" if line else f"{source}: {told}")
        raise GeometryError("\n".join(lines)) from None
    except ValidationError as error:
        lines = [_explain(mistake, model, source, text) for mistake in error.errors()]
        raise InputError("\n".join(lines)) from None


def _explain(mistake: Any, model: type[Section], source: str, text: str) -> str:
    location = tuple(str(part) for part in mistake["loc"])
    line = _line_of(location, text)
    where = f"{source}:{line}" if line else source
    key = ".".join(location) or "file"
    if mistake["type"] == "extra_forbidden":
        return f"{where}: {key}: unknown key{_spelling_hint(location, model)}"
    if mistake["type"] == "value_error":  # raised by a table's own check, in full words
        return f"{where}: {key}: {mistake['msg'].removeprefix('Value error, ')}"
    seen = "" if mistake["type"] == "missing" else f" = {_shown(mistake['input'])}"
    return f"{where}: {key}{seen}: {_allowed(location, model) or mistake['msg']}"


def _shown(value: Any) -> str:
    if isinstance(value, dict):
        return "a table"
    shown = repr(value)
    return shown if len(shown) <= 60 else shown[:57] + "..."


def _line_of(location: tuple[str, ...], text: str) -> int | None:
    """Line of a key in TOML text: tables by header, dotted keys joined; None when not found."""
    table: tuple[str, ...] = ()
    for number, line in enumerate(text.splitlines(), start=1):
        if header := re.match(r"\s*\[+\s*([\w.\s\"'-]+?)\s*\]+", line):
            table = _split_key(header[1])
            key = table
        elif pair := re.match(r"\s*([\w.\s\"'-]+?)\s*=", line):
            key = table + _split_key(pair[1])
        else:
            continue
        if key == location[: len(key)] and len(key) >= len(location) - 1 and key != table:
            return number
        if key == location:
            return number
    return None


def _split_key(dotted: str) -> tuple[str, ...]:
    return tuple(part.strip().strip("\"'") for part in dotted.split("."))


def _spelling_hint(location: tuple[str, ...], model: type[Section]) -> str:
    known = [".".join(path) for path in _keys(model)]
    close = difflib.get_close_matches(".".join(location), known, n=1, cutoff=0.6)
    if close:
        return f"; did you mean {close[0]}?"
    table = _model_at(location[:-1], model)
    names = ", ".join(table.model_fields) if table else ", ".join(known)
    return f"; known here: {names}"


def _keys(model: type[Section], prefix: tuple[str, ...] = ()) -> list[tuple[str, ...]]:
    found: list[tuple[str, ...]] = []
    for name, field in model.model_fields.items():
        found.append((*prefix, name))
        inner = _section_of(field.annotation)
        if inner:
            found += _keys(inner, (*prefix, name))
    return found


def _section_of(annotation: Any) -> type[Section] | None:
    for candidate in (annotation, *get_args(annotation)):
        if isinstance(candidate, type) and issubclass(candidate, Section):
            return candidate
    return None


def _model_at(location: tuple[str, ...], model: type[Section]) -> type[Section] | None:
    for name in location:
        field = model.model_fields.get(name)
        inner = _section_of(field.annotation) if field else None
        if inner is None:
            return None
        model = inner
    return model


def _allowed(location: tuple[str, ...], model: type[Section]) -> str:
    """What a key may hold, in words, from the model's own constraints; '' when it has none."""
    table = _model_at(location[:-1], model) if location else None
    field = table.model_fields.get(location[-1]) if table and location else None
    if field is None:
        return ""
    if _section_of(field.annotation):
        return f"must be a table [{location[-1]}] of keys"
    metadata, types = list(field.metadata), [field.annotation]
    while types:
        one = types.pop()
        metadata += getattr(one, "__metadata__", ())
        types += [part for part in get_args(one) if get_origin(one) is not Literal]
        if get_origin(one) is Literal:
            return "must be one of " + ", ".join(repr(choice) for choice in get_args(one))
    if any(getattr(item, "pattern", None) == NAME_PATTERN for item in metadata):
        return "must be 1 to 64 letters, digits, - or _, the first a letter or digit"
    bounds = _bounds(metadata)
    if bounds:
        return f"must be a number {bounds}" + (
            f" ({field.description})" if field.description else ""
        )
    return f"must be {field.description}" if field.description else ""


def _bounds(metadata: list[Any]) -> str:
    words = []
    for item in metadata:
        for part in getattr(item, "metadata", None) or [item]:
            if isinstance(part, annotated_types.Gt):
                words.append(f"> {part.gt:g}")
            elif isinstance(part, annotated_types.Ge):
                words.append(f">= {part.ge:g}")
            elif isinstance(part, annotated_types.Lt):
                words.append(f"< {part.lt:g}")
            elif isinstance(part, annotated_types.Le):
                words.append(f"<= {part.le:g}")
    return " and ".join(words)
