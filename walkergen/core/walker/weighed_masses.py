"""Weighed masses of printed walkers: weights.csv in, masses of body and leg in the design out.

Columns: part, and any of grams (the whole walker), body_g (the body alone), leg_g (one leg, of unlike legs their mean;
braced: with its brace). Two of them give the third. Grams alone multiply the masses of body and legs by one factor. The
predicted speed stays, since it depends on their ratios only. These rows are for the printed part, with its cap. Motor,
battery, wires and glue have rows of their own, with grams only.
"""

import difflib
import math
import os
import re
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence, Set
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from walkergen.core.errors import GeometryError, InputError
from walkergen.core.files import columns, file_reading, formatting, output
from walkergen.core.files.tables import csv_text
from walkergen.core.numerics.quantity import Quantity
from walkergen.core.walker import mass, names, solids
from walkergen.core.walker.design import Design
from walkergen.core.walker.solids import Solids
from walkergen.core.walker.spec import Weighed

FILE_NAME = "weights.csv"
QUANTITIES = ("grams", "body_g", "leg_g")
MAX_BYTES = 10_000_000
MIN_MASS_G, MAX_MASS_G = 1e-6, 1e6
"""Limits of masses that were weighed, g."""
MAX_MASS_RATIO = 10.0
"""Largest factor between weighed and meshed masses; beyond it a unit or part is wrong."""

CARRIED_ROWS = ("motor", "battery", "wires", "glue")
"""Rows of the parts in a walker."""

PART_NAME_PATTERN = re.compile(r"(?P<stem>.+)_t(?P<tilt>-?[0-9.]{1,20})_(?P<kind>[a-z]+)_s[0-9.]+")
"""Name of a walker, as `names.part_name` writes it."""

COPY_SUFFIX = re.compile(r"-[1-9][0-9]*$")


class Weighings(NamedTuple):
    """Mean weighed masses (g) of one part, over all its copies. The mean of a single weighing has no standard error."""

    grams: Quantity | None = None
    body_g: Quantity | None = None
    leg_g: Quantity | None = None

    @property
    def number(self) -> int:
        """Number of weighings, of all three masses together."""
        return sum(int(mean.freedom) + 1 for mean in self if mean is not None)


def to_dict(mean: Quantity) -> dict[str, float | None]:
    """Return a mean mass (g), its standard error (g; None for one weighing) and the number of weighings, by name."""
    return {"mean": mean.value, "error": mean.se, "weighings": int(mean.freedom) + 1}


def form_name(members: Sequence[Design], name: str) -> str:
    """Return the name of the CSV file (form) in which a user enters weighed masses of walkers of the design `name`.

    It is FILE_NAME for a single design. Several designs have a form each, since `read_masses` reads those of one.
    """
    return FILE_NAME if len(names.group_by_design(members)) == 1 else f"weights_{name}.csv"


def carried_rows(design: Design) -> tuple[str, ...]:
    """Return the names of rows for motor, battery, wires and glue in a walker's form; () if it has no such parts."""
    return tuple(name for name in CARRIED_ROWS if design.parts and name in (*design.parts, *CARRIED_ROWS[2:]))


def format_form(parts: Iterable[str]) -> str:
    """Return the text of a blank form, a weights.csv with a line for every part and no masses."""
    return csv_text(("part", *QUANTITIES), ((part, *[""] * len(QUANTITIES)) for part in parts))


def is_filled_in(path: Path) -> bool:
    """Return whether a file exists that is no blank form of walkers, but has data of a user. Raises InputError."""
    parts = _read_blank_form(path)
    return parts is None or not all(names.is_part_name(part) or part in CARRIED_ROWS for part in parts)


def _read_blank_form(path: Path) -> list[str] | None:
    """Return the names of parts in a blank form, [] without a file, None for a form with data. Raises InputError."""
    if not os.path.lexists(path):
        return []
    data = file_reading.read_bytes(path, MAX_BYTES)
    parts = [row.partition(",")[0] for row in data.decode("utf-8", "replace").splitlines()[1:]]
    return parts if data == format_form(parts).encode() else None


def read_masses(path: Path, members: Sequence[Design]) -> dict[str, Weighings]:
    """Read the mean weighed masses of walkers, motors and batteries from a form, by name. Copies (NAME-3) are averaged.

    Names may begin with the design's name, as on plates of several designs. Walkers of the same designs that are not
    members are left out, and `unused_parts` names them: a form is of a whole family. Raises InputError when the file is
    no table of masses, or with every line of a wrong mass and every unknown part with its near matches.
    """
    rows = _read_rows(path)
    parts, has_other_walkers = _names_to_parts(members), False
    parts_in_file = {_find_part(row["part"].strip(), parts) for _, row in rows}
    masses: dict[str, dict[str, list[float]]] = defaultdict(lambda: defaultdict(list))
    problems = []
    for line, row in rows:
        try:
            if values := _parse_masses(row):
                part = _match_row(row["part"].strip(), values, parts, members, parts_in_file)
                if part is None:
                    has_other_walkers = True
                    continue
                for quantity, value in values.items():
                    masses[part][quantity].append(value)
        except InputError as error:
            problems.append(f"{path}:{line}: {error.text}")
    if problems:
        raise InputError("\n".join(problems))
    if has_other_walkers and not masses:
        raise InputError(f"{path}: there are no masses of the walkers that ‹tilt› and ‹legs› select, only of others.")
    if not masses:
        raise InputError(f"{path}: there are no masses. Fill in {', '.join(QUANTITIES)} of a part.")
    return {
        part: Weighings(**{quantity: _mean_mass(values) for quantity, values in quantities.items()})
        for part, quantities in masses.items()
    }


def unused_parts(path: Path, members: Sequence[Design]) -> list[str]:
    """Return the parts with a mass in the file that belong to none of `members`, such as walkers of another tilt.

    Raises InputError for a file that is no table of masses.
    """
    part_names = _names_to_parts(members)
    masses = (row["part"].strip() for _, row in _read_rows(path) if _parse_masses(row))
    used = {*part_names, *CARRIED_ROWS}
    return list(
        dict.fromkeys(COPY_SUFFIX.sub("", name) for name in masses if not used & {name, COPY_SUFFIX.sub("", name)})
    )


def apply_masses(design: Design, built: Solids, weighed: Weighings, name: str) -> Design:
    """Return the design with the masses of `weighed` instead of those of its solids, `built`.

    Raises InputError, whose message begins with `name`, for masses that contradict each other, or far from the mesh's.
    """
    count, (body, leg) = len(built.legs), _mesh_masses(design, built)
    grams, body_g, leg_g = (None if weighing is None else weighing.number for weighing in weighed)
    if grams is not None and body_g is not None and leg_g is not None:
        raise InputError(f"{name}: grams, body_g and leg_g cannot all be given. Leave one empty.")
    if grams is not None:
        if leg_g is not None:
            body_g = grams - count * leg_g
        elif body_g is not None:
            leg_g = (grams - body_g) / count
        else:
            scale = grams / (body + count * leg)
            body_g, leg_g = scale * body, scale * leg
    for what, value, meshed in (("body", body_g, body), ("leg", leg_g, leg)):
        if value is not None and _is_implausible(value, meshed):
            raise InputError(
                f"{name}: the weighed mass of the {what} is {value:.4g} g, that of the mesh {meshed:.4g} g. "
                f"They differ by more than a factor of {MAX_MASS_RATIO:g}. Check the unit and the part."
            )
    masses = {"body_mass_g": body_g, "leg_mass_g": leg_g}
    given_masses = {key: value for key, value in masses.items() if value is not None}
    return design.model_copy(update={"weighed": design.weighed.model_copy(update=given_masses)})


def check_stated_masses(design: Design) -> None:
    """Raise InputError for weighed masses in the design that differ by more than MAX_MASS_RATIO from its mesh's."""
    if not design.weighed.has_masses:
        return
    stated = {"body_mass_g": design.weighed.body_mass_g, "leg_mass_g": design.weighed.leg_mass_g}
    meshed = _mesh_masses(design, solids.build(design, united=False))
    for (key, value), mesh_g in zip(stated.items(), meshed, strict=True):
        if value is not None and _is_implausible(value, mesh_g):
            raise InputError(
                f"{design.name}: weighed.{key} = {value:.4g}: the mesh has {mesh_g:.4g} g. They differ by more than a "
                f"factor of {MAX_MASS_RATIO:g}. "
                "Check the unit. For another plastic set material.density_g_cm3.",
                f"weighed.{key}",
            )


def _mesh_masses(design: Design, built: Solids) -> tuple[float, float]:
    """Return the masses of the solids, `built`, in g: of the body with its cap, and of a leg (the mean of all legs)."""
    density = 1e-3 * design.material.density_g_cm3
    body = mass.weigh(built.body, density).mass
    if built.cap is not None and design.cap is not None:
        body += mass.weigh(built.cap, 1e-3 * design.cap.density(design.material.density_g_cm3)).mass
    return body, sum(mass.weigh(mesh, density).mass for mesh in built.legs) / len(built.legs)


def _is_implausible(weighed: float, meshed: float) -> bool:
    """Return whether a weighed mass and that of the mesh, both g, differ by more than MAX_MASS_RATIO, either way."""
    return not meshed / MAX_MASS_RATIO <= weighed <= meshed * MAX_MASS_RATIO


def apply_carried_masses(design: Design, weighed: Mapping[str, Weighings]) -> Design:
    """Return the design with the weighed masses of motor, battery, wires and glue, which `weighed` has by these names.

    Raises InputError when they are far from the design's.
    """
    tables: dict[str, dict[str, float]] = defaultdict(dict)
    for name in carried_rows(design):
        if name not in weighed or (grams := weighed[name].grams) is None:
            continue
        if part := design.parts.get(name):
            stated = part.cylinder.mass
            if _is_implausible(grams.number, stated):
                raise InputError(
                    f"{name}: the weighed mass is {grams.number:.4g} g, that of the design {stated:.4g} g. "
                    f"They differ by more than a factor of {MAX_MASS_RATIO:g}. Check the unit and the part."
                )
            tables[name]["mass_g"] = grams.number
        else:
            tables["pockets"][f"{name}_g"] = grams.number
    changed_tables = {
        key: (design.pocket_settings if key == "pockets" else design.parts[key]).model_copy(update=table)
        for key, table in tables.items()
    }
    return design.model_copy(update=changed_tables)


def without_weighed_masses(design: Design) -> Design:
    """Return the design without its weighed masses, so that those of its mesh apply."""
    plain = Weighed(mass_sd_percent=design.weighed.mass_sd_percent)
    return design.model_copy(update={"weighed": plain})


def mass_with_error(grams: float, weighed: Weighings, legs: int) -> Quantity:
    """Return the mass of a walker, `grams`, as a quantity with the standard error of its weighings.

    Parameters
    ----------
    grams : float
        Mass of the walker, g.
    weighed : Weighings
        Mean weighed masses.
    legs : int
        Number of legs.

    Returns
    -------
    Quantity
        Mass in g. If whole walkers were weighed, its error is that of their mean. Otherwise it follows from the
        weighings of body and legs. It is None if these are missing.
    """
    whole, body, leg = (mean and mean.se for mean in weighed)
    if weighed.grams is None and body is not None and leg is not None:
        whole = math.hypot(body, legs * leg)
    return Quantity("mass", "g", grams, whole)


def _read_rows(path: Path) -> list[tuple[int, dict[str, str]]]:
    """Read the rows of a weights.csv: the line number of each, and its cells by column. Raises InputError."""
    table = columns.parse_records(file_reading.read_lines(path, columns.FORMAT_NAME, MAX_BYTES), str(path))
    wrong = [name for name in table.names if name not in ("part", *QUANTITIES)]
    if wrong or "part" not in table.names or len(table.names) < 2:
        raise InputError(
            f"{path}:1: columns {', '.join(table.names)[:80]!r}: they must be part and any of "
            f"{', '.join(QUANTITIES)}, separated by commas."
        )
    return table.rows


def _match_row(
    name: str,
    values: Mapping[str, float],
    parts: Mapping[str, str],
    members: Sequence[Design],
    present: Set[str | None],
) -> str | None:
    """Return the name of the part that a row of a form is about, or None for a walker that is not a member.

    `values` has masses, g, by column. `parts` has part names by the names in files. Raises InputError, which
    suggests no part of `present`, those in other rows.
    """
    if not any(name in carried_rows(design) for design in members):
        return _match_part(name, parts, members, present)
    if wrong := [quantity for quantity in values if quantity != "grams"]:
        raise InputError(f"{name}: {wrong[0]}: it has neither body nor legs. Write its mass as grams.")
    return name


def _parse_masses(row: Mapping[str, str]) -> dict[str, float]:
    """Return the masses in a row, g, by the column's name, without blank cells. Raises InputError."""
    values = {}
    for quantity in QUANTITIES:
        if cell := row.get(quantity, "").strip():
            value = formatting.parse_number(cell)
            if value is None or not MIN_MASS_G <= value <= MAX_MASS_G:
                advice = ". Write a decimal point instead of the comma" if "," in cell else ""
                raise InputError(
                    f"{quantity} = {cell[:30]!r}: must be a number in {MIN_MASS_G:g}..{MAX_MASS_G:g}, in grams{advice}"
                )
            values[quantity] = value
    return values


def _names_to_parts(members: Sequence[Design]) -> dict[str, str]:
    """Return the part name of each member, by every name that a file may use for it."""
    return {
        names.part_name(design, stem): names.part_name(design)
        for design in members
        for stem in (design.name, names.DEFAULT_STEM)
    }


def _find_part(name: str, parts: Mapping[str, str]) -> str | None:
    """Return the part name of a walker that a file calls `name`, also with a copy's number (NAME-3), else None."""
    return parts.get(name) or parts.get(COPY_SUFFIX.sub("", name))


def _tilt_from_name(name: str) -> float | None:
    """Return the tilt (deg) in the name of a walker, such as 5 for walker_t05.0_flexible_s0.40; None without one."""
    match = PART_NAME_PATTERN.match(name)
    return formatting.parse_number(match["tilt"]) if match else None


def _match_part(name: str, parts: Mapping[str, str], members: Sequence[Design], present: Set[str | None]) -> str | None:
    """Return the part name of a walker that a file calls `name`; None for another walker of the members' designs.

    `parts` has part names by the names in files. Raises InputError, and suggests no part in `present`.
    """
    if (part := _find_part(name, parts)) or _is_other_member(COPY_SUFFIX.sub("", name), members):
        return part
    listed = list(dict.fromkeys(parts.values()))
    alike = [part_name for part_name in listed if _tilt_from_name(part_name) == _tilt_from_name(name)]
    close = difflib.get_close_matches(name, alike, n=3, cutoff=0.6)
    near = [part_name for part_name in close if part_name not in present]
    hint = f" Did you mean {', '.join(near)}?" if near else f" Selected parts: {', '.join(listed[:3])} ..."
    raise InputError(
        f"part {name[:60]!r}: is not among the parts that ‹tilt› and ‹legs› select. "
        f"Correct its name, or select it.{hint}"
    )


def _is_other_member(name: str, members: Sequence[Design]) -> bool:
    """Return whether this is the name of a walker of another tilt or kind of a member's design."""
    match = PART_NAME_PATTERN.fullmatch(name)
    if match is None:
        return False
    for design_members in names.group_by_design(members).values():
        kind: Any = match["kind"]
        try:
            variant = design_members[0].variant(tilt_deg=float(match["tilt"]), kind=kind)
        except (InputError, GeometryError, ValueError):  # the design has no such walker
            continue
        stem = match["stem"]
        if stem in (variant.name, names.DEFAULT_STEM) and names.part_name(variant, stem) == name:
            return True
    return False


def _mean_mass(values: Sequence[float]) -> Quantity:
    """Return the mean of masses in g, with its standard error from their spread (None for a single mass)."""
    count = len(values)
    error = float(np.std(values, ddof=1)) / math.sqrt(count) if count > 1 else None
    return Quantity("mass", "g", float(np.mean(values)), error, count - 1.0)


def write_form(folder: Path, parts: Iterable[str], name: str = FILE_NAME) -> Path | None:
    """Write a blank form for weighed masses, folder/NAME, and return its path; None if a user has changed the form.

    A form of the same parts in another order stays unchanged: a user may have sorted it. Raises InputError and
    OutputError.
    """
    path, rows = folder / name, list(parts)
    if is_filled_in(path):
        return None
    if sorted(_read_blank_form(path) or ()) != sorted(rows):
        output.write(path, format_form(rows).encode())
    return path
