"""Tables of a calibration: console, Markdown, CSV, JSON."""

from collections.abc import Iterator
from typing import Any, NamedTuple

from rich import box
from rich.markup import escape
from rich.table import Table

from walkergen.analysis.estimates import Estimate, with_error
from walkergen.files.tables import as_markdown, csv_text
from walkergen.jobs.calibration.make import Bent, Calibrated


class Row(NamedTuple):
    """Number that was measured; the field names are the columns of calibration.csv."""

    quantity: str
    value: float
    se: float
    unit: str
    readings: int
    chi2: float
    dof: int
    key: str
    """Key that it sets; blank where it sets none."""


def rows(found: Calibrated) -> Iterator[Row]:
    """Rows of all numbers that were measured."""
    if found.bent is not None:
        fit, points = found.bent.fit, found.bent.points
        counted = sum(one.readings for one in points if found.bent.by in (one.method, "both"))
        yield Row("Young's modulus", fit.modulus, fit.sd, "GPa", counted, fit.chi2, fit.dof,
                  "material.youngs_modulus_gpa")  # fmt: skip
        ring, off = found.bent.ring_over_bend, found.bent.offset
        if ring is not None:
            yield Row("ring over weights", 100.0 * ring.value, 100.0 * ring.sd, "%",
                      0, 0.0, 0, "")  # fmt: skip
        if off is not None:
            yield Row("offset of thicknesses", off.value, off.sd, "mm", 0, 0.0, 0, "")
    for what, value, unit, key in (
        ("density", found.density, "g/cm3", "material.density_g_cm3"),
        ("friction", found.friction, "", "scene.contact.friction"),
        ("damping ratio", found.damping, "", "scene.legs.damping_ratio"),
    ):
        if value is not None:
            dof = len(value.parts) - 1
            yield Row(what, value.value, value.sd, unit, value.readings, value.chi2, dof, key)
    if found.bounced is not None:
        rebound = found.bounced.rebound
        seen = rebound.measured
        yield Row("rebound of the walker", seen.value, rebound.sd, "", seen.tries, 0.0, 0, "")
        if one := found.bounced.single:
            yield Row("restitution of the feet", one.value, 0.5 * (one.high - one.low), "",
                      seen.tries, 0.0, 0, "scene.contact.restitution")  # fmt: skip


def to_table(found: Calibrated, title: str, form: box.Box = box.SIMPLE_HEAD) -> Table:
    """Table of what was measured, with errors and the keys that are set."""
    table = Table(title=escape(title) or None, box=form, padding=(0, 1, 0, 0), pad_edge=False)
    table.add_column("measured")
    table.add_column("value ± error", no_wrap=True)
    table.add_column("readings", justify="right")
    table.add_column("sets")
    for one in rows(found):
        told = f"{with_error(Estimate(one.value, one.se))} {one.unit}".strip()
        table.add_row(one.quantity, told, str(one.readings or ""), one.key)
    return table


def strips_table(bent: Bent, form: box.Box = box.SIMPLE_HEAD) -> Table:
    """Table of the modulus by each strip and method alone."""
    table = Table(title="Young's modulus by each strip alone" if form is box.SIMPLE_HEAD else None,
                  box=form, padding=(0, 1, 0, 0), pad_edge=False)  # fmt: skip
    for heading in ("strip", "by", "thickness mm", "modulus GPa", "from all, errors"):
        table.add_column(heading, justify="right" if heading[0] in "tf" else "left")
    for one in bent.points:
        away = (one.modulus - bent.fit.modulus) / one.sd
        told = with_error(Estimate(one.modulus, one.sd))
        table.add_row(one.strip, one.method, f"{one.thickness:.3f}", told, f"{away:+.1f}")
    return table


def lines(found: Calibrated) -> list[str]:
    """Quality of the fit, answer of the drop test, and notes, a line each."""
    quality = []
    if found.bent is not None and found.bent.fit.probability is not None:
        fit = found.bent.fit
        quality = [
            f"strips: chi2 {fit.chi2:.1f} for {fit.dof} degrees of freedom, probability "
            f"{fit.probability:.2g}"
        ]
    told = [] if found.bounced is None else [f"drop: {found.bounced.told}"]
    return [*quality, *told, *found.notes]


def to_markdown(found: Calibrated, title: str) -> str:
    """Format a Markdown page of tables and notes."""
    told = [f"# {title}", as_markdown(to_table(found, "", box.MARKDOWN))]
    if found.bent is not None:
        table = as_markdown(strips_table(found.bent, box.MARKDOWN))
        told += ["## Young's modulus by each strip alone", table]
    told.append("\n".join(f"- {line}" for line in lines(found)))
    return "\n\n".join(told).strip() + "\n"


def to_csv(found: Calibrated) -> str:
    """Format what was measured as CSV, with every digit."""
    return csv_text(Row._fields, rows(found))


def strips_csv(bent: Bent) -> str:
    """Format the points of the figure as CSV."""
    header = ("strip", "by", "thickness_mm", "modulus_gpa", "modulus_se_gpa", "readings")
    return csv_text(header, [
        (one.strip, one.method, one.thickness, one.modulus, one.sd, one.readings)
        for one in bent.points
    ])  # fmt: skip


def as_dict(found: Calibrated) -> dict[str, Any]:
    """All results for JSON."""
    bounced = found.bounced
    return {
        "measured": [one._asdict() for one in rows(found)],
        "strips": [] if found.bent is None else [one._asdict() for one in found.bent.points],
        "probability": None if found.bent is None else found.bent.fit.probability,
        "drop": None if bounced is None else {
            "told": bounced.told,
            "branches": [one._asdict() for one in bounced.inverse.branches],
        },
        "settings": found.settings,
        "notes": found.notes,
        "folder": str(found.folder),
    }  # fmt: skip
