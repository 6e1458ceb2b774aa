"""What `predict --uncertain` prints."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from walkergen.cli import show

if TYPE_CHECKING:
    from walkergen.theory.uncertain import Share


def shares(rows: "Sequence[Share]", title: str) -> None:
    """Print the shares of a variance by input: measure next what stands first."""
    from walkergen.files.report import Table
    from walkergen.theory.uncertain import SHARES, Share

    show.table(Table("shares", rows, Share._fields, SHARES, title).rich())
