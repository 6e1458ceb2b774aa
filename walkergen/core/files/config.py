"""TOML files that people write: read, validated once, with all mistakes reported together.

A mistake is one line: file and line, key, value seen, what is allowed, and a spelling hint.
"""

import difflib
import re
import reprlib
import tomllib
from collections import Counter
from collections.abc import Mapping, Sequence
from datetime import date, time
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, TypeVar, get_args, get_origin

from pydantic import BaseModel, ConfigDict, Field, Tag, ValidationError, field_validator
from pydantic.fields import FieldInfo

from walkergen.core.errors import InputError
from walkergen.core.files import file_reading, formatting
from walkergen.core.files import safe_text as plain

MAX_BYTES, MAX_DEPTH, MAX_REPORTED_MISTAKES = 1_000_000, 32, 20
"""Largest file in bytes, most levels of lists and tables in it, and most mistakes listed; others are counted."""

MIN_MAGNITUDE, MAX_INTEGER = 1e-15, 2**63
"""Size below which no number but 0 means anything in any unit here; largest whole number of TOML.
"""

MAX_INTEGER_BITS = 10_000
"""Longest whole number that is read, to be refused by its key; decimals of as many are no TOML."""

DEEP_KEY_PATTERN = re.compile(
    r"""(?:(?:[\w-]{1,64}|"[^"\n]{0,64}"|'[^'\n]{0,64}')[ \t]*\.[ \t]*)""" + f"{{{MAX_DEPTH}}}"
)
"""Key of more parts than are read: the time that tomllib takes grows with their square."""

NAME_PATTERN = r"^[A-Za-z0-9][A-Za-z0-9_-]{0,63}$"
LIMIT_SIGNS = {"gt": ">", "ge": ">=", "lt": "<", "le": "<="}
"""Signs of the limits of a number, by pydantic's names of them."""
TYPE_RULES = {"string_type": "must be text", "bool_type": "must be true or false", "list_type": "must be a list"}
"""Descriptions of the required form, by pydantic's names of the mistakes."""

QUOTES = {"string_type": '"{}" with its quotes', "list_type": "[{}]"}
"""Forms in which a single value becomes one of the required type, by pydantic's names of the mistakes."""

MAX_LISTED_CHOICES = 10  # most choices that a message lists in full; of more it lists the nearest three
TOML_MISTAKES = {
    "Cannot overwrite a value": "a key is set twice; remove one",
    "Invalid value": "a value is missing, or is text without quotes; write the value",
    "Invalid statement": "a line must be KEY = VALUE, a [TABLE] or a # comment",
}
"""Descriptions of mistakes of TOML whose texts by tomllib give no advice."""

VALUE_REPR = reprlib.Repr()
VALUE_REPR.maxstring = VALUE_REPR.maxother = VALUE_REPR.maxlong = 200

Name = Annotated[str, Field(pattern=NAME_PATTERN)]
Fraction = Annotated[float, Field(ge=0, le=1)]
Friction = Annotated[float, Field(ge=0, le=1e3)]

WINDOWS_PATH_HINT = (
    ": between \"...\" a backslash begins a letter's code; write a path between '...', as 'C:\\prints\\body.svg', "
    "or with slashes"
)
"""Advice for a Windows path between double quotes."""


class Section(BaseModel):
    """Table of a TOML file: frozen, with strict numbers; unknown keys and NaN are refused."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)

    removed_keys: ClassVar[Mapping[str, str]] = {}
    """Keys that earlier versions had, and what to do without each."""

    @classmethod
    def translate_key(cls, key: str) -> str:
        """Return how to write a quantity that other programs call `key`; "" if unknown. Subclasses may override it."""
        return ""

    @field_validator("*", mode="before")
    @classmethod
    def _normalize_numbers(cls, value: Any) -> Any:
        return normalize_number(value)

    @classmethod
    def data_from_file(cls, path: Path) -> dict[str, Any] | None:
        """Return the data of a file that is no TOML, such as a drawing, else None. Subclasses may override it."""
        return None

    @classmethod
    def with_paths_below(cls, data: Mapping[str, Any], folder: Path) -> Mapping[str, Any]:
        """Return the data of a file, with relative paths in it joined to `folder`. Subclasses override it."""
        return data

    def adjust_other_keys(self, data: dict[str, Any], values: Mapping[str, Any]) -> dict[str, Any]:
        """Return a file's `data` after a user has set `values`, by dotted keys, with other keys adjusted to these.

        `data` has the values already, and may be changed in place. Subclasses override it.
        """
        return data


Model = TypeVar("Model", bound=Section)


def read_section(path: Path, model: type[Model]) -> Model:
    """Read and validate a TOML file. Its stem is the default of `name`.

    Raises InputError when the file cannot be read, or with every mistake in it and its line.
    """
    data, text = read_data(path, model)
    return validate(data, model, str(path), text)


def read_data(path: Path, model: type[Section]) -> tuple[dict[str, Any], str]:
    """Return the unvalidated tables of a file, and its text, or "" for a file that is no TOML. Raises InputError."""
    data_of_file = model.data_from_file(path)
    data, text = read_toml(path) if data_of_file is None else (data_of_file, "")
    if not data:
        raise InputError(f"{path}: the file sets nothing. Start from a template: walkergen templates copy NAME")
    if "name" in model.model_fields:
        data.setdefault("name", path.stem)
    return dict(model.with_paths_below(data, path.parent)), text


def read_toml(path: Path) -> tuple[dict[str, Any], str]:
    """Return the tables of a TOML file as a dictionary, and the file's text. Raises InputError if it cannot be read."""
    text = "".join(file_reading.read_lines(path, "a TOML file", MAX_BYTES))
    try:
        return parse_toml(text), text
    except ValueError as error:
        hint = WINDOWS_PATH_HINT if re.search(r"hex value|Unescaped", str(error)) and "\\" in text else ""
        problem, bracket, place = str(error).partition(" (at ")
        described = TOML_MISTAKES.get(problem, problem)
        raise InputError(f"{path}: not valid TOML: {described}{bracket}{place}{hint}") from None


def parse_toml(text: str) -> dict[str, Any]:
    """Return the tables and keys of TOML text as a dictionary.

    Raises ValueError for other text, for too deep nesting, and for whole numbers too long for Python.
    """
    if not DEEP_KEY_PATTERN.search(text):
        try:
            data = tomllib.loads(text)
        except RecursionError:
            pass
        else:
            if nesting_depth(data) <= MAX_DEPTH:
                _check_integer_size(data)
                return data
    raise ValueError(f"nested too deeply: more than {MAX_DEPTH} levels")


def _check_integer_size(value: Any) -> None:
    """Raise ValueError for a whole number of more than MAX_INTEGER_BITS bits, also within lists and tables."""
    if isinstance(value, (dict, list)):
        for inner in value.values() if isinstance(value, dict) else value:
            _check_integer_size(inner)
    elif isinstance(value, int) and value.bit_length() > MAX_INTEGER_BITS:
        raise ValueError(f"a whole number of {value.bit_length()} bits. At most {MAX_INTEGER_BITS} are allowed")


def nesting_depth(value: Any) -> int:
    """Return the number of levels of lists and tables in a value, counted up to one beyond MAX_DEPTH."""
    layer, levels = [value], 0
    while layer and levels <= MAX_DEPTH:
        holders = [holder for holder in layer if isinstance(holder, (dict, list))]
        layer = [inner for holder in holders for inner in (holder.values() if isinstance(holder, dict) else holder)]
        levels += bool(holders)
    return levels


def normalize_number(value: Any) -> Any:
    """Return the value of a key, or each entry of a list, with 0 for -0. Raises ValueError for invalid numbers.

    Invalid ones are so small or large that they can only be typing errors, and would overflow in squares or divisions.
    """
    if isinstance(value, list):
        return [normalize_number(entry) for entry in value]
    if isinstance(value, float):
        if 0.0 < abs(value) < MIN_MAGNITUDE:
            raise ValueError(f"{value:g} is too small: must be 0, or at least {MIN_MAGNITUDE:g}")
        return value + 0.0
    if isinstance(value, int) and abs(value) > MAX_INTEGER:
        raise ValueError(f"{_format_value(value)} is too large: must be at most {MAX_INTEGER:.3g}")
    return value


def format_location(location: tuple[str, ...], source: str, text: str) -> str:
    """Return `source`, the file of a TOML text, with the line of the key at `location` if it is found: "my.toml:12"."""
    line = _find_line(location, text)
    return f"{source}:{line}" if line else source


def validate(data: Mapping[str, Any], model: type[Model], source: str, text: str = "", prefix: str = "") -> Model:
    """Return data as a validated instance of `model`. Messages begin with `source` (file or flag) and a line of `text`.

    They write `prefix` before keys. Raises InputError, or GeometryError for parts that cannot be built, with a line for
    every mistake.
    """
    try:
        return model.model_validate(data)
    except InputError as error:  # of parts that cannot be built, or of a file that a key names
        problems = error.fault.splitlines()
        at_fault = error.keys or [_leading_key(problem, model) for problem in problems]
        lines = [
            problem
            if problem.startswith(f"{source}: ")
            else f"{format_location(_split_key(key), source, text)}: {problem}"
            for key, problem in zip(at_fault, problems, strict=True)
        ]
        error.args, error.keys = ("\n".join(lines),), tuple(at_fault)  # the same error, with what it holds
        raise error from None
    except ValidationError as error:
        mistakes = error.errors()
        reported = mistakes[:MAX_REPORTED_MISTAKES]
        lines = [_explain_mistake(mistake, model, source, text, prefix) for mistake in reported]
        at_fault = [prefix + ".".join(_key_path(mistake["loc"], model)) for mistake in reported]
        if len(mistakes) > MAX_REPORTED_MISTAKES:
            lines.append(f"{source}: and {len(mistakes) - MAX_REPORTED_MISTAKES} more mistakes")
        raise InputError("\n".join(lines), *at_fault) from None


def mistakes_error(mistakes: Sequence[str], source: object) -> InputError:
    """Return an error that lists the first mistakes, one a line, and then `source` and the number of others."""
    more = len(mistakes) - MAX_REPORTED_MISTAKES
    tail = [f"{source}: and {more} more mistakes"] if more > 0 else []
    return InputError("\n".join([*mistakes[:MAX_REPORTED_MISTAKES], *tail]))


def _leading_key(problem: str, model: type[Section]) -> str:
    """Return the dotted key that a message on a mistake begins with, or "" if it begins with no key of the model."""
    word = problem.split(" ", 1)[0].rstrip(":")
    return word if _field_at(_split_key(word), model) is not None else ""


def _explain_mistake(mistake: Any, model: type[Section], source: str, text: str, prefix: str) -> str:
    """Explain a mistake from pydantic's list in one line: file and line, key, wrong value, allowed values."""
    location = _key_path(mistake["loc"], model)
    value, kind = mistake["input"], mistake["type"]
    problem = mistake["msg"].removeprefix("Value error, ")
    if longer := _leading_path(problem, location, model) if kind == "value_error" else ():
        location, problem = longer, problem[len(problem.split(" ", 1)[0].rstrip(":")) :]
    position = format_location(location, source, text)
    key = plain.shorten_line(prefix + ".".join(location) or "file")
    if kind == "extra_forbidden":
        return f"{position}: {_shorten(key)}: {_suggest_known_keys(location, model, prefix)}"
    if kind == "value_error":  # raised by a table's own check, in full words
        shown = "" if longer else f" = {_format_value(value)}: " if problem.startswith("must ") else ": "
        return f"{position}: {key}{shown}{problem}"
    if kind in ("too_short", "too_long"):
        words, limit = {"too_short": ("at least", "min_length"), "too_long": ("at most", "max_length")}[kind]
        entries = f"{len(value)} {'entry' if len(value) == 1 else 'entries'}"
        return f"{position}: {key}: has {entries}. It must have {words} {mistake['ctx'][limit]}."
    seen_value = " is missing" if kind == "missing" else f" = {_format_value(value)}"
    rule = TYPE_RULES.get(kind) or describe_allowed_values(location, model, value, prefix) or problem
    if kind in QUOTES and isinstance(value, (int, float, str)):
        rule += f". Write {QUOTES[kind].format(_format_value(value))}."
    seen_text = value if isinstance(value, str) else ""
    if rule.startswith(("must be a number", "must be a whole")) and formatting.parse_number(seen_text) is not None:
        rule += ". It is text: write the number without quotes."
    return f"{position}: {key}{seen_value}: {rule}"


def _leading_path(problem: str, location: tuple[str, ...], model: type[Section]) -> tuple[str, ...]:
    """Return the path of the key that a problem of the table at `location` begins with; () for another word."""
    path = _split_key(problem.split(" ", 1)[0].rstrip(":"))
    longer = path if path[: len(location)] == location else location + path
    return longer if _field_at(longer, model) is not None else ()


def _format_value(value: Any) -> str:
    """Format a wrong value for a message, shortened."""
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, list) and value and isinstance(value[0], dict):
        return "a list of tables"
    if isinstance(value, (bool, date, time)):
        return str(value).lower()
    if isinstance(value, int) and abs(value) > MAX_INTEGER:
        return f"a whole number of about {value.bit_length() * 0.30103:.0f} digits"
    return _shorten(VALUE_REPR.repr(value))


def _shorten(text: str) -> str:
    return text if len(text) <= 60 else text[:57] + "..."


def _key_path(pydantic_location: Sequence[str | int], model: type[Section]) -> tuple[str, ...]:
    """Return the path of keys to a mistake, such as legs[2] and tilt_deg, from pydantic's location of the mistake.

    It omits pydantic's tag that distinguishes a table from a list of tables.
    """
    path: list[str] = []
    for before, step in zip(("", *pydantic_location), pydantic_location, strict=False):
        if isinstance(step, int):
            path[-1] += f"[{step + 1}]"
        elif not (path and before == path[-1] and step in _union_tags(tuple(path), model)):
            path.append(step)
    return tuple(path)


def _union_tags(location: tuple[str, ...], model: type[Section]) -> set[str]:
    """Return pydantic's tags, such as "table" and "list", of the alternative types of the key at `location`."""
    field = _field_at(location, model)
    forms = get_args(field.annotation) if field else ()
    metadata = [item for form in forms for item in getattr(form, "__metadata__", ())]
    return {item.tag for item in metadata if isinstance(item, Tag)}


def _find_line(location: tuple[str, ...], text: str) -> int | None:
    """Return the number of the line of a key in TOML text, otherwise that of its table, otherwise None.

    Headers of tables and dotted keys both count.
    """
    table: tuple[str, ...] = ()
    tables: Counter[tuple[str, ...]] = Counter()
    plain_key, plain_table = (tuple(map(_without_index, part)) for part in (location, location[:-1]))
    fallback = None
    for number, line in enumerate(text.splitlines(), start=1):
        if header := re.match(r"\s*(\[+)\s*([\w.\s\"'-]+?)\s*\]+", line):
            table = _split_key(header[2])
            tables[table] += 1
            if header[1] == "[[":
                if location == table:
                    return number  # what is wrong with the list as a whole
                table = (*table[:-1], f"{table[-1]}[{tables[table]}]")
            if table == location:
                return number
            if table == location[:-1]:
                fallback = fallback or number
        elif pair := re.match(r"\s*([\w.\s\"'\[\]-]+?)\s*=", line):
            key = table + _split_key(pair[1])
            if key in (location, plain_key, location[:-1], plain_table):
                return number
    return fallback


def _without_index(key: str) -> str:
    """Return the key without the index of its list entry: legs for legs[2]."""
    return key.partition("[")[0]


def _split_key(dotted: str) -> tuple[str, ...]:
    return tuple(part.strip().strip("\"'") for part in dotted.split("."))


def describe_unknown_key(location: tuple[str, ...], model: type[Section], prefix: str = "") -> str:
    """Return the message on a key that no such file can have, with the allowed key most like it; "" for an allowed key.

    Parameters
    ----------
    location : tuple of str
        Names of the tables that lead to the key, and of the key itself.
    model : type of Section
        Model of the file.
    prefix : str
        Text before each allowed key in the message.
    """
    if _field_at(location, model) is not None:
        return ""
    return _suggest_known_keys(location, model, prefix)


def _suggest_known_keys(location: tuple[str, ...], model: type[Section], prefix: str) -> str:
    """Return a message that suggests an allowed key of the same or a similar name, or lists all keys of the table."""
    table = _model_at(location[:-1], model)
    if table and location[-1] in table.removed_keys:
        return f"this key was removed. {table.removed_keys[location[-1]]}"
    if table and (translation := table.translate_key(location[-1])):
        return f"unknown key. {translation}"
    keys = key_paths(model)
    in_table = [(*location[:-1], name) for name in table.model_fields] if table else keys
    close = difflib.get_close_matches(location[-1], [path[-1] for path in in_table], n=1, cutoff=0.6)
    near = [path for path in keys if path[-1] == location[-1]] + [path for path in in_table if path[-1] in close]
    if near:
        return f"unknown key. Did you mean {prefix}{'.'.join(near[0])}?"
    return f"unknown key. Use one of {', '.join(path[-1] for path in in_table if table or len(path) == 1)}."


def key_paths(model: type[Section], prefix: tuple[str, ...] = ()) -> list[tuple[str, ...]]:
    """Return the path, such as ("drive", "gamma"), of each key in a table and in its inner tables, after `prefix`."""
    paths: list[tuple[str, ...]] = []
    for name, field in model.model_fields.items():
        paths.append((*prefix, name))
        inner = _section_type(field.annotation)
        if inner:
            paths += key_paths(inner, (*prefix, name))
    return paths


def _section_type(annotation: Any, listed: bool = False) -> type[Section] | None:
    """Return the model of the table (or, if `listed`, of the list of tables) in a field's type, or None without one."""
    if isinstance(annotation, type) and issubclass(annotation, Section):
        return None if listed else annotation
    if get_origin(annotation) is list:
        return _section_type(get_args(annotation)[0]) if listed else None
    sections = (_section_type(argument, listed) for argument in get_args(annotation))
    return next((section for section in sections if section), None)


def _field_at(location: tuple[str, ...], model: type[Section]) -> FieldInfo | None:
    """Return the field at the end of a path of keys, or None if the path leads to no field."""
    table = _model_at(location[:-1], model) if location else None
    return table.model_fields.get(_without_index(location[-1])) if table else None


def _model_at(location: tuple[str, ...], model: type[Section]) -> type[Section] | None:
    """Return the model of the table at the end of a path of keys, or None if the path leads to no table."""
    if not location:
        return model
    field = _field_at(location, model)
    return _section_type(field.annotation, listed="[" in location[-1]) if field else None


def describe_allowed_values(
    location: tuple[str, ...], model: type[Section], seen: object = None, prefix: str = ""
) -> str:
    """Describe the values that a key may hold, from the model's constraints, or return '' without constraints.

    Of many words it names those most like the wrong value, `seen`. Keys of a table are listed after `prefix`.
    """
    field = _field_at(location, model)
    if field is None:
        return ""
    if tables := _describe_tables(_without_index(location[-1]), field.annotation, prefix + ".".join(location)):
        return tables
    metadata, types = list(field.metadata), [field.annotation]
    is_whole = False
    while types:
        annotation = types.pop()
        is_whole |= annotation is int
        if get_origin(annotation) is Literal:
            choices = get_args(annotation)
            lists_all = seen is None or len(choices) <= MAX_LISTED_CHOICES
            shown = choices if lists_all else difflib.get_close_matches(str(seen), choices, 3, 0.0)
            return (
                ("must be " if len(choices) == 1 else "must be one of ")
                + ", ".join(map(repr, shown))
                + ("" if lists_all else ", ...")
            )
        metadata += getattr(annotation, "__metadata__", ())
        types += get_args(annotation)
    if any(getattr(item, "pattern", None) == NAME_PATTERN for item in metadata):
        return "must be 1 to 64 letters, digits, - or _, the first a letter or digit"
    if bounds := _describe_bounds(metadata):
        described = f" ({field.description})" if field.description else ""
        return f"must be a {'whole ' if is_whole else ''}number {bounds}{described}"
    return f"must be {field.description}" if field.description else ""


def _describe_tables(key: str, annotation: Any, path: str) -> str:
    """Describe the tables that a field of this type may hold under `key`, or return '' if it holds none.

    `path`: the whole key, for an example.
    """
    tables = [
        (f"{start}{key}{end}", example, section)
        for start, end, example, listed in (("a table [", "]", path, False), ("tables [[", "]]", f"{path}[1]", True))
        if (section := _section_type(annotation, listed))
    ]
    if not tables:
        return ""
    _, example, section = tables[0]
    forms = ", or ".join(form for form, _, _ in tables)
    return f"must be {forms}. Set its keys, such as {example}.{next(iter(section.model_fields))}."


def _describe_bounds(metadata: list[Any]) -> str:
    """Describe the limits of a number, from the constraints of its field, or return '' without limits."""
    parts = [part for item in metadata for part in getattr(item, "metadata", None) or [item]]
    limits = [(sign, getattr(part, key, None)) for part in parts for key, sign in LIMIT_SIGNS.items()]
    return " and ".join(f"{sign} {limit:g}" for sign, limit in limits if limit is not None)
