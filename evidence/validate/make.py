"""Run of the claims, and the page, table and figure of their verdicts."""

from collections.abc import Sequence
from pathlib import Path

from evidence.validate import claims_bounce, claims_closed, claims_paper, claims_programs, claims_rivals, page, report
from evidence.validate.claim import Claim, Effort, Test
from walkergen.errors import InputError
from walkergen.files.output import Folder
from walkergen.files.progress import Progress
from walkergen.files.report import Report

GROUPS: dict[str, tuple[Test, ...]] = {
    room.GROUP: room.TESTS for room in (claims_paper, claims_closed, claims_bounce, claims_rivals, claims_programs)
}

TITLES = {
    "paper": "What the paper states",
    "closed": "Closed forms of mechanics",
    "bouncing": "Bouncing balls and rocking blocks, published",
    "rivals": "Physics engines",
    "programs": "Programs that do a part of ours",
}


def choose(only: str | None) -> list[str]:
    """Select groups from a comma-separated list, in the page's order; all for None.

    Raises InputError for a name that is none.
    """
    if only is None:
        return list(GROUPS)
    names = {name.strip().lower() for name in only.split(",")}
    for name in sorted(names):
        if name not in GROUPS:
            raise InputError(
                f"--only {only[:60]!r}: {name[:30]!r} is no group of claims; choose from {', '.join(GROUPS)}"
            )
    return [group for group in GROUPS if group in names]


def run(groups: Sequence[str], effort: Effort, progress: Progress) -> list[Claim]:
    """Put the claims of some groups to the test, in order."""
    tests = [test for group in groups for test in GROUPS[group]]
    claims = list[Claim]()
    for done, test in enumerate(tests):
        progress(test.__name__.replace("_", " "), done, len(tests))
        claims += test(effort)
    progress("done", len(tests), len(tests))
    return claims


def make(groups: Sequence[str], effort: Effort, command: str, folder: Path, progress: Progress) -> Report:
    """Put the claims of some groups to the test; write validation.png, .csv, .md into a folder.

    `command`: words that made them, for the page's head.
    """
    from walkergen.files import figures

    claims = run(groups, effort, progress)
    validation = report.of(claims, TITLES, folder)
    with Folder(folder, "") as target:
        target.write("validation.png", figures.png(validation.plot()))
        target.write("validation.csv", validation.table.csv().encode())
        target.write("validation.md", page.as_markdown(claims, command, TITLES).encode())
    return validation
