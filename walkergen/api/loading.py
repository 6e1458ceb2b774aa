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

Walker = Design | Name  # types of arguments that name or contain a walker, a scene or a printer
Ground = Scene | Name
Machine = Printer | Name
Found = TypeVar("Found", Design, Scene, Printer)

KINDS: dict[str, tuple[str, type[Section]]] = {
    "walker": ("walkers", Design),
    "scene": ("scenes", Scene),
    "printer": ("printers", Printer),
}
"""Folder of the templates, and class of the contents, by the kind of a file."""


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

    A walker is also read from a drawing, a picture or a mesh, as in `wg.load("heart.svg")`.

    Parameters
    ----------
    name : str or PathLike
        Name of a template, or path of a file. A path has an ending, contains a / (except published/NAME) or is a Path.
    kind : {"walker", "scene", "printer"}, optional
        Kind of the file; by default that of the template, or of the file's keys.

    Returns
    -------
    Design, Scene or Printer
        Contents of the file, validated.

    Raises
    ------
    InputError
        If the name or kind is unknown, or the file has mistakes. The message lists the names, or every mistake.

    Examples
    --------
    >>> import walkergen as wg
    >>> wg.load("koumakis2016").variant(tilt=12)
    <Design koumakis2016: 2 flexible legs, tilt 12 deg, body 28 x 8 x 3 mm>
    """
    name = name if isinstance(name, str) else Path(name)
    if kind is None:
        kind = _find_kind(name)
    if kind not in KINDS:
        raise InputError(f"kind={kind!r}: must be one of {', '.join(map(repr, KINDS))}, or left out")
    folder, model = KINDS[kind]
    return shipped.load(name, folder, model)


def templates() -> Table:
    """List the shipped walkers, scenes and printers.

    Returns
    -------
    Table
        A row for each template: kind, name, description.

    Examples
    --------
    >>> import walkergen as wg
    >>> "koumakis2016" in wg.templates()["name"]
    True
    """
    return shipped.list_templates().table


def _find_kind(name: str | Path) -> str:
    """Return "walker", "scene" or "printer" for a template's name or, from its keys, a file. Raises InputError."""
    if isinstance(name, Path) or shipped.is_path(name):
        kinds = _kinds_by_keys(Path(name))
    else:
        kinds = [kind for kind, (folder, _) in KINDS.items() if name in shipped.all_names(folder)]
        if not kinds:
            shipped.find(name)  # raises, with every name there is
    if len(kinds) > 1:
        choices = " or ".join(f"kind={kind!r}" for kind in kinds)
        raise InputError(f"{str(name)!r}: its keys fit more than one kind of file. Give {choices}.")
    return kinds[0]


def _kinds_by_keys(path: Path) -> list[str]:
    """Return the kinds ("walker", ...) that accept the largest number of a TOML file's keys. Raises InputError."""
    if Design.data_from_file(path) is not None:
        return ["walker"]
    data, _ = config.read_toml(path)
    keys = [key for key in _key_paths(data) if key not in (("name",), ("description",))]
    counts = dict.fromkeys(KINDS, 0)
    for key in keys:
        for kind, (_, model) in KINDS.items():
            is_body = key[0] == "walker" if kind == "walker" else False  # a table that becomes [body]
            counts[kind] += is_body or not config.describe_unknown_key(key, model)
    return [kind for kind, count in counts.items() if count == max(counts.values())]


def _key_paths(data: Mapping[str, Any], before: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    """Yield the paths, as tuples of keys, of all keys in nested tables. `before`: path of the table `data`."""
    for key, value in data.items():
        yield (*before, key)
        if isinstance(value, Mapping):
            yield from _key_paths(value, (*before, key))
