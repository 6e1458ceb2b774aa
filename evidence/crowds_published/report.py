"""Report of our crowds beside published ones: the table, its numbers, the page and the sources."""

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from evidence.crowds_published.claims import Compared
from evidence.crowds_published.published import FINDINGS, Source
from walkergen.files import report, words
from walkergen.files.report import Column, Report, Table
from walkergen.files.tables import as_markdown
from walkergen.jobs.trust.published import TIMES

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TITLE = "Crowds beside published ones"

LEGEND = (
    f"± one standard error over independent runs; a sign is one beyond {TIMES:g} of them; what the "
    "sources state are numbers of other grains, so that signs are compared, not sizes"
)


class Row(NamedTuple):
    """A statement and our numbers; the field names are the keys of JSON and of reproduce.csv."""

    finding: str
    source: str
    address: str
    read: str
    quote: str
    stated: str
    sign: str
    quantity: str
    setting: str
    ours: str
    verdict: str
    why: str


class Point(NamedTuple):
    """One number behind a statement; the field names are the columns of crowds.csv."""

    finding: str
    quantity: str
    setting: str
    at: float
    ours: float
    ours_se: float


def row(compared: Compared) -> Row:
    """Statement, source, numbers and verdict as words."""
    finding, source = compared.finding, compared.finding.source
    ours = "; ".join(f"{words.number(at)}: {words.with_error(*value)}" for at, value in compared.points)
    return Row(
        finding.key,
        source.citation,
        source.address,
        source.read,
        finding.quote,
        finding.stated,
        finding.sign,
        compared.quantity,
        compared.setting,
        ours,
        compared.word,
        compared.why,
    )


def table(compared: Sequence[Compared]) -> Table:
    """Table to read, a row a statement; its CSV holds every word."""
    columns = (
        report.text("published", "finding"),
        Column("stated", lambda row: f"{row.stated}: {row.sign}" if row.stated else row.sign),
        report.text("ours", "quantity"),
        Column("along", lambda row: row.setting, wide=True),
        Column("numbers", lambda row: row.ours),
        report.text("sign", "verdict"),
        Column("why", lambda row: row.why, wide=True),
    )
    rows = [row(one) for one in compared]
    return Table("reproduce", rows, Row._fields, columns, TITLE, (LEGEND,))


def points(compared: Sequence[Compared]) -> Table:
    """Every number of ours, a row each."""
    rows = [
        Point(one.finding.key, one.quantity, one.setting, at, *value) for one in compared for at, value in one.points
    ]
    return Table("crowds", rows, Point._fields)


def of(compared: Sequence[Compared], folder: Path, note: str) -> Report:
    """Report of what was compared, which lies in a folder; `note` says how it was simulated."""
    counted = {
        word: sum(one.word == word for one in compared) for word in ("agrees", "disagrees", "undecided", "not compared")
    }
    told = ", ".join(f"{count} {word}" for word, count in counted.items() if count)
    reasons = [
        f"{one.finding.key}, {one.quantity}: {one.word}, perhaps because {one.why}"
        for one in compared
        if one.word == "disagrees"
    ]
    return Report(
        name="reproduce",
        title=TITLE,
        tables=[table(compared), points(compared)],
        facts={"rows": [row(one)._asdict() for one in compared]},
        lines=[told, *reasons, note],
        folder=folder,
        figures={"crowds": partial(draw, compared)},
    )


def draw(compared: Sequence[Compared]) -> "Figure":
    """Draw our numbers along what was varied."""
    from evidence.crowds_published import figure as crowd_figure

    return crowd_figure.draw(compared)


def to_markdown(compared: Sequence[Compared], note: str) -> str:
    """Format the page: how, the table, the statements with their sources."""
    sources = dict.fromkeys(finding.source for finding in FINDINGS.values())
    listed = "\n".join(_source(source) for source in sources)
    return f"""# {TITLE}

{note}

{as_markdown(table(compared).rich(markdown=True))}

{LEGEND}.

![Our numbers along what was varied](crowds.png)

## Sources

{listed}
"""


def _source(source: Source) -> str:
    quotes = "; ".join(f"{finding.key}: “{finding.quote}”" for finding in FINDINGS.values() if finding.source == source)
    return f"- {source.citation}. <{source.address}>. Read: {source.read}. {quotes}."
