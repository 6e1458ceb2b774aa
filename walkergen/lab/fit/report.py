"""Report of a fit: parameters, speeds of one more print, and the scene and design that go on."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.analysis.fits import ContactFit
from walkergen.analysis.speeds import Measured
from walkergen.files import report, words
from walkergen.files.report import Column, Report, Table
from walkergen.lab.fit import make
from walkergen.lab.fit.learn import Band, Learned
from walkergen.lab.fit.make import Fitted
from walkergen.scene import Scene
from walkergen.walker.design import Design

Array = npt.NDArray[np.float64]

DRAWS = 512
"""Draws of the posterior that are written."""


@dataclass(frozen=True, kw_only=True, repr=False)
class FitReport(Report):
    """Contact, and more, that measured speeds tell; design and scene go on with it."""

    scene: Scene
    design: Design
    notes: Sequence[str]
    """What the speeds leave open, and rows that were left out."""

    @property
    def bands(self) -> Table:
        """Speeds of one more print at every tilt, with bounds, mm/s; of the theory none."""
        return self["bands"]


class Fixed(NamedTuple):
    """Parameter of the theory, fitted or given."""

    parameter: str
    value: float
    se: float | None
    low_68: float | None
    high_68: float | None
    origin: str


def of_theory(fitted: Fitted, path: Path, caption: str, folder: Path) -> FitReport:
    """Report of the theory's contact, fitted to a file of speeds."""
    fit, speeds = fitted.fit, fitted.speeds
    rows = [
        Fixed(
            name,
            value,
            fit.errors.get(name),
            *fit.intervals.get(name, (None, None)),
            "fitted" if name in fit.errors else "given",
        )
        for name, value in fit.values.items()
    ]
    columns = (
        Column("parameter", lambda row: row.parameter.replace("_", " ")),
        Column("value ± standard error", _value),
        Column("68 % interval (profile)", _interval),
    )
    errors = [None] * len(fitted.tilt) if speeds.se is None else list(speeds.se)
    sides = (fitted.tilt, fitted.legs, speeds.plate_speed, speeds.speed, errors, fit.predicted)
    keys = ("tilt_deg", "legs", "plate_speed_mm_s", "speed_mm_s", "speed_se_mm_s", "fit_mm_s")
    points = Table("speeds", list(zip(*sides, strict=True)), keys)

    def draw() -> Any:
        from walkergen.lab.fit import figures

        return figures.fit_figure(fitted.tilt, fitted.legs, speeds, make.curves(fitted), path.name)

    return FitReport(
        name="fit",
        title=path.name,
        caption=f"fitted with {caption}",
        tables=[report.table("fit", rows, columns, "Parameters"), points],
        facts=_facts_of_theory(fit) | {"notes": fitted.notes},
        lines=[quality(fit), *correlations(fit), *fitted.notes],
        figures={"fit": draw},
        folder=folder,
        scene=fitted.scene,
        design=fitted.design,
        notes=fitted.notes,
    )


def _value(row: Fixed) -> str:
    if row.origin == "given":
        return words.number(row.value, 6)
    if row.se is None:
        return f"{words.number(row.value, 4)} ± unknown"
    return words.with_error(row.value, row.se)


def _interval(row: Fixed) -> str:
    return "given" if row.origin == "given" else words.span(row.low_68, row.high_68)


def quality(fit: ContactFit) -> str:
    """Statement of how well the theory describes the speeds."""
    if fit.chi2 is None:
        return (
            f"{fit.dof} degrees of freedom; no standard errors given, so those here come from the scatter about the fit"
        )
    return f"chi² {fit.chi2:.3g} for {fit.dof} degrees of freedom, probability {fit.p_value:.2g}"


def correlations(fit: ContactFit) -> Iterator[str]:
    """Correlations of all pairs of fitted parameters in one line; none of a single parameter."""
    pairs = [
        f"{first}, {second}: {fit.correlation[i, j]:+.3f}"
        for (i, first), (j, second) in combinations(enumerate(fit.free), 2)
    ]
    if pairs:
        yield "correlations: " + "; ".join(pairs)


def _facts_of_theory(fit: ContactFit) -> dict[str, Any]:
    """Results for JSON; `se` is null for fixed parameters and for those left undetermined."""
    return {
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


def of_model(learned: Learned, path: Path, caption: str, folder: Path) -> FitReport:
    """Report of what a model learnt from a file of speeds."""
    parameters = (
        Column("parameter", lambda row: row.name.replace("_", " ")),
        report.with_error("mean ± sd", "mean", "sd"),
        report.span("95 % interval", "low_95", "high_95", 3),
        report.text("before", "prior"),
    )
    keys = ("parameter", *learned.rows[0]._fields[1:])
    draws = learned.posterior.draws
    few = np.linspace(0, len(draws) - 1, min(DRAWS, len(draws))).round().astype(int)

    def draw() -> Any:
        from walkergen.lab.fit import figures

        return figures.bands_figure(learned.bands, learned.seen, path.name)

    return FitReport(
        name="fit",
        title=path.name,
        caption=f"learnt with {caption}",
        tables=[
            Table("fit", learned.rows, keys, parameters, "Parameters"),
            report.table("bands", learned.bands, _of_bands(), "Speeds of one more print"),
            _points(learned.seen, learned.bands),
            Table("posterior", draws[few].tolist(), [row.name for row in learned.rows]),
        ],
        facts=_facts_of_model(learned),
        lines=[_sampled(learned), *learned.notes],
        figures={"fit": draw},
        folder=folder,
        scene=learned.scene,
        design=learned.design,
        notes=learned.notes,
    )


def _of_bands() -> Sequence[Column]:
    return (
        Column("tilt", lambda band: f"{band.tilt_deg:g}"),
        Column("plate, mm/s", lambda band: f"{band.plate_speed_mm_s:.1f}"),
        Column("one more print, mm/s", lambda band: f"{band.speed_mm_s:.1f}"),
        Column("68 %", lambda band: f"{band.low_68:.1f} to {band.high_68:.1f}"),
        Column("95 %", lambda band: f"{band.low_95:.1f} to {band.high_95:.1f}"),
        Column("", lambda band: "measured" if band.measured else "predicted"),
    )


def _sampled(learned: Learned) -> str:
    """Statement of how well the model describes the speeds and how well it was sampled."""
    posterior = learned.posterior
    return (
        f"chi² {posterior.chi2:.3g} for {len(learned.seen.speed)} speeds at best; "
        f"{posterior.steps} draws are worth {posterior.independent:.0f} independent ones"
    )


def _points(seen: Measured, bands: Sequence[Band]) -> Table:
    """Measured speeds and those predicted for one more print side by side."""
    by = {(band.tilt_deg, band.plate_speed_mm_s): band for band in bands}
    keys = ("tilt_deg", "legs", "plate_speed_mm_s", "speed_mm_s", "speed_se_mm_s", "fit_mm_s", "low_95", "high_95")
    errors = [None] * len(seen.speed) if seen.se is None else seen.se
    rows = []
    settings = zip(seen.tilt, seen.legs, seen.plate_speed, strict=True)
    for setting, speed, error in zip(settings, seen.speed, errors, strict=True):
        tilt, _, plate = setting
        band = by[float(tilt), float(plate)]
        rows.append((*setting, speed, error, band.speed_mm_s, band.low_95, band.high_95))
    return Table("speeds", rows, keys)


def _facts_of_model(learned: Learned) -> dict[str, Any]:
    """All results but the draws for JSON."""
    posterior = learned.posterior
    return {
        "parameters": {row.name: row._asdict() for row in learned.rows},
        "correlation": np.atleast_2d(np.corrcoef(posterior.draws.T)).tolist(),
        "bands": [band._asdict() | {"measured": bool(band.measured)} for band in learned.bands],
        "chi2": posterior.chi2,
        "steps": posterior.steps,
        "autocorrelation_steps": posterior.correlation,
        "independent_draws": posterior.independent,
        "notes": learned.notes,
    }
