"""Shipped cells: measured results of every step for the paper's walker on its plate.

cells.csv has a row for each setting of each cell: a scene, a tilt and a restitution of the feet.
`python -m evidence.accuracy.measure` regenerates it.
"""

import csv
from functools import cache
from pathlib import Path
from typing import NamedTuple

CELLS_PATH = Path(__file__).with_suffix(".csv")

REFERENCE_STEP_SHARE = 0.05
"""Reference step, relative to the step that resolves the feet: a tenth of the next finest one."""


class Row(NamedTuple):
    """Speed of a setting in a cell, and its cost; the field names are the CSV's columns."""

    scene: str
    tilt_deg: float
    restitution: float
    """Restitution of the feet."""
    share: float
    """Step relative to the step that resolves the feet."""
    step_us: float
    speed_mm_s: float | None
    """Mean speed; None if a run did not end well."""
    se_mm_s: float | None
    """Standard error from the runs' scatter; None if all runs share one orbit."""
    runs: int
    seconds: float
    """Measured time of each run."""
    work: float
    """CPU time of a simulated second, its discarded start included, relative to the loop's (`machine_speed`)."""
    outcomes: str

    @property
    def cell(self) -> tuple[str, float, float]:
        """Scene, tilt and restitution, which name the cell."""
        return self.scene, self.tilt_deg, self.restitution

    @property
    def variance_time(self) -> float:
        """Squared standard error times measured time, (mm/s)^2 s; 0 on one orbit."""
        return (self.se_mm_s or 0.0) ** 2 * self.runs * self.seconds


@cache
def read_rows(path: Path = CELLS_PATH) -> tuple[Row, ...]:
    """Read the rows of a file."""
    with path.open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(line for line in stream if not line.startswith("#")))
    return tuple(_parse_row(row) for row in rows)


def _parse_row(texts: dict[str, str]) -> Row:
    def number(name: str) -> float | None:
        """Return the number of a column; None if it is blank."""
        return float(texts[name]) if texts[name] else None

    return Row(
        texts["scene"],
        float(texts["tilt_deg"]),
        float(texts["restitution"]),
        float(texts["share"]),
        float(texts["step_us"]),
        number("speed_mm_s"),
        number("se_mm_s"),
        int(texts["runs"]),
        float(texts["seconds"]),
        float(texts["work"]),
        texts["outcomes"],
    )
