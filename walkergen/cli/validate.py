"""The command `validate`."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from walkergen.cli import options as opt
from walkergen.cli import show

if TYPE_CHECKING:
    from walkergen.jobs.validate.claim import Claim


def validate(
    only: Annotated[
        str | None,
        typer.Option(
            "--only",
            metavar="GROUPS",
            help="Comma-separated groups: paper, closed, bouncing, rivals, programs.",
        ),
    ] = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="Simulate less: wider error bars.")
    ] = False,
    out: opt.Out = None,
    json: opt.AsJson = False,
    quiet: opt.Quiet = False,
) -> None:
    """Put every prediction beside what is known outside: number, error, source, verdict."""
    from walkergen.jobs.validate import make
    from walkergen.jobs.validate.claim import Effort

    groups = make.choose(only)
    folder = out or Path("out") / "validation"
    asked = (f" --only {','.join(groups)}" if only else "") + (" --quick" if quick else "")
    with show.progress("validate", wanted=not quiet) as progress:
        claims = make.run(groups, Effort(quick), progress)
    paths = make.write(claims, f"walkergen validate{asked}", folder)
    if json:
        _claims_as_json(claims, paths)
    elif not quiet:
        _show_claims(claims, paths)


def _claims_as_json(claims: "Sequence[Claim]", paths: Sequence[Path]) -> None:
    """Print the claims with z-scores and verdicts as JSON."""
    rows = []
    for one in claims:
        row = one._asdict() | {"z": one.z, "allowed": one.allowed, "verdict": one.verdict}
        del row["fact"]  # quantity, number, margin and source stand beside it
        # JSON has no NaN and no infinity; the verdict tells of them.
        rows.append({name: _finite(value) for name, value in row.items()})
    show.as_json({"rows": rows, "files": [str(path) for path in paths]})


def _finite(value: object) -> object:
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _show_claims(claims: "Sequence[Claim]", paths: Sequence[Path]) -> None:
    """Print what disagrees or was not run, and the counts."""
    from walkergen.jobs.validate import page

    for one in claims:
        if one.verdict in ("disagree", "not run"):
            print(f"{one.verdict}: {one.quantity}: {one.missing or one.why}")
    number = page.counts(claims)
    print(f"{len(claims)} claims: " + ", ".join(f"{number[word]} {word}" for word in number))
    print("\n".join(str(path) for path in paths))
