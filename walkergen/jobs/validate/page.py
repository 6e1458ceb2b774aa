"""Page of the claims: each number with its error bar, source, z-score and verdict."""

from collections.abc import Mapping, Sequence

from walkergen import __version__
from walkergen.jobs.validate.claim import VERDICTS, Claim, Word
from walkergen.published import TIMES

TITLE = "What walkergen predicts, against what is known outside it"

TITLES: dict[Word, str] = {
    "disagree": "Where we disagree, and why", "undecided": "Undecided", "fitted": "Fitted",
    "agree": "Remarks", "not run": "Not run",
}  # fmt: skip
"""Titles of the paragraphs of reasons, by verdict."""

SIGNS = {"<": "below ", ">": "above ", "": ""}


def counted(claims: Sequence[Claim]) -> str:
    """Number of claims by verdict."""
    return ", ".join(f"{sum(one.verdict == word for one in claims)} {word}" for word in VERDICTS)


def as_markdown(claims: Sequence[Claim], command: str, titles: Mapping[str, str]) -> str:
    """Page of the claims under the titles of their groups."""
    sources = list(dict.fromkeys(one.source for one in claims))
    parts = [_head(claims, command)]
    for group, title in titles.items():
        own = [one for one in claims if one.group == group]
        if own:
            parts.append(f"## {title}\n\n{_table(own, sources)}")
            parts += _reasons(own)
    listed = [f"{number}. {source}" for number, source in enumerate(sources, 1)]
    parts.append("## Sources\n\n" + "\n".join(listed))
    return "\n\n".join(parts) + "\n"


def _head(claims: Sequence[Claim], command: str) -> str:
    meanings = [f"- **{word}**: {meaning}" for word, meaning in VERDICTS.items()]
    return "\n".join(
        [
            f"# {TITLE}",
            "",
            f"Made by `{command}` (walkergen {__version__}): {len(claims)} claims, of which "
            f"{counted(claims)}.",
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
    for one in claims:
        cells = (
            one.quantity, _number(one, one.ours, one.ours_se), _theirs(one),
            "" if one.gap is None else f"{one.gap:.2g}",
            "" if one.gap is None else f"{one.allowed:.2g}",
            "" if one.z is None else f"{one.z:.1f}", f"**{one.verdict}**",
            f"{sources.index(one.source) + 1}",
        )  # fmt: skip
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _theirs(one: Claim) -> str:
    return "" if one.theirs is None else SIGNS[one.bound] + _number(one, one.theirs, one.theirs_se)


def _number(one: Claim, value: float | None, error: float | None) -> str:
    if value is None:
        return ""
    unit = f" {one.unit}" if one.unit else ""
    if error is None or not error:
        return f"{value:.6g}{unit}"
    digits = min(max(-_exponent(error) + 1, 0), 9)
    return f"{value:.{digits}f} ± {error:.{digits}f}{unit}"


def _exponent(value: float) -> int:
    """Power of ten of the leading digit."""
    return int(f"{value:e}".partition("e")[2])


def _reasons(claims: Sequence[Claim]) -> list[str]:
    """Paragraphs on what disagrees and why, on what an agreement hides, on what was not run."""
    found = []
    for word, title in TITLES.items():
        reasons = dict[str, list[str]]()
        for one in claims:
            told = one.missing if word == "not run" else one.why
            if one.verdict == word and (told or word == "disagree"):
                reasons.setdefault(told or "We know no reason.", []).append(one.quantity)
        lines = [f"- {'; '.join(names)}. {reason}" for reason, names in reasons.items()]
        if lines:
            found.append(f"### {title}\n\n" + "\n".join(lines))
    return found
