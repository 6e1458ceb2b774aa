"""Run of the claims, and the page, table and figure of their verdicts."""

from collections.abc import Sequence
from pathlib import Path

from walkergen.errors import InputError
from walkergen.files.output import Folder
from walkergen.files.progress import Progress
from walkergen.jobs.validate import (
    claims_bounce,
    claims_closed,
    claims_paper,
    claims_programs,
    claims_rivals,
)
from walkergen.jobs.validate.claim import Claim, Effort, Test

GROUPS: dict[str, tuple[Test, ...]] = {
    room.GROUP: room.TESTS
    for room in (claims_paper, claims_closed, claims_bounce, claims_rivals, claims_programs)
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
                f"--only {only[:60]!r}: {name[:30]!r} is no group of claims; choose from "
                f"{', '.join(GROUPS)}"
            )
    return [group for group in GROUPS if group in names]


def run(groups: Sequence[str], effort: Effort, progress: Progress) -> list[Claim]:
    """Put the claims of some groups to the test, in order."""
    tests = [test for group in groups for test in GROUPS[group]]
    found = list[Claim]()
    for done, test in enumerate(tests):
        progress(test.__name__.replace("_", " "), done, len(tests))
        found += test(effort)
    progress("done", len(tests), len(tests))
    return found


def write(claims: Sequence[Claim], command: str, folder: Path) -> list[Path]:
    """Write validation.md, .csv and .png into a folder; returns their paths.

    `command`: words that made them, for the page's head.
    """
    from walkergen.jobs.validate import figures, page

    made = {
        "validation.png": figures.deviations(claims, TITLES),
        "validation.csv": page.as_csv(claims).encode(),
        "validation.md": page.as_markdown(claims, command, TITLES).encode(),
    }
    with Folder(folder, "") as target:
        for name, data in made.items():
            target.write(name, data)
    return [folder / name for name in made]
