"""Report of a calibration: what was measured, each strip alone, and the keys that follow."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from walkergen.files import report, words
from walkergen.files.report import Column, Report, Table
from walkergen.lab.calibrate.result import Bent, Calibrated
from walkergen.scene import Scene
from walkergen.walker.design import Design


@dataclass(frozen=True, kw_only=True, repr=False)
class CalibrationReport(Report):
    """Material and contact that a calibration plate tells; design and scene go on with them."""

    design: Design
    scene: Scene
    settings: Mapping[str, float]
    """Keys of design and scene (these begin with scene.) that were set, with their values."""


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


class ByStrip(NamedTuple):
    """Young's modulus by a strip and a method alone; the field names are those of strips.csv."""

    strip: str
    by: str
    thickness_mm: float
    modulus_gpa: float
    modulus_se_gpa: float
    readings: int


MEASURED = (
    report.text("measured", "quantity"),
    Column("value ± error", lambda row: f"{words.with_error(row.value, row.se)} {row.unit}".strip()),
    Column("readings", lambda row: str(row.readings or ""), right=True),
    report.text("sets", "key"),
)


def of(result: Calibrated, path: Path, folder: Path) -> CalibrationReport:
    """Report of what a filled form tells."""
    tables = [report.table("calibration", list(rows(result)), MEASURED, "Measured")]
    figures = {}
    if result.bent is not None:
        bent = result.bent
        tables.append(_strips(bent))

        def draw() -> Any:
            from walkergen.lab.calibrate import figures

            return figures.of_strips(bent, f"Young's modulus: {path.name}")

        figures["strips"] = draw
    return CalibrationReport(
        name="calibration",
        title=path.name,
        tables=tables,
        facts=_facts(result),
        lines=_lines(result),
        figures=figures,
        folder=folder,
        design=result.design,
        scene=result.scene,
        settings=result.settings,
    )


def rows(result: Calibrated) -> Iterator[Row]:
    """Rows of all numbers that were measured."""
    if result.bent is not None:
        fit, points = result.bent.fit, result.bent.points
        counted = sum(point.readings for point in points if result.bent.by in (point.method, "both"))
        yield Row(
            "Young's modulus", fit.modulus, fit.sd, "GPa", counted, fit.chi2, fit.dof, "material.youngs_modulus_gpa"
        )
        ring, off = result.bent.ring_over_bend, result.bent.offset
        if ring is not None:
            yield Row("ring over weights", 100.0 * ring.value, 100.0 * ring.sd, "%", 0, 0.0, 0, "")
        if off is not None:
            yield Row("offset of thicknesses", off.value, off.sd, "mm", 0, 0.0, 0, "")
    for what, value, unit, key in (
        ("density", result.density, "g/cm3", "material.density_g_cm3"),
        ("friction", result.friction, "", "scene.contact.friction"),
        ("damping ratio", result.damping, "", "scene.legs.damping_ratio"),
    ):
        if value is not None:
            dof = len(value.parts) - 1
            yield Row(what, value.value, value.sd, unit, value.readings, value.chi2, dof, key)
    if result.bounced is not None:
        rebound = result.bounced.rebound
        seen = rebound.measured
        yield Row("rebound of the walker", seen.value, rebound.sd, "", seen.tries, 0.0, 0, "")
        if branch := result.bounced.single:
            yield Row(
                "restitution of the feet",
                branch.value,
                0.5 * (branch.high - branch.low),
                "",
                seen.tries,
                0.0,
                0,
                "scene.contact.restitution",
            )


def _strips(bent: Bent) -> Table:
    """Modulus by each strip and method alone: the points of the figure."""
    values = [
        ByStrip(point.strip, point.method, point.thickness, point.modulus, point.sd, point.readings)
        for point in bent.points
    ]

    def away(row: ByStrip) -> str:
        return f"{(row.modulus_gpa - bent.fit.modulus) / row.modulus_se_gpa:+.1f}"

    columns = (
        report.text("strip", "strip"),
        report.text("by", "by"),
        Column("thickness mm", lambda row: f"{row.thickness_mm:.3f}", right=True),
        report.with_error("modulus GPa", "modulus_gpa", "modulus_se_gpa"),
        Column("from all, errors", away, right=True),
    )
    return report.table("strips", values, columns, "Young's modulus by each strip alone")


def _lines(result: Calibrated) -> Sequence[str]:
    """Quality of the fit, answer of the drop test, and notes, a line each."""
    quality = []
    if result.bent is not None and result.bent.fit.probability is not None:
        fit = result.bent.fit
        quality = [f"strips: chi2 {fit.chi2:.1f} for {fit.dof} degrees of freedom, probability {fit.probability:.2g}"]
    answer = [] if result.bounced is None else [f"drop: {result.bounced.text}"]
    return [*quality, *answer, *result.notes]


def _facts(result: Calibrated) -> Mapping[str, Any]:
    bounced = result.bounced
    return {
        "measured": [row._asdict() for row in rows(result)],
        "strips": [] if result.bent is None else [point._asdict() for point in result.bent.points],
        "probability": None if result.bent is None else result.bent.fit.probability,
        "drop": None
        if bounced is None
        else {"told": bounced.text, "branches": [branch._asdict() for branch in bounced.inverse.branches]},
        "settings": result.settings,
        "notes": result.notes,
    }
