"""Page of the claims: each number with its error bar, source, z-score and verdict."""

from collections.abc import Mapping, Sequence

from evidence.validate.claim import VERDICTS, Claim, Word
from walkergen import __version__
from walkergen.jobs.trust.published import TIMES

TITLE = "What walkergen predicts, against what is known outside it"

TITLES: dict[Word, str] = {
    "disagree": "Where we disagree, and why",
    "undecided": "Undecided",
    "fitted": "Fitted",
    "agree": "Remarks",
    "not run": "Not run",
}
"""Titles of the paragraphs of reasons, by verdict."""

SIGNS = {"<": "below ", ">": "above ", "": ""}


def counted(claims: Sequence[Claim]) -> str:
    """Number of claims by verdict."""
    return ", ".join(f"{sum(claim.verdict == word for claim in claims)} {word}" for word in VERDICTS)


def as_markdown(claims: Sequence[Claim], command: str, titles: Mapping[str, str]) -> str:
    """Page of the claims under the titles of their groups."""
    sources = list(dict.fromkeys(claim.source for claim in claims))
    parts = [_head(claims, command)]
    for group, title in titles.items():
        of_group = [claim for claim in claims if claim.group == group]
        if of_group:
            parts.append(f"## {title}\n\n{_table(of_group, sources)}")
            parts += _reasons(of_group)
    listed = [f"{number}. {source}" for number, source in enumerate(sources, 1)]
    parts.append("## Sources\n\n" + "\n".join(listed))
    return "\n\n".join(parts) + "\n"


def _head(claims: Sequence[Claim], command: str) -> str:
    meanings = [f"- **{word}**: {meaning}" for word, meaning in VERDICTS.items()]
    return "\n".join(
        [
            f"# {TITLE}",
            "",
            f"Made by `{command}` (walkergen {__version__}): {len(claims)} claims, of which {counted(claims)}.",
            "",
            "![Gaps over what is allowed, by group](validation.png)",
            "",
            "Errors are standard errors. The gap is ours less theirs, none on the right side of a "
            "bound; z is the gap over the error of both. A gap is allowed up to the margin (a "
            f"tolerance, or our reading of a statement in words) and {TIMES:g} errors. So *agree* "
            "says that no difference shows: the column of what is allowed says how sharp that is; "
            f"with the paper it says that all of ours ± {TIMES:g} errors lies within the margin. "
            "Closed forms, engines and programs test the arithmetic; only the paper's walkers, and "
            "measured blocks, test the physics, and no walker of ours has been measured yet.",
            "",
            *meanings,
        ]
    )


def _table(claims: Sequence[Claim], sources: Sequence[str]) -> str:
    lines = [
        "| quantity | walkergen | outside | gap | allowed | z | verdict | source |",
        "|---|--:|--:|--:|--:|--:|---|--:|",
    ]
    for claim in claims:
        cells = (
            claim.quantity,
            _number(claim, claim.ours, claim.ours_se),
            _theirs(claim),
            "" if claim.gap is None else f"{claim.gap:.2g}",
            "" if claim.gap is None else f"{claim.allowed:.2g}",
            "" if claim.z is None else f"{claim.z:.1f}",
            f"**{claim.verdict}**",
            f"{sources.index(claim.source) + 1}",
        )
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _theirs(claim: Claim) -> str:
    return "" if claim.theirs is None else SIGNS[claim.bound] + _number(claim, claim.theirs, claim.theirs_se)


def _number(claim: Claim, value: float | None, error: float | None) -> str:
    if value is None:
        return ""
    unit = f" {claim.unit}" if claim.unit else ""
    if error is None or not error:
        return f"{value:.6g}{unit}"
    digits = min(max(-_exponent(error) + 1, 0), 9)
    return f"{value:.{digits}f} ± {error:.{digits}f}{unit}"


def _exponent(value: float) -> int:
    """Power of ten of the leading digit."""
    return int(f"{value:e}".partition("e")[2])


def _reasons(claims: Sequence[Claim]) -> list[str]:
    """Paragraphs on what disagrees and why, on what an agreement hides, on what was not run."""
    paragraphs = []
    for word, title in TITLES.items():
        reasons = dict[str, list[str]]()
        for claim in claims:
            reason = claim.missing if word == "not run" else claim.why
            if claim.verdict == word and (reason or word == "disagree"):
                reasons.setdefault(reason or "We know no reason.", []).append(claim.quantity)
        lines = [f"- {'; '.join(names)}. {reason}" for reason, names in reasons.items()]
        if lines:
            paragraphs.append(f"### {title}\n\n" + "\n".join(lines))
    return paragraphs
