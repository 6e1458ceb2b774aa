"""Templates: the TOML files shipped with walkergen, found by name from any folder."""

import difflib
import re
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import tomli_w

from walkergen.core.errors import InputError
from walkergen.core.files.config import Model, Section, read_section
from walkergen.files import report
from walkergen.files.report import Report

KINDS = ("walkers", "scenes", "printers")

PUBLISHED_FOLDER = "published"
"""Folder of walkers and scenes from publications, not meant for printing. Their names are published/NAME."""

NAME_PATTERN = re.compile(r'^name = "[^"]*"', re.MULTILINE)
"""Line with the name of a template. Every shipped template has it, above its tables."""


class Entry(NamedTuple):
    """Row of the list of templates."""

    kind: str
    name: str
    description: str


def folder() -> Path:
    """Return the folder of the templates: inside the installed package or, in a checkout, next to it."""
    package = Path(__file__).parent.parent
    installed = package / "templates"
    return installed if installed.is_dir() else package.parent / "templates"


def names(kind: str) -> list[str]:
    """Return the names of the templates of a kind (one of KINDS) that users copy and change, sorted."""
    return sorted(path.stem for path in (folder() / kind).glob("*.toml"))


def published_names(kind: str) -> list[str]:
    """Return the names of the templates of a kind that come from publications, published/NAME, sorted."""
    return sorted(f"{PUBLISHED_FOLDER}/{path.stem}" for path in (folder() / PUBLISHED_FOLDER / kind).glob("*.toml"))


def all_names(kind: str) -> list[str]:
    """Return the names of all templates of a kind: first those to copy and change, then those from publications."""
    return names(kind) + published_names(kind)


def find(name: str) -> Path:
    """Return the path of the template with this name, of any kind. Raises InputError."""
    for kind in KINDS:
        if name in all_names(kind):
            return _template_path(name, kind)
    known = [name for kind in KINDS for name in all_names(kind)]
    raise InputError(f"{name[:80]!r}: no such template. {_suggest_names(name, known)}")


def _template_path(name: str, kind: str) -> Path:
    """Return the file of an existing template."""
    subfolder, _, stem = name.rpartition("/")
    return folder() / subfolder / kind / f"{stem}.toml"


def read_with_name(path: Path, name: str) -> str:
    """Return the text of the template in `path`, with its comments, in which its name is replaced by `name`."""
    text = path.read_text(encoding="utf-8")
    return NAME_PATTERN.sub(f'name = "{name}"', text, count=1)


def load(name_or_path: str | Path, kind: str, model: type[Model], near: Path = Path()) -> Model:
    """Read and validate a template or the user's own file, whose path is `resolve_path(name_or_path, kind, near)`.

    Raises InputError that lists the known kinds or names, or every mistake in the file.
    """
    return read_section(resolve_path(name_or_path, kind, near), model)


def resolve_path(name_or_path: str | Path, kind: str, near: Path = Path()) -> Path:
    """Return the path of a template by its name. A Path or a text for which `is_path` is true is a user's own file.

    Paths begin at the folder `near`, by default the one that walkergen runs in.
    Raises InputError that lists the known kinds, or names.
    """
    if kind not in KINDS:
        raise InputError(f"{kind!r}: no such kind of templates. Must be one of {', '.join(KINDS)}")
    if isinstance(name_or_path, Path) or is_path(name_or_path):
        return near / name_or_path
    if name_or_path in all_names(kind):
        return _template_path(name_or_path, kind)
    hint = _suggest_names(name_or_path, all_names(kind), f" {kind}")
    keys = ", or any printer with ‹set=›printer.bed_width_mm=220" if kind == "printers" else ""
    raise InputError(f"{name_or_path[:80]!r}: no such template. {hint} Or give the path of a TOML file{keys}.")


def _suggest_names(name: str, known: Sequence[str], kind: str = "") -> str:
    """Return a sentence with the known names that are most similar to a wrong one, or with all known names."""
    close = difflib.get_close_matches(name, known, n=3, cutoff=0.5)
    return f"Did you mean {' or '.join(close)}?" if close else f"Known{kind}: {', '.join(known)}."


def is_path(text: str) -> bool:
    """Return whether a text names a file, not a template: it has an ending or /, but is not published/NAME."""
    if re.fullmatch(rf"{PUBLISHED_FOLDER}/[\w-]+", text):
        return False
    return bool(re.search(r"\.[A-Za-z0-9]{2,5}$", text)) or "/" in text or "\\" in text


def to_toml(model: Section, comment: str, every: bool = True) -> str:
    """Return a section as the text of a TOML file that `load` reads back, after a comment of one line.

    `every`: True for all keys. Otherwise the text has only keys that were set, because some keys exclude others.
    """
    line = "".join(letter if letter.isprintable() else "?" for letter in comment)
    data = model.model_dump(mode="json", exclude_none=True, exclude_unset=not every)
    return f"# {line}\n\n" + tomli_w.dumps(data)


def list_templates() -> Report:
    """Return the list of all templates with their descriptions, sorted by kind."""
    entries = []
    for kind in KINDS:
        for name in all_names(kind):
            data = tomllib.loads(_template_path(name, kind).read_text(encoding="utf-8"))
            entries.append(Entry(kind, name, data["description"]))
    columns = [report.text_column(key, key) for key in Entry._fields]
    return Report(
        name="templates",
        title="Shipped templates",
        tables=[report.table_from_rows("templates", entries, columns)],
        facts={"rows": [entry._asdict() for entry in entries]},
    )
