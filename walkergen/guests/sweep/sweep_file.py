"""Sweep described in a file, sweep.toml: the settings of a sweep's command line, to save and share.

Keys of designs and scenes are written in quotes, "legs.tilt_deg" = "0:45:2.5", or as TOML nests
them: legs.tilt_deg = "0:45:2.5".
"""

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, NamedTuple

from pydantic import Field, field_validator

from walkergen.core import InputError, Tolerance, parse_tolerance, shorten_line
from walkergen.core.files import config
from walkergen.core.files.config import Section
from walkergen.guests.sweep import axes, sweep_points
from walkergen.guests.sweep.axes import Axis, Method, Sample, Space, Span
from walkergen.points import model_kinds
from walkergen.points.point import ALONE

Table = dict[str, Any]
"""Values by dotted keys of designs and scenes."""

KEY_TABLES = (("set",), ("grid",), ("sample", "between"))
"""Paths, in a file, of the tables of dotted keys."""

BOUNDS_HINT = 'write two bounds, [2, 40] or "2:40"'


class Samples(Section):
    """Table [sample]: points between bounds, by a Sobol sequence or a Latin hypercube."""

    method: Method = "sobol"
    points: Annotated[int, Field(ge=1, le=axes.MAX_VALUES)]
    """Number of points, of a Sobol sequence best a power of two."""
    between: Annotated[
        Table, Field(description='a table [sample.between], such as legs.width_mm = "2:4"', min_length=1)
    ]


class Contents(Section):
    """Contents of a sweep.toml, as written; names and paths of files are as on a command line."""

    design: Annotated[str | None, Field(description="a template's name or a path")] = None
    scene: Annotated[str | None, Field(description="a template's name or a path")] = None
    printer: Annotated[str | None, Field(description="a template's name or a path")] = None
    model: str | None = None
    error: Annotated[str | None, Field(description='an error as text, "5%" or "3mm/s"')] = None
    seed: Annotated[int, Field(ge=0, le=2**63)] = 1
    """Seed of the samples. The seed of runs is scene.run.seed."""
    keep: Annotated[list[str] | None, Field(description="a list of groups")] = None
    set: Annotated[Table, Field(description='a table [set], such as "legs.foot" = "round"', default_factory=dict)]
    grid: Annotated[Table, Field(description='a table [grid], such as legs.tilt_deg = "0:45:5"', default_factory=dict)]
    sample: Samples | None = None

    @field_validator("model")
    @classmethod
    def _check_model(cls, name: str | None) -> str | None:
        """Return the name of the model. Raises ValueError if it is unknown."""
        if name is not None and name not in model_kinds.ALL_MODELS:
            raise ValueError(f"must be one of {', '.join(model_kinds.ALL_MODELS)}")
        return name

    @field_validator("keep")
    @classmethod
    def _check_groups(cls, names: list[str] | None) -> list[str] | None:
        """Return the names of groups of numbers. Raises ValueError if one is unknown."""
        for name in names or ():
            if not any(name in model_kinds.load_kind(kind).GROUPS for kind in model_kinds.KIND_MODULES):
                groups = {kind: ", ".join(model_kinds.load_kind(kind).GROUPS) for kind in model_kinds.KIND_MODULES}
                allowed = "; ".join(
                    f"for a {kind}: {words}" if kind != ALONE else words for kind, words in groups.items()
                )
                raise ValueError(f"{name[:30]!r}: must be one of {allowed}")
        return names


class SweepFile(NamedTuple):
    """Settings of a sweep from a file; None for settings that the file does not have."""

    path: Path
    design: str | None
    """Design, scene and printer, by name or by path from `folder`."""
    scene: str | None
    printer: str | None
    model: str | None
    error: Tolerance | None
    seed: int
    keep: tuple[str, ...] | None
    constants: dict[str, Any]
    """Values of dotted keys that all points share."""
    space: Space

    @property
    def folder(self) -> Path:
        """Folder of the file; its paths are relative to it."""
        return self.path.parent


def read_sweep(path: Path) -> SweepFile:
    """Read and validate a sweep.toml. Raises InputError with a line for every mistake."""
    data, text = config.read_toml(path)
    if not data:
        raise InputError(f'{path}: the file sets nothing. Write [grid] and "legs.tilt_deg" = "0:45:5"')
    flat = _flatten_tables(data, str(path), text)
    contents = config.validate(flat, Contents, str(path), text)
    mistakes = list(_key_mistakes(contents, str(path), text))
    varied: list[Axis | Span] = []
    error: Tolerance | None = None
    between = contents.sample.between if contents.sample else {}
    for table, values in (("grid", contents.grid), ("sample.between", between)):
        for key, value in values.items():
            start = _message_start(table, key, str(path), text)
            try:
                varied.append((_parse_axis if table == "grid" else _parse_span)(key, value, start))
            except InputError as mistake:
                mistakes.append(mistake.text)
    try:
        error = parse_tolerance(contents.error) if contents.error is not None else None
    except InputError as mistake:
        start = config.format_location(("error",), str(path), text)
        mistakes.append(f"{start}: error: {mistake.text.removeprefix('‹error=›')}")
    if mistakes:
        raise config.mistakes_error(mistakes, path)
    spans = tuple(entry for entry in varied if isinstance(entry, Span))
    sample = None
    if contents.sample is not None:
        sample = Sample(spans, contents.sample.points, contents.sample.method, contents.seed)
    return SweepFile(
        path,
        contents.design,
        contents.scene,
        contents.printer,
        contents.model,
        error,
        contents.seed,
        None if contents.keep is None else tuple(contents.keep),
        dict(contents.set),
        Space(tuple(entry for entry in varied if isinstance(entry, Axis)), sample),
    )


def _message_start(table: str, key: str, source: str, text: str) -> str:
    """Return the beginning of a message on a key of a table: the file's name, the line, and the key.

    `source` and `text`: name and contents of the file.
    """
    location = (*table.split("."), *key.split("."))
    return f"{config.format_location(location, source, text)}: {shorten_line(f'{table}.{key}')}"


def _flatten_tables(data: Mapping[str, Any], source: str, text: str) -> dict[str, Any]:
    """Return a file's data with the tables in KEY_TABLES flattened to dotted keys.

    `source` and `text`: name and contents of the file. Raises InputError for a key that is written in both forms.
    """
    flat = dict(data)
    for *path, last in KEY_TABLES:
        holder = flat
        for step in path:
            if not isinstance(holder.get(step), dict):
                break
            holder[step] = dict(holder[step])
            holder = holder[step]
        else:
            if isinstance(holder.get(last), dict):
                pairs = list(_dotted_pairs(holder[last]))
                holder[last] = dict(pairs)
                for key, _ in pairs:
                    if sum(key == other for other, _ in pairs) > 1:
                        start = _message_start(".".join((*path, last)), key, source, text)
                        raise InputError(f"{start}: given twice, nested and in quotes. Remove one of them.")
    return flat


def _dotted_pairs(table: Mapping[str, Any], before: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the dotted keys of nested tables, and their values. `before`: prefix of the keys."""
    for key, value in table.items():
        if isinstance(value, dict) and value:
            yield from _dotted_pairs(value, f"{before}{key}.")
        else:
            yield before + key, value


def _key_mistakes(contents: Contents, source: str, text: str) -> Iterator[str]:
    """Yield a message for each key that neither design nor scene has, and for each key in two tables."""
    between = contents.sample.between if contents.sample else {}
    seen: dict[str, str] = {}
    tables = (("set", contents.set), ("grid", contents.grid), ("sample.between", between))
    for table, values in tables:
        for key in values:
            start = _message_start(table, key, source, text)
            try:
                sweep_points.check_key(key, start)
            except InputError as mistake:
                yield mistake.text
            if key in seen:
                yield f"{start}: is in [{seen[key]}] too. Remove one of them."
            seen[key] = table


def _parse_axis(key: str, value: Any, start: str) -> Axis:
    """Return the axis of a key from text, a list or one value. Raises InputError, which begins with `start`."""
    if isinstance(value, str):
        axis = axes.from_text(key, value, f"{start} = {value[:60]!r}")
        if isinstance(axis, Span):
            raise InputError(
                f"{start} = {value[:60]!r}: bounds without a step. Write FIRST:LAST:STEP, or use [sample.between]."
            )
        return axis
    values = value if isinstance(value, list) else [value]
    for entry in values:
        if isinstance(entry, str) and re.fullmatch(r"[\s\d.eE+:-]+:[\s\d.eE+:-]+", entry):
            raise InputError(f'{start}: a list cannot contain the range {entry[:60]!r}. Write one text, "0:10:5,20".')
    return axes.make_axis(key, values, start)


def _parse_span(key: str, value: Any, start: str) -> Span:
    """Return the span of a key from text "LOW:HIGH" or two numbers. Raises InputError, which begins with `start`."""
    if isinstance(value, str):
        span = axes.from_text(key, value, f"{start} = {value[:60]!r}")
        if isinstance(span, Span):
            return span
    elif isinstance(value, list) and len(value) == 2:
        low, high = value
        if type(low) in (int, float) and type(high) in (int, float):
            return axes.make_span(key, low, high, start)
    raise InputError(f"{start} = {str(value)[:60]}: {BOUNDS_HINT}")
