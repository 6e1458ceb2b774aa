"""Run of the claims, and the page, table and figure of their verdicts."""

from collections.abc import Sequence
from pathlib import Path

from evidence.validate import claims_bounce, claims_closed, claims_paper, claims_programs, claims_rivals, report
from evidence.validate.claim import Claim, Effort, Test
from walkergen.core.errors import InputError
from walkergen.core.files.output import Folder
from walkergen.core.files.progress import Progress
from walkergen.files.report import Report

GROUPS: dict[str, tuple[Test, ...]] = {
    "paper": claims_paper.TESTS,
    "closed": claims_closed.TESTS,
    "bouncing": claims_bounce.TESTS,
    "rivals": claims_rivals.TESTS,
    "programs": claims_programs.TESTS,
}


def parse_groups(only: str | None) -> list[str]:
    """Select groups from a comma-separated list, in the page's order; all for None.

    Raises InputError for a name that is none.
    """
    if only is None:
        return list(GROUPS)
    names = {name.strip().lower() for name in only.split(",")}
    for name in sorted(names - GROUPS.keys()):
        raise InputError(f"--only {only[:60]!r}: {name[:30]!r} is not a group. Choose from {', '.join(GROUPS)}")
    return [group for group in GROUPS if group in names]


def run_claims(groups: Sequence[str], effort: Effort, progress: Progress) -> list[Claim]:
    """Put the claims of some groups to the test, in order."""
    tests = [(group, test) for group in groups for test in GROUPS[group]]
    claims = list[Claim]()
    for done, (group, test) in enumerate(tests):
        progress(test.__name__.replace("_", " "), done, len(tests))
        claims += [claim._replace(group=group) for claim in test(effort)]
    progress("done", len(tests), len(tests))
    return claims


def validate(groups: Sequence[str], effort: Effort, command: str, folder: Path, progress: Progress) -> Report:
    """Put the claims of some groups to the test; write validation.png, .csv, .md into a folder.

    `command`: words that made them, for the page's head.
    """
    from walkergen.files import figures

    claims = run_claims(groups, effort, progress)
    validation = report.make_report(claims, folder)
    with Folder(folder, "") as target:
        target.write("validation.png", figures.png(validation.plot()))
        target.write("validation.csv", validation.table.csv().encode())
        target.write("validation.md", report.to_markdown(list(map(report.to_row, claims)), command).encode())
    return validation
