"""The command `selftest`."""

import math
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

import typer

from walkergen.cli import options as opt
from walkergen.cli import show

if TYPE_CHECKING:
    from walkergen.jobs.selftest.make import Result


def selftest(
    only: Annotated[
        str | None,
        typer.Option("--only", metavar="NAME-OR-SECTION", help="Case to run, or section: 6.7."),
    ] = None,
    json: opt.AsJson = False,
    quiet: opt.Quiet = False,
) -> None:
    """Run the hard cases, each with an exact outcome or an invariant; exit code 1 if any fails."""
    from walkergen.jobs.selftest import make as hard

    jobs = hard.choose(only)
    with show.progress("selftest", wanted=not quiet) as progress:
        results, whole = hard.run(jobs, progress)
    if json:
        _hard_cases_as_json(results, whole)
    elif not quiet:
        _show_hard_cases(results)
    if not whole:
        print(f"interrupted after {len(results)} of {len(jobs)}", file=sys.stderr)
        raise typer.Exit(130)
    if not all(result.holds for result in results):
        raise typer.Exit(1)


def _hard_cases_as_json(results: "Sequence[Result]", whole: bool) -> None:
    """Print every check of every hard case as JSON; values that are not finite become null."""
    rows = []
    for result in results:
        checks = [
            check._asdict()
            | {"value": _number(check.value), "limit": _number(check.limit), "holds": check.holds}
            for check in result.checks
        ]
        rows.append(result._asdict() | {"checks": checks, "holds": result.holds})
    held = sum(result.holds for result in results)
    failed = len(results) - held
    show.as_json({"rows": rows, "held": held, "failed": failed, "partial": not whole})


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _show_hard_cases(results: "Sequence[Result]") -> None:
    """Print the tightest check of each hard case, all checks that fail, and the counts."""
    from rich import box
    from rich.console import Console
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    for heading in ("section", "case", "on", "checks", "tightest", "value", "limit", "margin"):
        right = heading in ("checks", "value", "limit", "margin")
        table.add_column(heading, justify="right" if right else "left")
    for result in results:
        tightest = sorted(result.checks, key=lambda check: _room(check.value, check.limit))[:1]
        name = (result.section, result.case, result.model)
        shown = [check for check in result.checks if not check.holds] or tightest
        for check in shown if not result.error else []:
            room = _room(check.value, check.limit)
            margin = (
                "FAILED" if not check.holds else "exact" if room == math.inf else f"x {room:.2g}"
            )
            values = (check.what, f"{check.value:.2g}", f"{check.limit:.2g}", margin)
            table.add_row(*name, str(len(result.checks)), *values)
        if result.error:
            table.add_row(*name, str(len(result.checks)), result.error, "", "", "FAILED")
    wide = None if sys.stdout.isatty() else 160  # a log need not fit 80 columns
    Console(highlight=False, width=wide).print(table, markup=False)
    checks = sum(len(result.checks) for result in results)
    failed = sum(not result.holds for result in results)
    cases = len({result.case for result in results})
    print("sections: docs/physics.md")
    print(
        f"{cases} hard cases in {len(results)} runs of a model, {checks} checks: "
        f"{len(results) - failed} runs hold, {failed} fail"
    )


def _room(value: float, limit: float) -> float:
    """Limit over value: the factor by which the value could grow; 0 when it is not finite."""
    if not math.isfinite(value):
        return 0.0
    return limit / value if value > 0.0 else math.inf
