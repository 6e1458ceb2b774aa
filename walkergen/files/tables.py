"""Tables as text: CSV with every digit, Markdown."""

import csv
import io
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.table import Table


def csv_text(header: Sequence[str], lines: Iterable[Sequence[Any]]) -> str:
    """Comma-separated values under a header: every digit of a number, nothing for None."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(lines)
    return text.getvalue()


def as_markdown(table: "Table") -> str:
    """A table made with box.MARKDOWN as text."""
    from rich.console import Console

    text = io.StringIO()
    Console(file=text, width=300, color_system=None).print(table)
    return "\n".join(line.rstrip() for line in text.getvalue().strip().splitlines())
