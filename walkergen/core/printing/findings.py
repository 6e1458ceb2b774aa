"""Findings of the printability checks: what deviates from the drawing, its limit, a remedy.

An error would fail on the printer (or print another walker); a warning prints, but not as
predicted; an advice is worth knowing.
"""

from collections.abc import Collection, Iterable, Sequence
from enum import StrEnum
from typing import Literal, NamedTuple

from walkergen.core.errors import PrintabilityError

Level = Literal["error", "warning", "advice"]
LEVELS: tuple[Level, ...] = ("error", "warning", "advice")

ROUNDING_MM = 1e-6
"""Largest error, mm, that sums of floats and rounding to micrometres may leave."""


SINGULAR = {"bodies": "body", "changes": "change", "layers": "layer", "lines": "line"}
"""Units that are nouns, for a single one."""


class About(StrEnum):
    """Subject of a finding."""

    LEGS = "legs"
    BODY = "body"
    POCKETS = "pockets"
    MARKS = "marks"
    CAPS = "caps"
    WALKER = "walker"
    """The whole part, also one that is no walker."""
    PLATE = "plate"
    PRINTER = "printer"


class Setting(NamedTuple):
    """A value of a key of the walker or, after "printer.", of the printer."""

    key: str
    value: float


class Finding(NamedTuple):
    """A deviation of the print from the drawing: the problem `what`, its size `seen` with a limit, the remedy `change`.

    `where` is its place: the name of a part, plate or printer.
    """

    level: Level
    where: str
    what: str
    seen: float
    limit: float
    unit: str
    """Unit of `seen` and `limit`."""
    change: str
    part: About
    setting: Setting | None = None
    """Setting that applies the remedy, if one number does."""

    @property
    def text(self) -> str:
        """Problem, size and remedy in one line, without its level and place."""
        return f"{self.seen_text}: {self.change}"

    @property
    def seen_text(self) -> str:
        """Problem, the size that was found, and its limit."""
        seen, limit = (
            f"{value:.4g} {SINGULAR.get(self.unit, self.unit) if value == 1.0 else self.unit}".rstrip()
            for value in (self.seen, self.limit)
        )
        return f"{self.what}: {seen}, limit {limit}"

    @property
    def line(self) -> str:
        """Place, problem, size and remedy in one line."""
        return f"{self.where}: {self.text}"


def make_finding(
    part: About,
    level: Level,
    what: str,
    seen: float,
    limit: float,
    unit: str,
    change: str,
    setting: Setting | None = None,
) -> Finding:
    """Return a finding without a place: problem `what`, its size `seen` and the limit in `unit`, remedy `change`."""
    return Finding(level, "", what, float(seen), float(limit), unit, change, part, setting)


def with_place(where: str, findings: Iterable[Finding]) -> list[Finding]:
    """Return findings with their place, the name of a part, plate or printer, set to `where`."""
    return [finding._replace(where=where) for finding in findings]


def combine_printers(named: Sequence[tuple[str, Sequence[Finding]]]) -> list[Finding]:
    """Return one list of the findings of printers, given by name. With several printers, places begin with the name."""
    return [
        finding._replace(where=f"{printer}: {finding.where}") if len(named) > 1 else finding
        for printer, findings in named
        for finding in findings
    ]


def group_findings(findings: Sequence[Finding], levels: Collection[Level] = LEVELS) -> list[Finding]:
    """Return findings, errors first, in which the worst replaces all with the same limit and remedy.

    The worst is the farthest from the limit. Its place gets the number of the other places. Only `levels` are listed.
    """
    groups: dict[Finding, list[Finding]] = {}
    for finding in findings:
        groups.setdefault(finding._replace(where="", what="", seen=0.0), []).append(finding)
    merged = []
    for group in groups.values():
        worst = max(group, key=lambda finding: abs(finding.seen - finding.limit))
        others = len({finding.where for finding in group} - {worst.where})
        merged.append(worst._replace(where=worst.where + (f" and {others} more" if others else "")))
    chosen = [finding for finding in merged if finding.level in levels]
    return sorted(chosen, key=lambda finding: LEVELS.index(finding.level))


def warning_lines(findings: Sequence[Finding]) -> list[str]:
    """Return a line for each of the findings that is a warning, similar ones merged."""
    return [finding.line for finding in group_findings(findings, {"warning"})]


def check_printable(findings: Sequence[Finding], strict: bool) -> None:
    """Raise PrintabilityError, with a line for each finding, if there are errors or, if `strict`, warnings."""
    if fatal := group_findings(findings, {"error", "warning"} if strict else {"error"}):
        raise PrintabilityError("\n".join(finding.line for finding in fatal))
