"""Report of a bench test: its answers and the settings that follow from them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from walkergen.analysis.inverse import Inverse
from walkergen.files import report, words
from walkergen.files.report import Report, Table

Value = float | str | None


class Answer(NamedTuple):
    """Answer to a number that was measured: under which condition, in words and in numbers."""

    condition: str
    text: str
    inverse: Inverse


@dataclass(frozen=True, kw_only=True, repr=False)
class BenchReport(Report):
    """What a bench test shows and says."""

    settings: Mapping[str, float]
    """Keys of scene or design with the values that follow from the measured number."""


def rows(name: str, title: str, keys: Sequence[str], values: Sequence[Sequence[Value]]) -> Table:
    """Table of a bench test, every key of which people read."""
    texts = [key for key, first in zip(keys, values[0], strict=True) if isinstance(first, str)]
    return Table(name, values, keys, report.every(keys, texts), title)


def of(
    bench: str,
    title: str,
    caption: str,
    tables: Sequence[Table],
    answers: Sequence[Answer],
    notes: Sequence[str],
    settings: Mapping[str, float],
) -> BenchReport:
    """Report of a bench test: drop, slide or pluck; the caption names walker, feet and plate."""
    lines = [f"{answer.condition}: {answer.text}" if answer.condition else answer.text for answer in answers]
    if settings:
        keys = ", ".join(f"{key} = {words.number(value, 4)}" for key, value in settings.items())
        lines.append(f"set {keys}")
    facts = {
        "bench": bench,
        "caption": caption,
        "tables": {table.name: list(table) for table in tables},
        "answers": [_facts(answer) for answer in answers],
        "settings": dict(settings),
        "notes": list(notes),
    }
    return BenchReport(
        name=bench, title=title, caption=caption, tables=tables, facts=facts, lines=[*lines, *notes], settings=settings
    )


def _facts(answer: Answer) -> dict[str, Any]:
    return {
        "condition": answer.condition,
        "told": answer.text,
        "branches": [branch._asdict() for branch in answer.inverse.branches],
        "everywhere": answer.inverse.everywhere,
        "nearest": answer.inverse.nearest,
        "misses": answer.inverse.misses,
    }
