"""Report of the claims, each with its verdict; their page is longer (`page`)."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from evidence.validate import page
from evidence.validate.claim import Claim
from walkergen.files.report import Report, Table

KEYS = (
    "group",
    "quantity",
    "unit",
    "ours",
    "ours_se",
    "theirs",
    "theirs_se",
    "bound",
    "margin",
    "margin_reason",
    "z",
    "gap_over_allowed",
    "verdict",
    "source",
    "why",
    "missing",
)

FILES = ("validation.png", "validation.csv", "validation.md")


def of(claims: Sequence[Claim], titles: Mapping[str, str], folder: Path) -> Report:
    """Report of the claims under the titles of their groups, for FILES in a folder."""
    rows = [[getattr(claim, key) for key in KEYS] for claim in claims]
    lines = [
        f"{claim.verdict}: {claim.quantity}: {claim.missing or claim.why}"
        for claim in claims
        if claim.verdict in ("disagree", "not run")
    ]
    counted = f"{len(claims)} claims: {page.counted(claims)}"

    def draw() -> Any:
        from evidence.validate import figures

        return figures.deviations(claims, titles)

    return Report(
        name="validation",
        title=page.TITLE,
        tables=[Table("validation", rows, KEYS)],
        facts={"rows": [_facts(claim) for claim in claims], "files": [str(folder / name) for name in FILES]},
        lines=[*lines, counted, f"in {folder}: {', '.join(FILES)}"],
        figures={"validation": draw},
    )


def _facts(claim: Claim) -> dict[str, Any]:
    """Claim for JSON, which has no NaN and no infinity; the verdict tells of them."""
    row = claim._asdict() | {"z": claim.z, "allowed": claim.allowed, "verdict": claim.verdict}
    del row["fact"]  # quantity, number, margin and source stand beside it
    return {
        name: None if isinstance(value, float) and not math.isfinite(value) else value for name, value in row.items()
    }
