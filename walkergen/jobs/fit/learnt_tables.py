"""Tables of what simulated speeds taught: console, Markdown, CSV, JSON."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from rich import box
from rich.markup import escape
from rich.table import Table

from walkergen.analysis.estimates import Estimate, with_error
from walkergen.analysis.speeds import Measured
from walkergen.files import words
from walkergen.files.tables import as_markdown, csv_text
from walkergen.jobs.fit.lessons import Learnt
from walkergen.jobs.fit.posterior import Posterior

if TYPE_CHECKING:
    from walkergen.jobs.fit.learn import Band, Learned

Array = npt.NDArray[np.float64]

DRAWS = 512
"""Draws of the posterior that are written."""


def to_table(rows: Sequence[Learnt], title: str, form: box.Box = box.SIMPLE_HEAD) -> Table:
    """Table of every parameter: after the fit, and before it."""
    table = Table(title=escape(title) or None, box=form, padding=(0, 1, 0, 0), pad_edge=False)
    for heading in ("parameter", "mean ± sd", "95 % interval", "before"):
        table.add_column(heading)
    for row in rows:
        table.add_row(
            row.name.replace("_", " "), with_error(Estimate(row.mean, row.sd)),
            words.span(row.low_95, row.high_95, 3), row.prior,
        )  # fmt: skip
    return table


def bands_table(bands: "Sequence[Band]", form: box.Box = box.SIMPLE_HEAD) -> Table:
    """Table of the speeds of one more print, by tilt."""
    table = Table(box=form, padding=(0, 1, 0, 0), pad_edge=False)
    for heading in ("tilt", "plate, mm/s", "one more print, mm/s", "68 %", "95 %", ""):
        table.add_column(heading)
    for band in bands:
        table.add_row(
            f"{band.tilt_deg:g}", f"{band.plate_speed_mm_s:.1f}", f"{band.speed_mm_s:.1f}",
            f"{band.low_68:.1f} to {band.high_68:.1f}",
            f"{band.low_95:.1f} to {band.high_95:.1f}",
            "measured" if band.measured else "predicted",
        )  # fmt: skip
    return table


def quality(found: Posterior, count: int) -> str:
    """Statement of how well the model describes the speeds and how well it was sampled."""
    return (
        f"chi² {found.chi2:.3g} for {count} speeds at best; {found.steps} draws are worth "
        f"{found.independent:.0f} independent ones"
    )


def to_markdown(learned: "Learned", title: str, caption: str) -> str:
    """Format a Markdown page with what was learnt and what follows from it."""
    listed = "\n".join(f"- {note}" for note in learned.notes)
    parts = (
        f"# {title}", f"Learnt with {caption}.",
        as_markdown(to_table(learned.rows, "", box.MARKDOWN)),
        f"{quality(learned.posterior, learned.speeds)}.", listed, "Speeds of one more print:",
        as_markdown(bands_table(learned.bands, box.MARKDOWN)),
    )  # fmt: skip
    return "\n\n".join(part for part in parts if part) + "\n"


def to_csv(rows: Sequence[Learnt]) -> str:
    """Format parameters as CSV, a line each."""
    return csv_text(("parameter", *Learnt._fields[1:]), rows)


def bands_to_csv(bands: "Sequence[Band]") -> str:
    """Format predicted speeds as CSV, a line for each setting."""
    return csv_text(
        bands[0]._fields, [(*band[:2], int(band.measured), *band[3:]) for band in bands]
    )


def points_to_csv(seen: Measured, bands: "Sequence[Band]") -> str:
    """Format measured speeds and those predicted for one more print side by side as CSV."""
    by = {(band.tilt_deg, band.plate_speed_mm_s): band for band in bands}
    header = (
        "tilt_deg", "legs", "plate_speed_mm_s", "speed_mm_s", "speed_se_mm_s", "fit_mm_s",
        "low_95", "high_95",
    )  # fmt: skip
    lines = []
    errors = [None] * len(seen.speed) if seen.se is None else seen.se
    columns = zip(seen.tilt, seen.legs, seen.plate_speed, seen.speed, errors, strict=True)
    for row in columns:
        band = by[float(row[0]), float(row[2])]
        lines.append((*row, band.speed_mm_s, band.low_95, band.high_95))
    return csv_text(header, lines)


def draws_to_csv(names: Sequence[str], draws: Array) -> str:
    """Format DRAWS of the posterior's draws (k, parameters) as CSV."""
    picked = np.linspace(0, len(draws) - 1, min(DRAWS, len(draws))).round().astype(int)
    return csv_text(names, draws[picked].tolist())


def as_dict(learned: "Learned") -> dict[str, Any]:
    """All results but the draws for JSON."""
    found = learned.posterior
    return {
        "parameters": {row.name: row._asdict() for row in learned.rows},
        "correlation": np.atleast_2d(np.corrcoef(found.draws.T)).tolist(),
        "bands": [band._asdict() for band in learned.bands],
        "chi2": found.chi2,
        "steps": found.steps,
        "autocorrelation_steps": found.correlation,
        "independent_draws": found.independent,
    }
