"""Report of the hard cases: the tightest check of each, all that fail, and the counts."""

import math
from collections.abc import Iterator, Sequence
from typing import Any

from walkergen.commands.selftest.case import Check, Result
from walkergen.files import report
from walkergen.files.report import Report, Table

COLUMN_KEYS = ("section", "case", "on", "source", "checks", "tightest", "value", "limit", "margin")
TEXT_COLUMNS = ("section", "case", "on", "source", "tightest")


def make_report(results: Sequence[Result], whole: bool) -> Report:
    """Make the report of the cases that ran. `whole`: whether these are all cases."""
    rows = [row for result in results for row in _rows(result)]
    held = sum(result.holds for result in results)
    failed = len(results) - held
    checks = sum(len(result.checks) for result in results)
    return Report(
        name="selftest",
        title="Hard cases",
        tables=[Table("selftest", rows, COLUMN_KEYS, report.key_columns(COLUMN_KEYS, TEXT_COLUMNS))],
        facts={"rows": [_facts(result) for result in results], "held": held, "failed": failed, "partial": not whole},
        lines=["sections: docs/physics.md", f"{len(results)} hard cases, {checks} checks: {held} hold, {failed} fail"],
    )


def _rows(result: Result) -> Iterator[tuple[str, ...]]:
    """Yield the rows of the failed checks, or of the tightest check if none failed."""
    start = (result.section, result.case, result.on, result.source, str(len(result.checks)))
    if result.error:
        yield (*start, result.error, "", "", "FAILED")
        return
    for check in result.failing or [min(result.checks, key=_margin_factor)]:
        margin = "exact" if _margin_factor(check) == math.inf else f"x {_margin_factor(check):.2g}"
        yield (*start, check.what, f"{check.value:.2g}", f"{check.limit:.2g}", margin if check.holds else "FAILED")


def _margin_factor(check: Check) -> float:
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
