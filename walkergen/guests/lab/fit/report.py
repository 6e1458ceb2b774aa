"""Report of a fit: parameters, predicted speeds of one more print, and the fitted scene and design."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from walkergen.analysis.speeds import Measured
from walkergen.core.files import formatting
from walkergen.files import report
from walkergen.files.report import Column, Table
from walkergen.guests.lab.fit.least_squares import ContactFit
from walkergen.guests.lab.fit.model_fit import ModelFit
from walkergen.guests.lab.fit.theory import Fitted
from walkergen.guests.lab.report import LabReport, Setup

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.figure import Figure

MAX_DRAWS = 512
"""Largest number of draws of the posterior that are written."""

SPEED_COLUMNS = ("tilt_deg", "legs", "plate_speed_mm_s", "speed_mm_s", "speed_se_mm_s", "fit_mm_s")
"""Columns of speeds.csv: measured and fitted speeds."""


@dataclass(frozen=True, kw_only=True, repr=False)
class FitReport(LabReport):
    """Contact fitted to measured speeds, and the design and scene with the fitted values."""

    @property
    def bands(self) -> Table:
        """Table of predicted speeds (mm/s) of another print at every tilt, with bounds. The model theory has none."""
        return self["bands"]


def make_theory_report(fitted: Fitted, setup: Setup, caption: str, path: Path, folder: Path) -> FitReport:
    """Make the report of the theory's contact, fitted to the file of speeds `path`."""
    fit = fitted.fit
    rows = [
        (name, value, fit.errors.get(name), *fit.intervals.get(name, (None, None)), _origin(fit, name))
        for name, value in fit.values.items()
    ]
    columns = (
        Column("parameter", lambda row: row[0].replace("_", " ")),
        Column("value ± standard error", lambda row: _format_value(row[1], row[2], row[-1])),
        Column(
            "68 % interval (profile)",
            lambda row: "given" if row[-1] == "given" else formatting.format_range(row[3], row[4]),
        ),
    )
    keys = ("parameter", "value", "se", "low_68", "high_68", "origin")
    facts = {
        "parameters": {
            name: {
                "value": value,
                "se": fit.errors.get(name),
                "interval_68": list(fit.intervals[name]) if name in fit.intervals else None,
                "fitted": name in fit.errors,
            }
            for name, value in fit.values.items()
        },
        "fitted": fit.free,
        "covariance": fit.covariance.tolist(),
        "correlation": fit.correlation.tolist(),
        "chi2": fit.chi2,
        "dof": fit.dof,
        "p_value": fit.p_value,
        "predicted_mm_s": fit.predicted.tolist(),
    }
    tables = [
        Table("fit", rows, keys, columns, "Parameters"),
        _speed_table(fitted.seen, [(speed,) for speed in fit.predicted], SPEED_COLUMNS),
    ]

    def draw() -> "Figure":
        from walkergen.guests.lab.fit import figures

        return figures.draw_fit(fitted.seen, fitted.curves, path.name)

    lines = [format_quality(fit), *format_correlations(fit)]
    return _make_report(path, caption, tables, facts, lines, fitted, setup.design, draw, folder)


def make_model_report(fitted: ModelFit, caption: str, path: Path, folder: Path) -> FitReport:
    """Make the report of a model fitted to the file of speeds `path`."""
    posterior = fitted.posterior
    columns = (
        Column("parameter", lambda row: row.name.replace("_", " ")),
        report.error_column("mean ± sd", "mean", "sd"),
        report.interval_column("95 % interval", "low_95", "high_95", 3),
        Column("before", lambda row: row.prior if row.measured else f"{row.prior}, assumed"),
    )
    kept = np.linspace(0, len(posterior.draws) - 1, min(MAX_DRAWS, len(posterior.draws))).round().astype(int)
    by_setting = {(band.tilt_deg, band.plate_speed_mm_s): band for band in fitted.bands}
    settings = zip(map(float, fitted.seen.tilt), map(float, fitted.seen.plate_speed), strict=True)
    bounds = [(by_setting[key].speed_mm_s, by_setting[key].low_95, by_setting[key].high_95) for key in settings]
    tables = [
        Table("fit", fitted.rows, ("parameter", *fitted.rows[0]._fields[1:]), columns, "Parameters"),
        report.table_from_rows("bands", fitted.bands, BAND_COLUMNS, "Predicted speeds of another print"),
        _speed_table(fitted.seen, bounds, (*SPEED_COLUMNS, "low_95", "high_95")),
        Table("posterior", posterior.draws[kept].tolist(), [row.name for row in fitted.rows]),
    ]
    facts = {
        "parameters": {row.name: row._asdict() for row in fitted.rows},
        "correlation": np.atleast_2d(np.corrcoef(posterior.draws.T)).tolist(),
        "bands": [band._asdict() | {"measured": bool(band.measured)} for band in fitted.bands],
        "chi2": posterior.chi2,
        "steps": posterior.steps,
        "autocorrelation_steps": None,
        "independent_draws": posterior.independent,
    }
    sampled = (
        f"smallest chi² {posterior.chi2:.3g} for {len(fitted.seen.speed)} speeds; "
        f"{posterior.steps} draws are worth {posterior.independent:.0f} independent ones"
    )

    def draw() -> "Figure":
        from walkergen.guests.lab.fit import figures

        return figures.draw_bands(fitted.bands, fitted.seen, path.name)

    made = _make_report(path, caption, tables, facts, [sampled], fitted, fitted.design, draw, folder)
    return replace(made, headline="; ".join(fitted.contradictions) or _describe_agreement(fitted))


def _describe_agreement(fitted: ModelFit) -> str:
    """Return a sentence on the fitted contact, with the measured values with which it agrees."""
    values = {
        row.name: f"{row.name.replace('_', ' ')} {formatting.format_with_error(row.mean, row.sd)}"
        for row in fitted.rows
    }
    contact = [values[name] for name in ("restitution", "friction") if name in values] or list(values.values())[:1]
    measured = [row.name for row in fitted.rows if row.measured]
    agrees = f", consistent with the measured {', '.join(measured)}" if measured else "; nothing is stated as measured"
    return f"{' and '.join(contact)} from {len(fitted.seen.speed)} speeds{agrees}"


def _make_report(
    path: Path,
    caption: str,
    tables: Sequence[Table],
    facts: Mapping[str, Any],
    lines: Sequence[str],
    result: Fitted | ModelFit,
    design: Any,
    draw: "Callable[[], Figure]",
    folder: Path,
) -> FitReport:
    """Return the report of a fit of the theory or a model. `lines`: its first lines. `draw`: draws its figure."""
    return FitReport(
        name="fit",
        title=path.name,
        caption=caption,
        tables=tables,
        facts={**facts, "notes": result.notes},
        lines=[*lines, *result.notes],
        figures={"fit": draw},
        folder=folder,
        scene=result.scene,
        design=design,
        settings={},
        notes=result.notes,
    )


def _speed_table(seen: Measured, fitted: Sequence[tuple[float, ...]], keys: Sequence[str]) -> Table:
    """Return the table of measured speeds, each row followed by its values in `fitted`. `keys`: names of columns."""
    errors = [None] * len(seen.speed) if seen.se is None else seen.se
    measured = zip(seen.tilt, seen.legs, seen.plate_speed, seen.speed, errors, strict=True)
    return Table("speeds", [(*row, *bounds) for row, bounds in zip(measured, fitted, strict=True)], keys)


def _origin(fit: ContactFit, name: str) -> str:
    return "fitted" if name in fit.errors else "given"


def _format_value(value: float, se: float | None, origin: str) -> str:
    """Format a parameter's value, with its standard error `se` unless `origin` is "given"."""
    if origin == "given":
        return formatting.format_number(value, 6)
    return f"{formatting.format_number(value, 4)} ± unknown" if se is None else formatting.format_with_error(value, se)


def format_quality(fit: ContactFit) -> str:
    """Describe the quality of the theory's fit to the speeds."""
    if fit.chi2 is None:
        return (
            f"{fit.dof} degrees of freedom; no standard errors given, so those here come from the scatter about the fit"
        )
    return f"chi² {fit.chi2:.3g} for {fit.dof} degrees of freedom, probability {fit.p_value:.2g}"


def format_correlations(fit: ContactFit) -> Iterator[str]:
    """Yield one line with the correlations of all pairs of fitted parameters, or nothing for a single parameter."""
    pairs = [
        f"{first}, {second}: {fit.correlation[i, j]:+.3f}"
        for (i, first), (j, second) in combinations(enumerate(fit.free), 2)
    ]
    if pairs:
        yield "correlations: " + "; ".join(pairs)


BAND_COLUMNS = (
    Column("tilt", lambda band: f"{band.tilt_deg:g}"),
    Column("plate, mm/s", lambda band: f"{band.plate_speed_mm_s:.1f}"),
    Column("another print, mm/s", lambda band: f"{band.speed_mm_s:.1f}"),
    Column("68 %", lambda band: f"{band.low_68:.1f} to {band.high_68:.1f}"),
    Column("95 %", lambda band: f"{band.low_95:.1f} to {band.high_95:.1f}"),
    Column("", lambda band: "measured" if band.measured else "predicted"),
)
