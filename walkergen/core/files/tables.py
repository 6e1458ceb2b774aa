"""Tables as CSV, with every digit, and without cells that a spreadsheet would run."""

import csv
import io
import re
from collections.abc import Iterable, Sequence
from typing import Any

from walkergen.core.errors import spell_for_python

FORMULA_START = re.compile(r"'*[=+\-@\t\r]")
"""Beginning of a text that a spreadsheet would run as a formula, quoted any number of times."""


def csv_text(header: Sequence[str], lines: Iterable[Sequence[Any]]) -> str:
    """Return the text of a CSV file, a header and lines of cells: every digit of a number, an empty cell for None.

    Text that a spreadsheet would run gets an apostrophe before it. `unquote_formula` removes it. Options
    marked as ‹option› are written as arguments of Python functions.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(map(quote_formula, header))
    writer.writerows(map(quote_formula, line) for line in lines)
    return spell_for_python(text.getvalue())


def quote_formula(cell: Any) -> Any:
    """Return a cell of a CSV file, with an apostrophe before text that a spreadsheet would run as a formula."""
    formula = isinstance(cell, str) and FORMULA_START.match(cell) and not _is_number(cell)
    return f"'{cell}" if formula else cell


def unquote_formula(cell: str) -> str:
    """Return the text of a cell without the apostrophe of `quote_formula`."""
    return cell[1:] if cell.startswith("'") and FORMULA_START.match(cell) else cell


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
