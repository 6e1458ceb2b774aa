"""Report of a calibration: measured quantities, each strip alone, and the resulting keys."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from walkergen.core.files import formatting
from walkergen.files.report import Column, Table
from walkergen.guests.lab.calibrate.estimate import Estimate
from walkergen.guests.lab.calibrate.modulus import Moduli, Point
from walkergen.guests.lab.inverse import Answer
from walkergen.guests.lab.report import LabReport, Setup

ESTIMATE_COLUMNS = ("quantity", "value", "se", "unit", "readings", "chi2", "dof", "key")
"""Columns of calibration.csv."""

STRIP_COLUMNS = ("strip", "by", "thickness_mm", "modulus_gpa", "modulus_se_gpa", "readings")
"""Columns of strips.csv: Young's modulus from one strip and one method."""


def collect_settings(estimates: Sequence[Estimate]) -> dict[str, float]:
    """Return the values that the estimates set, by key of design or scene."""
    return {key: value for each in estimates for key, value in each.settings.items()}


def make_report(
    estimates: Sequence[Estimate],
    moduli: Moduli | None,
    drop: Answer | None,
    notes: Sequence[str],
    measured: Setup,
    title: str,
    folder: Path,
) -> LabReport:
    """Return the report of a form or drop. `drop`: restitution from the drop. `measured`: updated design and scene."""
    columns = (
        Column("measured", lambda row: row[0]),
        Column("value ± error", lambda row: f"{formatting.format_with_error(row[1], row[2])} {row[3]}".strip()),
        Column("readings", lambda row: str(row[4] or ""), right=True),
        Column("sets", lambda row: row[-1]),
    )
    rows = [each.row for each in estimates]
    tables, figures, lines = [Table("calibration", rows, ESTIMATE_COLUMNS, columns, "Measured")], {}, []
    if moduli is not None:
        tables.append(_strip_table(moduli))
        figures["strips"] = lambda: _draw_strips(moduli, f"Young's modulus: {title}")
        if moduli.fit.probability is not None:
            chi2, dof, chance = moduli.fit.chi2, moduli.fit.dof, moduli.fit.probability
            lines.append(f"strips: chi2 {chi2:.1f} for {dof} degrees of freedom, probability {chance:.2g}")
    if drop is not None:
        lines.append(f"drop: {drop.text}")
    settings = collect_settings(estimates)
    facts = {
        "measured": list(tables[0]),
        "strips": [] if moduli is None else [_point_facts(point) for point in moduli.points],
        "probability": None if moduli is None else moduli.fit.probability,
        "drop": drop and {"told": drop.text, "branches": [branch._asdict() for branch in drop.branches]},
        "settings": settings,
        "notes": notes,
    }
    return LabReport(
        name="calibration",
        title=title,
        tables=tables,
        facts=facts,
        lines=[*lines, *notes],
        figures=figures,
        folder=folder,
        design=measured.design,
        scene=measured.scene,
        settings=settings,
        notes=notes,
    )


def _draw_strips(moduli: Moduli, title: str) -> Any:
    from walkergen.guests.lab.calibrate import figures

    return figures.draw_strips(moduli, title)


def _point_facts(point: Point) -> dict[str, Any]:
    """Return the modulus from one strip and one method, for JSON."""
    (thickness, thickness_sd), (modulus, sd) = point.thickness.pair, point.modulus.pair
    names = {"strip": point.strip, "method": point.method, "thickness": thickness, "thickness_sd": thickness_sd}
    return {**names, "modulus": modulus, "sd": sd, "readings": point.readings}


def _strip_table(moduli: Moduli) -> Table:
    """Return the table of Young's modulus from each strip and method alone, as the figure shows it."""
    agreed, _ = moduli.fit.number.pair
    rows = [
        (each.strip, each.method, each.thickness.value, *each.modulus.pair, each.readings) for each in moduli.points
    ]
    columns = (
        Column("strip", lambda row: row[0]),
        Column("by", lambda row: row[1]),
        Column("thickness mm", lambda row: f"{row[2]:.3f}", right=True),
        Column("modulus GPa", lambda row: formatting.format_with_error(row[3], row[4])),
        Column("from all, errors", lambda row: f"{(row[3] - agreed) / row[4]:+.1f}", right=True),
    )
    return Table("strips", rows, STRIP_COLUMNS, columns, "Young's modulus by each strip alone")
