"""Tables of a fitted contact: console, Markdown, CSV, JSON."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from rich import box
from rich.markup import escape
from rich.table import Table

from walkergen.analysis.estimates import Estimate, with_error
from walkergen.analysis.fits import ContactFit, Speeds
from walkergen.files import words
from walkergen.files.tables import as_markdown, csv_text

Array = npt.NDArray[np.float64]


def to_table(fit: ContactFit, title: str, form: box.Box = box.SIMPLE_HEAD) -> Table:
    """Table of every parameter with its standard error and its 68 % interval."""
    table = Table(title=escape(title) or None, box=form, padding=(0, 1, 0, 0), pad_edge=False)
    for heading in ("parameter", "value ± standard error", "68 % interval (profile)"):
        table.add_column(heading)
    for row in _rows(fit):
        table.add_row(*row)
    return table


def _rows(fit: ContactFit) -> Iterator[tuple[str, str, str]]:
    for name, value in fit.values.items():
        shown = name.replace("_", " ")
        if name not in fit.errors:
            yield shown, words.number(value, 6), "given"
            continue
        error = fit.errors[name]
        told = (
            f"{words.number(value, 4)} ± unknown"
            if error is None
            else with_error(Estimate(value, error))
        )
        yield shown, told, words.span(*fit.intervals[name])


def quality(fit: ContactFit) -> str:
    """Statement of how well the theory describes the speeds."""
    if fit.chi2 is None:
        return (
            f"{fit.dof} degrees of freedom; no standard errors given, so those here come from the "
            "scatter about the fit"
        )
    return f"chi² {fit.chi2:.3g} for {fit.dof} degrees of freedom, probability {fit.p_value:.2g}"


def correlations(fit: ContactFit) -> str:
    """Correlations of all pairs of fitted parameters; '' for a single parameter."""
    names = fit.free
    pairs = [
        f"{names[i]}, {names[j]}: {fit.correlation[i, j]:+.3f}"
        for i in range(len(names))
        for j in range(i + 1, len(names))
    ]
    return "correlations: " + "; ".join(pairs) if pairs else ""


def to_markdown(fit: ContactFit, title: str, caption: str, notes: Sequence[str]) -> str:
    """Format a Markdown page with the parameters and what they rest on."""
    listed = "\n".join(f"- {note}" for note in notes)
    parts = (f"# {title}", f"Fitted with {caption}.", as_markdown(to_table(fit, "", box.MARKDOWN)),
             quality(fit) + ".", correlations(fit), listed)  # fmt: skip
    return "\n\n".join(part for part in parts if part) + "\n"


COLUMNS = ("parameter", "value", "se", "low_68", "high_68", "origin")


def lines(fit: ContactFit) -> Iterator[tuple[object, ...]]:
    """Parameters by COLUMNS: standard error and 68 % interval are None where there is none."""
    for name, value in fit.values.items():
        ends = fit.intervals.get(name, (None, None))
        origin = "fitted" if name in fit.errors else "given"
        yield name, value, fit.errors.get(name), *ends, origin


def to_csv(fit: ContactFit) -> str:
    """Format as CSV, a line per parameter."""
    return csv_text(COLUMNS, lines(fit))


def points_to_csv(tilt: Array, legs: Sequence[str], speeds: Speeds, fitted: Array) -> str:
    """Format measured and fitted speeds side by side as CSV."""
    errors = [None] * len(tilt) if speeds.se is None else list(speeds.se)
    header = ("tilt_deg", "legs", "plate_speed_mm_s", "speed_mm_s", "speed_se_mm_s", "fit_mm_s")
    lines = zip(tilt, legs, speeds.plate_speed, speeds.speed, errors, fitted, strict=True)
    return csv_text(header, lines)


def as_dict(fit: ContactFit) -> dict[str, Any]:
    """All results for JSON; `se` is null for fixed parameters and for those left undetermined."""
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
