"""Statements of published work on single walkers, from `published.toml`, and how ours are compared with them."""

import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Literal, NamedTuple

from walkergen.files import templates

Number = Literal["speed", "size", "range", "ratio"]


class Source(NamedTuple):
    """Published work, and how much of it was read for this table."""

    key: str
    citation: str
    address: str
    read: str
    """Part that was read; the numbers are from nowhere else."""
    ranges: str = ""
    """Name of the sweep that draws the unstated properties; none where nothing is predicted."""

    @property
    def sweep(self) -> Path:
        """File of that sweep, among the templates."""
        return templates.folder() / templates.PUBLISHED_FOLDER / "sweeps" / f"{self.ranges}.toml"


class Statement(NamedTuple):
    """One number, or finding, of published work on walkers that run alone."""

    source: Source
    quantity: str
    unit: str
    where: str
    """Page, figure or table of what was read, and what it says."""
    low: float | None = None
    high: float | None = None
    """Bounds of the published number; none of a finding without one."""
    number: Number = "speed"
    """What is made of a walker's speeds: the speed, its size, the range of sizes over their mean (%), one over it."""
    at: Mapping[str, float | str] = {}
    """Values of the sweep's grid at which the speed is taken."""
    over: Mapping[str, Sequence[float]] = {}
    """Values of a key of the grid over which the mean of sizes is taken."""
    missing: str = ""
    """Unstated or unread properties that prevent a prediction."""

    @property
    def stated(self) -> str:
        """The published number in words."""
        if self.low is None or self.high is None:
            return "no number"
        span = f"{self.low:g}" if self.low == self.high else f"{self.low:g} to {self.high:g}"
        return f"{span} {self.unit}".strip()


def read_statements() -> tuple[Statement, ...]:
    """All statements, source by source."""
    data = tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))
    statements = []
    for entry in data["source"]:
        found = entry.pop("statement")
        source = Source(**entry)
        statements += [Statement(source, **each) for each in found]
    return tuple(statements)


STATEMENTS = read_statements()

SETS = tuple(dict.fromkeys(statement.source.ranges for statement in STATEMENTS if statement.source.ranges))
"""Names of the sets that are predicted."""
