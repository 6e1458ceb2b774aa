"""Report of the claims: a table, and a page with each number's error bar, source, z-score and verdict."""

import math
from collections.abc import Iterator, Sequence
from itertools import takewhile
from pathlib import Path
from typing import Any

from evidence.validate.claim import TITLE, TITLES, WORDS, Claim
from walkergen import __version__
from walkergen.core.numerics.quantity import Quantity, Verdict
from walkergen.files.report import Report, Table

PAPER = (
    "Koumakis et al. 2016: N. Koumakis, A. Gnoli, C. Maggi, A. Puglisi, R. Di Leonardo, Mechanism of self-propulsion "
    "in 3D-printed active granular particles, New J. Phys. 18, 113046 (2016)."
)

LETTERS = "abcdefghijklmnopqrstuvwxyz"
"""Marks of reasons, by their order in a group."""

SIGNS = {"<": "below ", ">": "above ", "": ""}

KEYS = (
    *("group", "quantity", "unit", "ours", "ours_se", "theirs", "theirs_se", "bound", "margin", "margin_reason"),
    *("z", "gap_over_allowed", "verdict", "source", "why", "missing"),
)

FILES = ("validation.png", "validation.csv", "validation.md")


def of(claims: Sequence[Claim], folder: Path) -> Report:
    """Report of the claims, for FILES in a folder."""
    table = Table("validation", [_row(claim) for claim in claims], KEYS)
    told = [claim for claim in claims if claim.verdict in (Verdict.DISAGREE, Verdict.MISSING)]
    lines = [f"{claim.word}: {claim.quantity}: {claim.missing or claim.why}" for claim in told]

    def draw() -> Any:
        from evidence.validate import figures

        return figures.deviations(claims)

    return Report(
        name="validation",
        title=TITLE,
        tables=[table],
        facts={"rows": [_finite(row) for row in table], "files": [str(folder / name) for name in FILES]},
        lines=[*lines, f"{len(claims)} claims: {counted(claims)}", f"in {folder}: {', '.join(FILES)}"],
        figures={"validation": draw},
    )


def _row(claim: Claim) -> tuple[Any, ...]:
    ours, theirs = claim.ours, claim.theirs
    numbers = ours.value, ours.se or None, theirs.value, theirs.se or None
    gaps = claim.z, claim.gap_over_allowed
    margin = claim.bound, claim.margin, claim.margin_reason
    return (
        claim.group,
        claim.quantity,
        ours.unit,
        *numbers,
        *margin,
        *gaps,
        claim.word,
        claim.source,
        claim.why,
        claim.missing,
    )


def _finite(row: dict[str, Any]) -> dict[str, Any]:
    """Row for JSON, which has no NaN and no infinity; the verdict tells of them."""
    return {
        name: None if isinstance(value, float) and not math.isfinite(value) else value for name, value in row.items()
    }


def counted(claims: Sequence[Claim]) -> str:
    """Format the number of claims for each word."""
    return ", ".join(f"{sum(claim.word == word for claim in claims)} {word}" for word in WORDS)


def page(claims: Sequence[Claim], command: str) -> str:
    """Page of the claims under the titles of their groups, in Markdown; `command`: what made it."""
    sources = list(dict.fromkeys(claim.source for claim in claims))
    parts = [_head(claims, command)]
    for group, title in TITLES.items():
        of_group = [claim for claim in claims if claim.group == group]
        if of_group:
            equal = [claim for claim in of_group if _is_equal(claim)]
            others = [claim for claim in of_group if claim not in equal]
            reasons = list(dict.fromkeys(filter(None, map(_reason, others))))
            listed = [f"- **{LETTERS[at]}**: {reason}" for at, reason in enumerate(reasons)]
            parts += [f"## {title}", _table(others, sources, reasons), "\n".join(listed), _agreements(equal, sources)]
    listed = [f"{number}. {source}" for number, source in enumerate(sources, 1)]
    return "\n\n".join([*filter(None, parts), f"## Sources\n\n{PAPER}", "\n".join(listed)]) + "\n"


def _is_equal(claim: Claim) -> bool:
    """Return whether two numbers without errors agree, so that there is nothing to explain beyond the value."""
    without_errors = not (claim.ours.se or claim.theirs.se or claim.bound)
    return without_errors and claim.verdict == Verdict.AGREE and bool(claim.theirs.value) and not claim.why


def _head(claims: Sequence[Claim], command: str) -> str:
    meanings = "\n".join(f"- **{word}**: {meaning}" for word, meaning in WORDS.items())
    disagree = [claim.group for claim in claims if claim.verdict == Verdict.DISAGREE]
    groups = [f"{disagree.count(group)} of *{title}*" for group, title in TITLES.items() if group in disagree]
    against = f" Disagreements: {', '.join(groups)}." if groups else ""
    return f"""# {TITLE}

{len(claims)} claims: {counted(claims)}.{against}
Closed forms, engines and programs test the arithmetic. Only the paper's walkers and measured blocks test the physics.
No walker of ours has been measured yet.

![Gap over margin, by group](validation.png)

Made by `{command}` (walkergen {__version__}), which writes every number as CSV too.
Errors are standard errors. The gap is ours less theirs, and z is the gap over the error of both. The margin is a
tolerance, or our reading of a statement in words. A letter refers to a reason or remark below the table. The verdict
uses the 95 % interval of the gap (Student's t):

{meanings}"""


def _table(claims: Sequence[Claim], sources: Sequence[str], reasons: Sequence[str]) -> str:
    """Table of claims; "" without any."""
    lines = [
        "| quantity | walkergen | outside | margin | z | verdict | source, reason |",
        "|---|--:|--:|--:|--:|---|--:|",
    ]
    for claim in claims:
        reason = _reason(claim)
        cells = (
            claim.quantity,
            _number(claim.ours),
            SIGNS[claim.bound] * (claim.theirs.value is not None) + _number(claim.theirs),
            "" if claim.gap is None else f"{claim.margin:.2g}",
            "" if claim.z is None else f"{claim.z:.1f}",
            f"**{claim.word}**",
            f"{sources.index(claim.source) + 1}" + (f" {LETTERS[reasons.index(reason)]}" if reason else ""),
        )
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) if claims else ""


def _agreements(claims: Sequence[Claim], sources: Sequence[str]) -> str:
    """List of equal numbers, a line a source; "" without any."""
    lines = []
    for source in dict.fromkeys(claim.source for claim in claims):
        of_source = [claim for claim in claims if claim.source == source]
        names = _without_repeats([claim.quantity for claim in of_source])
        values = "; ".join(f"{name}: {_number(claim.theirs)}" for name, claim in zip(names, of_source, strict=True))
        sizes = [abs(claim.theirs.value or 1.0) for claim in of_source]
        apart = max(abs(claim.gap or 0.0) / size for claim, size in zip(of_source, sizes, strict=True))
        allowed = max(claim.margin / size for claim, size in zip(of_source, sizes, strict=True))
        lines.append(f"- {values} ({sources.index(source) + 1}; {apart:.0g} of {allowed:.0g})")
    head = "**Agree**, without statistical error (source; largest relative difference, of the margin):\n\n"
    return head + "\n".join(lines) if lines else ""


def _without_repeats(names: Sequence[str]) -> Iterator[str]:
    """Names, each without the words with which the one before it begins too."""
    before = list[str]()
    for name in names:
        words = name.split()
        alike = list(takewhile(lambda pair: pair[0] == pair[1], zip(before, words, strict=False)))
        yield " ".join(words[len(alike) :])
        before = words


def _number(quantity: Quantity) -> str:
    value, error = quantity.value, quantity.se
    unit = f" {quantity.unit}" if quantity.unit else ""
    if value is None:
        return ""
    if not error:
        return f"{value:.6g}{unit}"
    exponent = int(f"{error:e}".partition("e")[2])  # of the leading digit
    digits = min(max(1 - exponent, 0), 9)
    return f"{value:.{digits}f} ± {error:.{digits}f}{unit}"


def _reason(claim: Claim) -> str:
    """Return the explanation below a claim's table; empty if it needs none."""
    none = "We know no reason." if claim.verdict == Verdict.DISAGREE else ""
    return claim.missing or claim.why or none
