"""Loading of walkers, scenes and printers: by name, from a file, or as given objects."""

import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Literal, TypeVar, overload

from walkergen.core.errors import InputError
from walkergen.core.files import config
from walkergen.core.files.config import Section
from walkergen.core.printing.printers import Printer
from walkergen.core.scene import Scene
from walkergen.core.walker.design import Design
from walkergen.files import templates as shipped
from walkergen.files.report import Table

Name = str | os.PathLike[str]
"""Name of a template, or path of a TOML file."""

Walker = Design | Name
Ground = Scene | Name
Machine = Printer | Name
Found = TypeVar("Found", Design, Scene, Printer)

KINDS: dict[str, tuple[str, type[Section]]] = {
    "walker": ("walkers", Design),
    "scene": ("scenes", Scene),
    "printer": ("printers", Printer),
}
"""Kinds of files: the folder of their templates, and their contents."""


@overload
def load(name: Name, kind: Literal["walker"]) -> Design: ...
@overload
def load(name: Name, kind: Literal["scene"]) -> Scene: ...
@overload
def load(name: Name, kind: Literal["printer"]) -> Printer: ...
@overload
def load(name: Name, kind: None = None) -> Any: ...


def load(name: Name, kind: str | None = None) -> Any:
    """Load a walker, a scene or a printer: a template by its name, or a TOML file by its path.

    A walker is also a drawing, a picture or a mesh: `wg.load("heart.svg")`.

    A path has an ending, has a / in it (but for published/NAME) or is a Path. `kind` is "walker",
    "scene" or "printer", by default what the name or the file's keys tell. Raises InputError that
    lists the known names or kinds, or every mistake in the file.

    Example: `wg.load("koumakis2016").variant(tilt=12)`
    """
    name = name if isinstance(name, str) else Path(name)
    if kind is None:
        kind = _find_kind(name)
    if kind not in KINDS:
        raise InputError(f"kind={kind!r}: must be one of {', '.join(map(repr, KINDS))}, or left out")
    folder, model = KINDS[kind]
    return shipped.load(name, folder, model)


def templates() -> Table:
    """Table of the shipped walkers, scenes and printers: kind, name, description.

    Example: `wg.templates()["name"]`
    """
    return shipped.list_templates().table


def _find_kind(name: str | Path) -> str:
    """Return the kind of a template by its name, or of a file by its keys. Raises InputError."""
    if isinstance(name, Path) or shipped.is_path(name):
        kinds = _kinds_by_keys(Path(name))
    else:
        kinds = [kind for kind, (folder, _) in KINDS.items() if name in shipped.all_names(folder)]
        if not kinds:
            shipped.find(name)  # raises, with every name there is
    if len(kinds) > 1:
        choices = " or ".join(f"kind={kind!r}" for kind in kinds)
        raise InputError(f"{str(name)!r}: may be more than one thing: give {choices}")
    return kinds[0]


def _kinds_by_keys(path: Path) -> list[str]:
    """Return the kinds of files that share the most keys with a file. Raises InputError."""
    if Design.data_from_file(path) is not None:
        return ["walker"]
    data, _ = config.read_toml(path)
    keys = [key for key in _key_paths(data) if key not in (("name",), ("description",))]
    counts = dict.fromkeys(KINDS, 0)
    for key in keys:
        for kind, (_, model) in KINDS.items():
            own = key[0] == "walker" if kind == "walker" else False  # a table that becomes [body]
            counts[kind] += own or not config.describe_unknown_key(key, model)
    return [kind for kind, count in counts.items() if count == max(counts.values())]


def _key_paths(data: Mapping[str, Any], before: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    """Yield the paths of all keys in tables and nested tables."""
    for key, value in data.items():
        yield (*before, key)
        if isinstance(value, Mapping):
            yield from _key_paths(value, (*before, key))
