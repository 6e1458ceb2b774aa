"""Document of a page: a walker, a scene and a printer, each a file with changed keys.

It is equivalent to a command line with names and --set. A page, a shell and Python thus
describe the same walker.
"""

import copy
import json
import math
import re
import shlex
from collections.abc import Iterator, Mapping, Sequence
from functools import cache, lru_cache
from pathlib import Path
from typing import Annotated, Any, NamedTuple

from pydantic import Field

from walkergen.core.errors import InputError
from walkergen.core.files import assignments, config
from walkergen.core.files.config import Model, Section
from walkergen.core.printing.printers import Printer
from walkergen.core.scene import Scene
from walkergen.core.walker.body import BUILTIN_OUTLINES
from walkergen.core.walker.design import Design
from walkergen.core.walker.spec import MESH_SUFFIXES, OUTLINE_SUFFIXES
from walkergen.files import templates
from walkergen.inputs import KINDS, TILTS
from walkergen.readers.walkers.marks import format_tilt

MAX_KEYS = 500
"""Largest number of keys that a page sets."""

MAX_CACHED_TEMPLATES = 64
"""Number of templates with changed values that are cached."""

SOURCE = "page"
"""Name of the values' source, at the beginning of messages. The page does not show it."""

FILE_KEYS = ("mesh", "outline")
"""Keys of a design that name files."""

DRAWING_ENDINGS = tuple(ending.removeprefix(".") for ending in OUTLINE_SUFFIXES)
UPLOAD_ENDINGS = (*(ending.removeprefix(".") for ending in MESH_SUFFIXES), *DRAWING_ENDINGS)
"""Suffixes of files that may be dropped onto a page. Drawings and pictures are outlines."""

UPLOAD_NAME = re.compile(rf"[0-9a-f]{{16}}\.({'|'.join(UPLOAD_ENDINGS)})")
"""Name of a file that was dropped onto a page: the start of its hash, and its suffix."""

LONE_SURROGATE = re.compile("[\ud800-\udfff]")

BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")
"""TOML key without quotes. A matching value needs no quotes on a command line either."""

COMMAND_PREFIXES: Mapping[str, tuple[str, ...]] = {
    "export": (),
    "plate": ("printer.",),
    "family": ("scene.", "printer."),
    "predict": ("scene.",),
    "simulate": ("scene.",),
    "explain": ("scene.",),
    "crowd": ("scene.",),
    "sweep": ("scene.", "printer."),
}
"""Prefixes of the files and keys, other than the walker's, that each command accepts."""

FLAG_KEYS = (*TILTS, *KINDS)
"""Keys that the flags --tilt and --legs set."""

Word = Annotated[str, Field(min_length=1, max_length=4096)]


class Message(Section):
    """Document as a page sends it."""

    walker: Word
    scene: Word
    printer: Word
    values: Annotated[dict[str, Any], Field(max_length=MAX_KEYS)] = Field(default_factory=dict)


class PageFiles(NamedTuple):
    """Locations of the files whose names a page may send."""

    uploads: Path
    """Folder of the files that were dropped onto pages."""
    walker_file: str | None = None
    """File of a walker with which the server was started; None for a template."""

    def walkers(self) -> list[str]:
        """Return the names of the walkers that a page may start from. The one of the command line is first."""
        return ([self.walker_file] if self.walker_file else []) + templates.names("walkers")


class Document(NamedTuple):
    """Walker, scene and printer of a page, by the names of their files, with changed values."""

    walker: str
    scene: str
    printer: str
    values: Mapping[str, Any]
    """Values by dotted keys. Those of a scene and a printer begin with "scene." and "printer."."""

    def load_design(self) -> Design:
        """Return the walker of the page. Raises InputError, a line for every mistake."""
        design = self._load_section(self.walker, "walkers", Design, "")
        if design.weighed.has_masses:
            from walkergen.core.walker import weighed_masses

            weighed_masses.check_stated_masses(design)
        return design

    def load_scene(self) -> Scene:
        """Return the scene of the page. Raises InputError, a line for every mistake."""
        return self._load_section(self.scene, "scenes", Scene, "scene.")

    def load_printer(self) -> Printer:
        """Return the printer of the page. Raises InputError, a line for every mistake."""
        return self._load_section(self.printer, "printers", Printer, "printer.")

    def prefixed_values(self, prefix: str) -> dict[str, Any]:
        """Return the values whose keys begin with `prefix`, without it: "scene.", "printer." or "" for the walker."""
        others = ("scene.", "printer.")
        return {
            key.removeprefix(prefix): value
            for key, value in self.values.items()
            if (key.startswith(prefix) if prefix else not key.startswith(others))
        }

    def _load_section(self, name: str, kind: str, model: type[Model], prefix: str) -> Model:
        """Load the template or file `name` of a kind ("walkers", ...) with the page's values under `prefix`."""
        values = self.prefixed_values(prefix)
        if name in _template_names(kind):
            read: Model = _load_template(name, kind, model, json.dumps(values), prefix)
            return read
        return assignments.read_with_values(templates.resolve_path(name, kind), model, values, SOURCE, prefix)


@cache
def _template_names(kind: str) -> frozenset[str]:
    """Return the names of the templates of a kind, whose files do not change."""
    return frozenset(templates.names(kind))


@lru_cache(maxsize=MAX_CACHED_TEMPLATES)
def _load_template(name: str, kind: str, model: type[Model], values_json: str, prefix: str) -> Model:
    """Load a template with changed values. `values_json`: values by key as JSON text, so that calls can be cached."""
    settings, data = _load_defaults(name, kind, model)
    changed: Model = assignments.assign_values(settings, copy.deepcopy(data), json.loads(values_json), SOURCE, prefix)
    return changed


@cache
def _load_defaults(name: str, kind: str, model: type[Model]) -> tuple[Model, dict[str, Any]]:
    """Load a template. Return its contents, validated, and the data of its file."""
    return assignments.read_with_data(templates.resolve_path(name, kind), model, {})


def from_message(data: Any, files: PageFiles) -> Document:
    """Return the document that a page sends, validated. `data`: its parsed JSON. `files`: files that it may name.

    Raises InputError for invalid documents, and for files that were not dropped onto a page.
    """
    if not isinstance(data, dict):
        raise InputError(f"{SOURCE}: document: must be a table")
    message = config.validate(data, Message, SOURCE)
    for kind, name in (("walkers", message.walker), ("scenes", message.scene), ("printers", message.printer)):
        if name not in _template_names(kind) and not (kind == "walkers" and name == files.walker_file):
            raise InputError(f"{SOURCE}: {name[:60]!r} is not one of the {kind} of this page")
    values = _resolve_files("values", message.values, files.uploads)
    return Document(message.walker, message.scene, message.printer, values)


def parse_message(data: bytes) -> dict[str, Any]:
    """Return the table in a page's message, parsed from JSON. Raises InputError, also for values that TOML lacks."""
    try:
        message = json.loads(data)
    except (ValueError, RecursionError):
        message = None
    if not isinstance(message, dict):
        raise InputError(f"{SOURCE}: the message is not a JSON table")
    if config.nesting_depth(message) > config.MAX_DEPTH:
        raise InputError(f"{SOURCE}: nested too deeply: more than {config.MAX_DEPTH} levels")
    return message


def _resolve_files(key: str, value: Any, uploads: Path) -> Any:
    """Return the value of a key, with names of files dropped onto the page replaced by their paths in `uploads`.

    Tables and lists are converted recursively. Raises InputError for other files, and for values that TOML lacks.
    """
    if isinstance(value, dict):
        return {_check_text(inner): _resolve_files(inner, entry, uploads) for inner, entry in value.items()}
    if isinstance(value, list):
        return [_resolve_files(key, entry, uploads) for entry in value]
    if value is None:
        raise InputError(f"{SOURCE}: {_check_text(key)[:60]}: no value. Remove the key.", key)
    if isinstance(value, float) and not math.isfinite(value):
        raise InputError(f"{SOURCE}: {_check_text(key)[:60]} = {value}: must be a number", key)
    if not isinstance(value, str):
        return value
    name = key.rpartition(".")[2]
    if name not in FILE_KEYS or (name == "outline" and value in BUILTIN_OUTLINES):
        return _check_text(value)
    path = uploads / value
    if not UPLOAD_NAME.fullmatch(value) or not path.is_file():
        raise InputError(f"{SOURCE}: {key[:60]} = {value[:60]!r}: drop the file onto the page first", key)
    return path.as_posix()


def _check_text(text: str) -> str:
    """Return the text unchanged. Raises InputError if it contains lone surrogates, which JSON allows."""
    if LONE_SURROGATE.search(text):
        raise InputError(f"{SOURCE}: {text[:60]!r}: contains half a character. Enter it again.")
    return text


def arguments(document: Document, command: str, *options: str) -> list[str]:
    """Return the command-line arguments of a command of walkergen for a page's document, with further options.

    Tilt and kind of legs are given by flags, except for `sweep`, which has none. Raises InputError for an invalid
    document, and for a value that is too long for a command line.
    """
    flags = [] if command == "sweep" else _family_flags(document.load_design())
    words, prefixes = [command, document.walker], COMMAND_PREFIXES[command]
    words += ["--scene", document.scene] if "scene." in prefixes else []
    words += ["--printer", document.printer] if "printer." in prefixes else []
    dropped = FLAG_KEYS if flags else ()
    for prefix in ("", *prefixes):
        for key, value in document.prefixed_values(prefix).items():
            if prefix or key not in dropped:
                setting = f"{prefix}{key}={format_value(value)}"
                assignments.split_key_value(setting)
                words += ["--set", setting]
    return [*words, *flags, *options]


def tilt_key(design: Design) -> str | None:
    """Return the key of the tilt that a walker's legs share; None without a common tilt."""
    return TILTS[0] if design.has_legs_table else TILTS[1] if design.has_family_tilt else None


def _family_flags(design: Design) -> list[str]:
    """Return the flags for the tilt and the kind of legs of a walker, if all its legs share them."""
    tilt = ["--tilt", format_tilt(design.tilt_deg)] if design.has_family_tilt else []
    return [*tilt, "--legs", design.kind] if design.has_legs_table else tilt


def format_value(value: Any) -> str:
    """Format a value for --set on a command line; `assignments.parse_value` parses it."""
    if isinstance(value, str) and BARE_KEY.fullmatch(value) and assignments.parse_value(value) == value:
        return value
    return "".join(_format_toml(value))


def _format_toml(value: Any) -> Iterator[str]:
    """Yield the pieces of a JSON value in inline TOML."""
    if isinstance(value, Mapping):
        pairs = (f"{_format_key(key)} = {''.join(_format_toml(inner))}" for key, inner in value.items())
        yield "{" + ", ".join(pairs) + "}"
    elif isinstance(value, Sequence) and not isinstance(value, str):
        yield "[" + ", ".join("".join(_format_toml(inner)) for inner in value) + "]"
    else:
        yield _quote(value)


def _format_key(key: str) -> str:
    """Return a key in TOML, quoted if necessary."""
    return key if BARE_KEY.fullmatch(key) else _quote(key)


def _quote(value: Any) -> str:
    """Return a text, a number or a Boolean in TOML: as in JSON, with DEL escaped too."""
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")


def shell_command(words: Sequence[str]) -> str:
    """Return the shell command that runs walkergen with these arguments."""
    return shlex.join(["walkergen", *words])


def python_code(document: Document) -> str:
    """Return Python code that loads a page's walker, prints its predicted speed and exports it."""
    design, scene = document.prefixed_values(""), document.prefixed_values("scene.")
    changed = f".variant(**{design!r})" if design else ""
    ground = f"wg.load({document.scene!r})" + (f".variant(**{scene!r})" if scene else "")
    return (
        "import walkergen as wg\n"
        f"design = wg.load({document.walker!r}){changed}\n"
        f"print(wg.predict(design, {ground}).speed)\n"
        'wg.export(design, "walker.stl")'
    )
