"""Form of a page: a control for every key of a file, made from the tables that validate them.

No key is named here: the page shows each table's own limits and help texts.
"""

import ast
import inspect
import math
import textwrap
from collections.abc import Iterator, Mapping
from functools import cache
from itertools import pairwise
from typing import Any, Literal, NamedTuple, get_args, get_origin

from walkergen.app.document import Document, tilt_key
from walkergen.core.files.config import Section
from walkergen.core.walker.body import Body
from walkergen.core.walker.design import Design
from walkergen.core.walker.limbs import Leg, Legs
from walkergen.core.walker.spec import Family
from walkergen.files import key_names
from walkergen.inputs import TILTS

UNITS = {suffix[1:]: unit for suffix, unit in key_names.UNITS_BY_SUFFIX.items()}
UNITS |= {"deg": "°", "n_per_m": "N/m", "mm2": "mm²"}
"""Units by the suffixes of keys; a longer suffix comes before its own ending."""

MAX_FULL_RANGE, SLIDER_FACTOR, MAX_SLIDER_TILT_DEG = 400.0, 3.0, 45.0
"""If a key allows negative numbers and its limits differ by at most MAX_FULL_RANGE, its slider covers all of them.
Other sliders end at SLIDER_FACTOR times the value, rounded up. The slider of the tilt ends at MAX_SLIDER_TILT_DEG."""

Kind = Literal["number", "whole", "choice", "yes", "text", "list"]


class Control(NamedTuple):
    """Control of the page's form for one key."""

    key: str
    name: str
    """Key in words, without its unit."""
    unit: str
    kind: Kind
    value: Any
    """Current value; None if the key is optional and missing."""
    help: str
    low: float | None = None
    """Smallest allowed number."""
    high: float | None = None
    slider: tuple[float, float] | None = None
    """Both ends of its slider, before `slider_ranges` restricts them to valid walkers; None for no slider."""
    choices: tuple[str, ...] = ()
    optional: bool = False
    """True if the key is optional."""
    follows: bool = False
    """True if other keys determine the value, so that users of the page cannot change it."""
    is_open: bool = False
    """True if the key is not set, so that the value is computed and changes with the walker."""


class Group(NamedTuple):
    """Controls of the form for one table of keys."""

    title: str
    controls: list[Control]
    absent: tuple[str, Any] | None = None
    """Key of a table that the file lacks, and the value with which the page adds it; None if the file has the table."""
    optional: str | None = None
    """Key of a table that the page may remove; None for other tables."""


def groups(document: Document) -> list[Group]:
    """Return groups of controls, one for each table of the walker, the scene and the printer of a page.

    The tilt has its own group, the first, because it has the largest influence. Raises InputError for an invalid
    document.
    """
    design = document.load_design()
    tables: list[Group] = []
    for prefix, title, section in (
        ("", "walker", design),
        ("scene.", "scene", document.load_scene()),
        ("printer.", "printer", document.load_printer()),
    ):
        tables += _table_groups(section, prefix, title)
    tilts = [control for table in tables for control in table.controls if control.key in TILTS]
    lengths = real_lengths(design)
    for table in tables:
        table.controls[:] = [_resolve(each, design, lengths) for each in table.controls if each not in tilts]
    for control in tilts:
        if control.key == tilt_key(design):
            steepest = max(MAX_SLIDER_TILT_DEG, abs(design.tilt_deg))
            tilt = control._replace(value=design.tilt_deg, slider=(-steepest, steepest), optional=False)
            return [Group("tilt", [tilt]), *tables]
    return tables


def real_lengths(design: Design) -> dict[str, float]:
    """Return, by dotted key, the actual lengths of the walker for keys that need not be set, mm, to four digits."""
    legs = design.legs
    lengths = {"body.length_mm": design.size.length} if design.body.scales_with_length else {}
    limbs = () if design.is_complete_mesh else design.limbs
    for number, limb in enumerate(limbs, start=1):
        table = "legs" if isinstance(legs, Legs) else f"legs[{number}]"
        lengths |= {f"{table}.width_mm": limb.width, f"{table}.thickness_mm": limb.thickness}
    if isinstance(legs, Legs) and limbs:
        along = [limb.along for limb in limbs]
        lengths["legs.contact_spacing_mm"] = max(along) - min(along)
    return {key: float(f"{value:.4g}") for key, value in lengths.items()}


def _resolve(control: Control, design: Design, lengths: Mapping[str, float]) -> Control:
    """Return a control with the walker's actual length as its value if its key is not set, otherwise unchanged."""
    body, automatic = design.body, design.has_automatic_legs
    if control.key == "legs.length_mm" and (reach := max(limb.length for limb in design.limbs)) > control.value + 0.05:
        return control._replace(name=f"length (up to {reach:.3g} mm, where the body is higher)")
    is_body = control.key == "body.length_mm"
    is_open = control.value is None or ("length_mm" not in body.model_fields_set if is_body else automatic)
    if not is_open or control.key not in lengths:
        return control
    value, sized = lengths[control.key], body.text is not None or body.scale_mm is not None
    follows = sized if is_body else automatic
    slider = None if follows else _slider_range(control.low, control.high, value)
    return control._replace(value=value, slider=slider, follows=follows, is_open=True)


def to_dict(document: Document) -> dict[str, Any]:
    """Return all data of a page's form as JSON values. Raises InputError for an invalid document."""
    tables = [
        {"title": group.title, "controls": [control._asdict() for control in group.controls]}
        | {"absent": group.absent, "optional": group.optional}
        for group in groups(document)
    ]
    return {"groups": tables, "legs": legs_as_list(document), "shapes": body_shapes(document)}


def _table_groups(section: Section, prefix: str, title: str) -> Iterator[Group]:
    """Yield a group for each table in `section`, then one for its other keys. `prefix`: of all keys, as "scene."."""
    own, inner, absent = [], [], []  # controls, (table, prefix, title, key if optional) and groups of missing tables
    idle = section.unused_keys if isinstance(section, Body) else ()  # keys without effect on this shape
    for name, field in type(section).model_fields.items():
        value, heading = getattr(section, name), f"{title}: {name}"
        if name in idle or isinstance(value, Family):
            continue  # a page is about one walker
        table = _optional_table(field)
        if isinstance(value, Section):
            key = f"{prefix}{name}" if table else None
            inner.append((value, f"{prefix}{name}.", heading, key))
        elif isinstance(value, list) and value and isinstance(value[0], Section):
            for number, entry in enumerate(value, start=1):
                inner.append((entry, f"{prefix}{name}[{number}].", f"{heading} {number}", None))
        elif table:
            absent.append(Group(heading.replace("_", " "), [], (f"{prefix}{name}", _minimal_table(table))))
        else:
            control = _control(f"{prefix}{name}", field, value, _key_docs(type(section)).get(name, ""))
            own += [control] if control else []
    for entry, inner_prefix, heading, key in inner:
        for group in _table_groups(entry, inner_prefix, heading.replace("_", " ")):
            yield group._replace(optional=key) if key else group
    yield from absent
    if own:
        yield Group(title, own)


def _optional_table(field: Any) -> type[Section] | None:
    """Return the class of an optional table from a pydantic field; None for other fields."""
    types, _ = _types_and_limits(field)
    tables = [each for each in types if isinstance(each, type) and issubclass(each, Section)]
    return tables[0] if tables and type(None) in types else None


def _minimal_table(table: type[Section]) -> dict[str, Any]:
    """Return valid values for a new table: none or, if a key is required, one key with its first choice."""
    choices = (
        {name: get_args(each)[0]}
        for name, field in table.model_fields.items()
        for each in _types_and_limits(field)[0]
        if get_origin(each) is Literal
    )
    for start in ({}, *choices):
        try:
            table.model_validate(start)
        except ValueError:
            continue
        return start
    return {}


def _control(key: str, field: Any, value: Any, note: str) -> Control | None:
    """Return the control for a key, from its pydantic field, value and help text `note`; None for other types."""
    name, unit = _split_unit(key.rpartition(".")[2])
    types, metadata = _types_and_limits(field)
    choices = next((get_args(each) for each in types if get_origin(each) is Literal), ())
    low, high = _find_limit(metadata, ("ge", "gt")), _find_limit(metadata, ("le", "lt"))
    optional = type(None) in types
    plain = Control(key, name, unit, "text", value, note, low, high, optional=optional)
    if choices:
        return plain._replace(kind="choice", choices=choices)
    if bool in types:
        return plain._replace(kind="yes")
    if any(get_origin(each) is list for each in types):
        return plain._replace(kind="list")
    if float in types:
        return plain._replace(kind="number", slider=_slider_range(low, high, value))
    if int in types:
        return plain._replace(kind="whole")
    return plain if str in types else None


def _split_unit(name: str) -> tuple[str, str]:
    """Split a key such as length_mm into its name in words and its unit."""
    for ending in sorted(UNITS, key=len, reverse=True):
        if name.endswith(f"_{ending}"):
            return name.removesuffix(f"_{ending}").replace("_", " "), UNITS[ending]
    return name.replace("_", " "), ""


def _types_and_limits(field: Any) -> tuple[list[Any], list[Any]]:
    """Return all types in a pydantic field's annotation, and its metadata, such as limits (Ge, Le)."""
    types, metadata, rest = [], list(field.metadata), [field.annotation]
    while rest:
        each = rest.pop()
        metadata += getattr(each, "__metadata__", ())
        types.append(each)
        if get_origin(each) not in (Literal, list):
            rest += get_args(each)
    return types, [limit for item in metadata for limit in getattr(item, "metadata", None) or [item]]


def _find_limit(metadata: list[Any], names: tuple[str, ...]) -> float | None:
    """Return the first limit with one of these names ("ge", "lt", ...) in a field's metadata; None without one."""
    limits = [getattr(item, name, None) for item in metadata for name in names]
    return next((float(limit) for limit in limits if limit is not None), None)


def _slider_range(low: float | None, high: float | None, value: float | None) -> tuple[float, float] | None:
    """Return both ends of a slider: within a key's limits, and of the scale of its value; None if one is unknown."""
    if low is None or high is None or value is None:
        return None
    if low < 0.0:
        most = max(-low, high) if high - low <= MAX_FULL_RANGE else _round_up(SLIDER_FACTOR * max(abs(value), 1.0))
        return max(low, -most), min(high, most)
    top = min(high, _round_up(SLIDER_FACTOR * value) if value > 0.0 else 10.0)
    return max(low, 0.01 * top) if low else 0.0, top


def _round_up(value: float) -> float:
    """Return the smallest round number, 1, 2 or 5 times a power of ten, at or above a positive value."""
    power = 10.0 ** math.floor(math.log10(value))
    return next(factor * power for factor in (1.0, 2.0, 5.0, 10.0) if factor * power >= 0.999 * value)


@cache
def _key_docs(table: type[Section]) -> Mapping[str, str]:
    """Return the docstring below each key in the source of a table's class and of its base classes, by key."""
    tables = [each for each in table.__mro__ if issubclass(each, Section) and each is not Section]
    trees = [ast.parse(textwrap.dedent(inspect.getsource(each))) for each in tables]
    bodies = [node.body for tree in trees for node in tree.body if isinstance(node, ast.ClassDef)]
    notes = {}
    for key, note in (pair for body in bodies for pair in pairwise(body)):
        if (
            isinstance(key, ast.AnnAssign)
            and isinstance(key.target, ast.Name)
            and isinstance(note, ast.Expr)
            and isinstance(note.value, ast.Constant)
        ):
            notes[key.target.id] = " ".join(str(note.value.value).split())
    return notes


def body_shapes(document: Document) -> dict[str, dict[str, Any]]:
    """Return the shapes that the page offers for the walker's body, by name, each with the values to set.

    They have the body's current size. Letters begin with their own template. Raises
    InputError for an invalid document.
    """
    design = document.load_design()
    length, thickness, depth = (round(extent, 1) for extent in design.size)
    x, y, z = 0.5 * length, 0.5 * thickness, 0.75 * depth  # half extents of the corners, mm
    bodies: dict[str, dict[str, Any]] = {
        "side view": {"length_mm": length, "depth_mm": depth, "thickness_mm": thickness},
        "side view by corners": {"profile_mm": [[-x, -y], [x, -y], [0.7 * x, y], [-0.7 * x, y]], "depth_mm": depth},
        "disc": {"outline": "disc", "length_mm": length, "thickness_mm": thickness},
        "ellipse": {"outline": "ellipse", "length_mm": length, "depth_mm": 1.75 * depth, "thickness_mm": thickness},
        "polygon": {
            "outline": "polygon",
            "thickness_mm": thickness,
            "points_mm": [[-x, -z], [0.8 * x, -z], [x, 0.0], [0.8 * x, z], [-x, z]],
        },
    }
    legs = {"legs.width_mm": round(design.limbs[0].width, 1)} if design.has_legs_table else {}
    found = {name: {"values": {"body": _round_lengths(body), **legs}} for name, body in bodies.items()}
    return found | {"letters": {"walker": "name", "values": {}}}


def _round_lengths(value: Any) -> Any:
    """Round all numbers in a value, or in its tables and lists, to one decimal."""
    if isinstance(value, float):
        return round(value, 1)
    if isinstance(value, dict):
        return {key: _round_lengths(entry) for key, entry in value.items()}
    return [_round_lengths(entry) for entry in value] if isinstance(value, list) else value


def legs_as_list(document: Document) -> list[dict[str, Any]]:
    """Return the walker's legs in the form of the TOML list [[legs]]. Two equal legs become two entries.

    A walker given as a complete mesh has none. Raises InputError for an invalid document.
    """
    design = document.load_design()
    if design.is_complete_mesh:
        return []
    if isinstance(design.legs, Legs):
        return [
            Leg(
                kind=limb.kind,
                length_mm=limb.length,
                thickness_mm=limb.thickness,
                thickness_sd_mm=limb.thickness_sd,
                brace_thickness_mm=limb.brace,
                foot=limb.foot,
                along_mm=limb.along,
                width_mm=design.legs.width_mm,
            ).model_dump(exclude_none=True, exclude_defaults=True)
            for limb in design.limbs
        ]
    return [leg.model_dump(exclude_none=True, exclude_unset=True) for leg in design.legs]
