"""Statements of published work on crowds of walkers, as `published.toml` has them.

Their numbers are of other grains than ours, which no number of ours can contradict: what is compared is the sign.
"""

import tomllib
from pathlib import Path
from typing import NamedTuple


class Source(NamedTuple):
    """Published work, and how much of it was read for this table."""

    citation: str
    address: str
    read: str
    """Part that was read; the statements are from nowhere else."""


class Claim(NamedTuple):
    """How a statement is compared: the series of our crowds that shows it, and the sign that is stated."""

    series: str
    number: str
    quantity: str
    """Our quantity in words."""
    setting: str
    """Varied setting with its unit."""
    rises: bool
    """Whether the number rises from the first setting to the last, or falls."""
    differs: str
    """Difference of our crowds from those of the source."""


class Finding(NamedTuple):
    """One statement of published work on crowds."""

    key: str
    source: Source
    quote: str
    """Words of the source."""
    sign: str
    """Expected result for our walkers, without a number."""
    values: tuple[float, ...] = ()
    """Numbers that the part read states; none where only the sign is known."""
    unit: str = ""
    claims: tuple[Claim, ...] = ()
    not_compared: str = ""
    """Reason why no number of ours is compared with it."""

    @property
    def stated(self) -> str:
        """The numbers as the table shows them, or that there is the sign alone."""
        numbers = ", ".join(f"{value:g}" for value in self.values)
        return f"{numbers} {self.unit}".strip() if numbers else "sign only"


def read_findings() -> tuple[Finding, ...]:
    """Return all statements, source by source."""
    data = tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))
    findings = []
    for entry in data["source"]:
        statements = entry.pop("finding")
        for statement in statements:
            claims = tuple(Claim(**claim) for claim in statement.pop("claim", ()))
            values = tuple(statement.pop("values", ()))
            findings.append(Finding(source=Source(**entry), claims=claims, values=values, **statement))
    return tuple(findings)


FINDINGS = read_findings()
