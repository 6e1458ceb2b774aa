"""Tables of the three mechanisms: CSV, page and console."""

from collections.abc import Iterator, Sequence

from rich import box
from rich.table import Table

from walkergen.files.tables import csv_text
from walkergen.jobs.paper.mechanisms import Mechanism
from walkergen.jobs.paper.tables import number


def to_csv(found: Sequence[Mechanism]) -> str:
    """Format as CSV, a line a mechanism."""
    columns = ("mechanism", "design", "theory_mm_s", "theory_sd_mm_s", "theory", "model",
               "simulated_mm_s", "simulated_se_mm_s", "ratio", "ratio_se", "direction",
               "outcomes")  # fmt: skip
    rows = (
        [one.what, one.name, *one.theory, one.used, one.simulated.model,
         *(one.simulated.speed or ("", "")), *(one.ratio or ("", "")), one.direction,
         one.simulated.outcomes]
        for one in found
    )  # fmt: skip
    return csv_text(columns, rows)


def to_table(found: Sequence[Mechanism]) -> Table:
    """Table of a page, a line a mechanism."""
    table = Table(box=box.MARKDOWN)
    for heading in ("mechanism", "walker", "theory, mm/s", "simulated, mm/s",
                    "simulated / theory", "direction"):  # fmt: skip
        table.add_column(heading, no_wrap=True)
    for one in found:
        speed, ratio = one.simulated.speed, one.ratio
        table.add_row(
            one.what, one.name, f"{number(*one.theory)} ({one.used})",
            number(*speed) if speed else "none ended well",
            number(*ratio) if ratio else "", one.direction,
        )  # fmt: skip
    return table


def lines(found: Sequence[Mechanism]) -> Iterator[str]:
    """Lines for the console: theory and simulation of every mechanism."""
    for one in found:
        speed = one.simulated.speed
        told = f"{number(*speed)} mm/s" if speed else "no speed"
        yield (
            f"{one.what}: theory {one.theory.mean:.1f}, simulated {told}, direction {one.direction}"
        )
