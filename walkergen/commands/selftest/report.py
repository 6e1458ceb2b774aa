"""Report of the hard cases: a line for each subject, all that fails with its meaning, and the counts."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from walkergen.commands.selftest.case import GEOMETRY, IMPACT_LAW, SPACE, Check, Result
from walkergen.files.report import Column, Report, Table

KEYS = ("section", "case", "on", "source", "checks", "tightest", "value", "limit", "margin")

COLUMNS = (
    Column("section", lambda row: row[0]),
    Column("case", lambda row: row[1]),
    Column("closest check", lambda row: row[5]),
    Column("margin", lambda row: row[8], right=True, meaning="margin: limit of the closest check over its value"),
)

DISTRUSTED: Mapping[str, str] = {
    SPACE: "speeds and tracks from simulate, crowd, movie and explain, and those that predict simulates",
    IMPACT_LAW: "speeds from the theory: predict ‹model=›theory and the columns of eq. 15",
    GEOMETRY: "masses, inertias and printed files, and every speed that is computed from them",
}
"""Numbers that a failed case puts in doubt, by its subject."""

WHAT_TO_SEND = (
    "Please report it: send the output of `walkergen selftest --json` and of `walkergen --version --verbose`, and "
    "the name of the processor"
)


def make_report(results: Sequence[Result], whole: bool, all: bool = False) -> Report:
    """Make the report of the cases that ran. `whole`: whether these are all cases; `all`: whether each has a row."""
    failed = [result for result in results if not result.holds]
    held = len(results) - len(failed)
    rows = [_row(result) for result in results]
    return Report(
        name="selftest",
        title="Hard cases",
        tables=[Table("selftest", rows, KEYS, COLUMNS, read=None if all else [])],
        facts={
            "rows": [_facts(result) for result in results],
            "held": held,
            "failed": len(failed),
            "partial": not whole,
        },
        headline=_headline(results, len(failed)),
        lines=[*_subject_lines(results), *_failure_lines(failed), *([] if all or failed else ["‹all› lists them"])],
    )


def _headline(results: Sequence[Result], failed: int) -> str:
    """Return the answer: how many cases pass on this machine."""
    checks = sum(len(result.checks) for result in results)
    if failed:
        return f"{failed} of {_count(len(results), 'case')} FAILED on this machine ({_count(checks, 'check')})"
    verb = "passes" if len(results) == 1 else "pass"
    return f"{_count(len(results), 'case')} {verb} on this machine ({_count(checks, 'check')})"


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}{'' if number == 1 else 's'}"


def _subject_lines(results: Sequence[Result]) -> Iterator[str]:
    """Yield a line for each subject: how many of its cases pass, and the check closest to its limit."""
    for subject in dict.fromkeys(result.on for result in results):
        held = [result for result in results if result.on == subject and result.holds]
        if not held:
            continue
        case, check = min(((one, _closest(one)) for one in held), key=lambda pair: _margin(pair[1]))
        name = case.case.removeprefix(f"{subject}: ")
        verb = "passes" if len(held) == 1 else "pass"
        yield (
            f"{subject}: {_count(len(held), 'case')} {verb}, closest to its limit: {name} "
            f"({check.what}: {_format_margin(check)})"
        )


def _failure_lines(failed: Sequence[Result]) -> Iterator[str]:
    """Yield every failed check in full, then what not to trust and what to send."""
    for result in failed:
        yield f"FAILED {result.section}, {result.case} (source of the right value: {result.source})"
        for check in result.failing:
            yield f"  {check.what}: {check.value:.3g}, limit {check.limit:.3g} ({check.reason})"
        if result.error:
            yield f"  {result.error}"
    for subject in dict.fromkeys(result.on for result in failed):
        yield f"do not trust: {DISTRUSTED[subject]}"
    if failed:
        yield WHAT_TO_SEND


def _closest(result: Result) -> Check:
    """Return the check with the smallest margin."""
    return min(result.checks, key=_margin)


def _row(result: Result) -> tuple[str, ...]:
    """Return the row of a case: its check closest to the limit, or beyond it."""
    start = (result.section, result.case, result.on, result.source, str(len(result.checks)))
    if result.error:
        return (*start, result.error, "", "", "FAILED")
    check = _closest(result)
    margin = _format_margin(check) if check.holds else "FAILED"
    return (*start, check.what, f"{check.value:.2g}", f"{check.limit:.2g}", margin)


def _format_margin(check: Check) -> str:
    """Format how many times smaller than its limit a value is."""
    return "exact" if _margin(check) == math.inf else f"x {_margin(check):.2g}"


def _margin(check: Check) -> float:
    """Return limit over value: how many times larger the value could be; 0 if the value is not finite."""
    if not math.isfinite(check.value):
        return 0.0
    return check.limit / check.value if check.value > 0.0 else math.inf


def _facts(result: Result) -> dict[str, Any]:
    """Return a result for JSON. Values that are not finite become null."""
    checks = [
        check._asdict()
        | {"value": _finite_or_none(check.value), "limit": _finite_or_none(check.limit), "holds": check.holds}
        for check in result.checks
    ]
    return result._asdict() | {"checks": checks, "holds": result.holds}


def _finite_or_none(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
