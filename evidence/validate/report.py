"""Report of the claims: a table, and a page with each number's error bar, source, z-score and verdict."""

import csv
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from evidence.validate.claim import TITLE, TITLES, VERDICT_MEANINGS, Claim
from walkergen import __version__
from walkergen.core.numerics.quantity import Verdict
from walkergen.files.report import Report, Table

PAPER = (
    "Koumakis et al. 2016: N. Koumakis, A. Gnoli, C. Maggi, A. Puglisi, R. Di Leonardo, Mechanism of self-propulsion "
    "in 3D-printed active granular particles, New J. Phys. 18, 113046 (2016)."
)

LETTERS = "abcdefghijklmnopqrstuvwxyz"
"""Marks of reasons, by their order in a group."""

SIGNS = {"<": "below ", ">": "above ", "": ""}

FILES = "validation.png", "validation.csv", "validation.md"


class Row(NamedTuple):
    """A claim as a row of validation.csv; the field names are its columns."""

    group: str
    quantity: str
    unit: str
    ours: float | None
    ours_se: float | None
    theirs: float | None
    theirs_se: float | None
    bound: str
    margin: float
    margin_reason: str
    z: float | None
    gap_over_allowed: float | None
    verdict: str
    source: str
    why: str
    missing: str

    @property
    def is_equal(self) -> bool:
        """Whether two numbers without errors agree, so that there is nothing to explain beyond the value."""
        remark = self.ours_se or self.theirs_se or self.bound or self.why
        return not remark and self.verdict == Verdict.AGREE.value and bool(self.theirs)

    @property
    def reason(self) -> str:
        """Explanation below the table; empty if none is needed."""
        return self.missing or self.why or "We know no reason." * (self.verdict == Verdict.DISAGREE.value)


def read_rows(path: Path) -> list[Row]:
    """Return the rows of a stored validation.csv."""
    with path.open(encoding="utf-8", newline="") as stream:
        lines = list(csv.reader(stream))[1:]
    is_text = [kind is str for kind in Row.__annotations__.values()]
    return [
        Row._make(cell if text else float(cell) if cell else None for cell, text in zip(line, is_text, strict=True))
        for line in lines
    ]


def make_report(claims: Sequence[Claim], folder: Path) -> Report:
    """Report of the claims, for FILES in a folder."""
    rows = list(map(to_row, claims))
    table = Table("validation", rows, Row._fields)
    shown = [row for row in rows if row.verdict in (Verdict.DISAGREE.value, Verdict.MISSING.value)]
    lines = [f"{row.verdict}: {row.quantity}: {row.missing or row.why}" for row in shown]

    def draw() -> Any:
        from evidence.validate import figures

        return figures.draw_claims(claims)

    return Report(
        name="validation",
        title=TITLE,
        tables=[table],
        facts={"rows": [_drop_infinite(row) for row in table], "files": [str(folder / name) for name in FILES]},
        lines=[*lines, f"{len(rows)} claims: {count_words(rows)}", f"in {folder}: {', '.join(FILES)}"],
        figures={"validation": draw},
    )


def to_row(claim: Claim) -> Row:
    """Return the row of a claim."""
    ours, theirs = claim.ours, claim.theirs
    numbers = ours.value, ours.se or None, theirs.value, theirs.se or None
    gaps = claim.bound, claim.margin, claim.margin_reason, claim.z, claim.gap_over_allowed
    words = claim.word, claim.source, claim.why, claim.missing
    return Row._make((claim.group, claim.quantity, ours.unit, *numbers, *gaps, *words))


def _drop_infinite(row: dict[str, Any]) -> dict[str, Any]:
    """Row for JSON, which has no NaN and no infinity; the verdict tells of them."""
    return {key: None if isinstance(x, float) and not math.isfinite(x) else x for key, x in row.items()}


def count_words(rows: Sequence[Row]) -> str:
    """Format the number of claims for each word."""
    return ", ".join(f"{sum(row.verdict == word for row in rows)} {word}" for word in VERDICT_MEANINGS)


def to_markdown(rows: Sequence[Row], command: str, picture: str = FILES[0]) -> str:
    """Write the page of the claims in Markdown. `command` made them; `picture`: address of their figure."""
    sources = list(dict.fromkeys(row.source for row in rows))
    parts = [_page_head(rows, command, picture)]
    for group, title in TITLES.items():
        of_group = [row for row in rows if row.group == group]
        if of_group:
            equal = [row for row in of_group if row.is_equal]
            others = [row for row in of_group if not row.is_equal]
            reasons = list(dict.fromkeys(row.reason for row in others if row.reason))
            listed = [f"- **{LETTERS[at]}**: {reason}" for at, reason in enumerate(reasons)]
            parts += [
                f"## {title}",
                _claim_table(others, sources, reasons),
                "\n".join(listed),
                _agreement_table(equal, sources),
            ]
    listed = [f"{number}. {source}" for number, source in enumerate(sources, 1)]
    return "\n\n".join([*filter(None, parts), f"## Sources\n\n{PAPER}", "\n".join(listed)]) + "\n"


def _page_head(rows: Sequence[Row], command: str, picture: str) -> str:
    meanings = "\n".join(f"- **{word}**: {meaning}" for word, meaning in VERDICT_MEANINGS.items())
    disagree = [row.group for row in rows if row.verdict == Verdict.DISAGREE.value]
    groups = [f"{disagree.count(group)} of *{title}*" for group, title in TITLES.items() if group in disagree]
    against = f" Disagreements: {', '.join(groups)}." if groups else ""
    return f"""# {TITLE}

{len(rows)} claims: {count_words(rows)}.{against}
Closed forms, engines and programs test the arithmetic. Only the paper's walkers and measured blocks test the physics.
No walker of ours has been measured yet.

![Gap over margin, by group]({picture})

Made by `{command}` (walkergen {__version__}), which writes every number as CSV too.
Errors are standard errors. The gap is ours less theirs, and z is the gap over the error of both. The margin is a
tolerance, or our reading of a statement in words. A letter refers to a reason or remark below the table. The verdict
uses the 95 % interval of the gap (Student's t):

{meanings}"""


def _claim_table(rows: Sequence[Row], sources: Sequence[str], reasons: Sequence[str]) -> str:
    """Table of claims; "" without any."""
    lines = [
        "| quantity | walkergen | outside | margin | z | verdict | source, reason |",
        "|---|--:|--:|--:|--:|---|--:|",
    ]
    for row in rows:
        cells = (
            row.quantity,
            _number(row.ours, row.ours_se, row.unit),
            SIGNS[row.bound] * (row.theirs is not None) + _number(row.theirs, row.theirs_se, row.unit),
            "" if row.ours is None else f"{row.margin:.2g}",
            "" if row.z is None else f"{row.z:.1f}",
            f"**{row.verdict}**",
            f"{sources.index(row.source) + 1}" + (f" {LETTERS[reasons.index(row.reason)]}" if row.reason else ""),
        )
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) if rows else ""


def _agreement_table(rows: Sequence[Row], sources: Sequence[str]) -> str:
    """Table of equal numbers; "" without any."""
    lines = [
        "**Agree**, without statistical error:\n",
        "| quantity | number | relative difference | margin | source |",
        "|---|--:|--:|--:|--:|",
    ]
    for row in rows:
        size = abs(row.theirs or 1.0)
        apart, margin = abs((row.ours or 0.0) - (row.theirs or 0.0)) / size, row.margin / size
        number = _number(row.theirs, None, row.unit)
        lines.append(f"| {row.quantity} | {number} | {apart:.0g} | {margin:.0g} | {sources.index(row.source) + 1} |")
    return "\n".join(lines) if rows else ""


def _number(value: float | None, error: float | None, unit: str) -> str:
    end = f" {unit}" if unit else ""
    if value is None:
        return ""
    if not error:
        return f"{value:.6g}{end}"
    exponent = int(f"{error:e}".partition("e")[2])  # of the leading digit
    digits = min(max(1 - exponent, 0), 9)
    return f"{value:.{digits}f} ± {error:.{digits}f}{end}"
