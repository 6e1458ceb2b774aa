"""Page of a family: one HTML file that shows its folder and needs nothing but itself.

Everything that comes from files is escaped by the template engine, and a content security policy
lets only the page's own scripts run and nothing be fetched.
"""

import base64
import io
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path, PurePosixPath
from typing import Any, NamedTuple

import markupsafe
from markdown_it import MarkdownIt

from walkergen import __version__
from walkergen.files import columns, viewer
from walkergen.jobs.make.family import chart, chart_data, references
from walkergen.jobs.make.family.chart_data import ChartData
from walkergen.points import members
from walkergen.points.members import Member
from walkergen.points.speed_table import MEANINGS
from walkergen.walker import solids

TABLE_PAGE, PREVIEW = "family.md", "preview.png"

ASSETS = Path(__file__).with_name("assets")

DOWNLOADS = {
    ".3mf": "model/3mf",
    ".csv": "text/csv",
    ".ini": "text/plain",
    ".json": "application/json",
    ".pdf": "application/pdf",
    ".stl": "model/stl",
}
"""Types of files that the page hands out, by their ends; it holds them whole."""

HEADINGS = {
    "tilt_deg": "tilt (deg)",
    "total_g": "mass (g)",
    "M_g": "M (g)",
    "J_g_mm2": "J (g mm²)",
    "m_g": "m (g)",
    "j_g_mm2": "j (g mm²)",
    "factor_back": "back (v/w)",
    "factor_front": "front (v/w)",
    "factor_mean": "mean (v/w)",
    "nominal_mm_s": "as designed (mm/s)",
    "speed_mm_s": "your print (mm/s)",
    "sim_speed_mm_s": "simulated (mm/s)",
    "speed_by": "speed by",
    "theory_mm_s": "eq. 15 (mm/s)",
    "speed_low_68_mm_s": "68 % (mm/s)",
    "speed_low_95_mm_s": "95 % (mm/s)",
    "sim_low_95_mm_s": "simulated, 95 % (mm/s)",
    "sim_model": "model",
    "sim_method": "method",
    "sim_outcomes": "ended",
    "mass_g": "weighed (g)",
    "mass_mesh_g": "mesh's mass (g)",
    "speed_mesh_mm_s": "with the mesh's (mm/s)",
}
"""Headings of columns of family.csv, as in its Markdown; other columns keep their names."""

ERRORS = {"sim_speed_mm_s": "sim_se_mm_s", "mass_g": "mass_se_g"}
"""Column of the error that stands behind ± in a column's cells, by that column."""

RANGES = {
    "speed_low_68_mm_s": "speed_high_68_mm_s",
    "speed_low_95_mm_s": "speed_high_95_mm_s",
    "sim_low_95_mm_s": "sim_high_95_mm_s",
}
"""Column of the upper bound that stands in the cells of the lower one, by that column."""

MARKED = {"speed_mm_s": "note", "theory_mm_s": "theory_note"}
"""Column of the note whose number stands behind a column's cells, by that column."""

LEFT_OUT = frozenset({"nominal_low_95_mm_s", "nominal_high_95_mm_s", "speed_sd_mm_s"})
"""Columns that family.csv alone has: other columns nearly say them."""

FIRST = (
    "tilt_deg",
    "legs",
    "speed_mm_s",
    "speed_low_68_mm_s",
    "speed_low_95_mm_s",
    "nominal_mm_s",
    "sim_speed_mm_s",
    "sim_low_95_mm_s",
    "verdict",
)
"""Columns that are seen without scrolling; the others follow as in the table."""


class Cell(NamedTuple):
    """Cell of a table: the text that is shown, and the value that the table is sorted by."""

    text: str
    value: str


class Table(NamedTuple):
    """Table of the family as the page shows it."""

    headings: list[str]
    rows: list[list[Cell]]
    common: dict[str, str]
    """Words that are equal in every row, and therefore said once, by heading."""
    legend: str
    """What short headings mean."""
    notes: list[str]
    """Notes on rows; note k is marked [k]."""


class Download(NamedTuple):
    """File that the page hands out."""

    path: str
    """Name of the file in its folder."""
    name: str
    """Name under which it is saved."""
    url: str
    size: str


def render(
    walkers: Sequence[Member],
    shown: ChartData | None,
    caption: str,
    files: Mapping[str, bytes],
    facts: Mapping[str, Any],
    run: Mapping[str, Any] | None = None,
) -> bytes:
    """Page as UTF-8 of walkers, what the chart shows beside them, and the files of their folder by name.

    `facts` are those of the manifest; a `run` is played (see `play`). Equal input gives equal bytes.
    """
    design = facts["design"]
    speeds = chart_data.speeds(shown) if shown is not None else []
    maps = {name: columns.records(io.StringIO(files[name].decode()), name) for name in _plates(files, ".csv")}
    values: dict[str, Any] = {
        "name": str(design.get("name", "walkers")),
        "description": str(design.get("description", "")),
        "version": __version__,
        "sizes": {name: len(data) for name, data in files.items()},
        "parts": [_part(member) for member in walkers],
        "table": table(walkers),
        "chart": chart.speeds(walkers, speeds),
        "frame": (chart.WIDTH, chart.HEIGHT, chart.LEFT, chart.RIGHT, chart.TOP, chart.BOTTOM),
        "caption": f"{caption}.",
        "preview": _picture(files, PREVIEW),
        "downloads": [_download(files, name) for name in files if _offered(name)],
        "stl": [_download(files, f"stl/{member.name}.stl") for member in walkers],
        "plates": {name: _picture(files, name) for name in _plates(files, ".png")},
        "maps": maps,
        "sheets": {name: markup(data) for name, data in files.items() if name.endswith(".md") and name != TABLE_PAGE},
        "settings": settings({key: value for key, value in facts.items() if key not in ("members", "legs_up")}),
        "references": references.cited(
            {member.row.law for member in walkers},
            {member.simulated.sim_method for member in walkers if member.simulated},
            list(files),
            played=run is not None,
        ),
        "run": run,
    }
    scripts = {"viewer": viewer.script(), "page": (ASSETS / "page.js").read_text(encoding="utf-8")}
    values |= {
        "style": markupsafe.Markup((ASSETS / "page.css").read_text(encoding="utf-8")),
        "scripts": {name: markupsafe.Markup(text) for name, text in scripts.items()},
        "script_hashes": [viewer.hashed(text) for text in scripts.values()],
    }
    return viewer.template_of(ASSETS / "page.html.jinja").render(values).encode()


def table(walkers: Sequence[Member]) -> Table:
    """Table of the family: numbers to four digits or to their errors; equal words said once."""
    rows = [row._asdict() for row in members.rows(walkers)]
    notes = list(dict.fromkeys(row[note] for note in MARKED.values() for row in rows if row[note]))
    apart = {*ERRORS.values(), *RANGES.values(), *MARKED.values(), *LEFT_OUT}
    if not any(row["falls"] for row in rows):
        apart.add("falls")
    listed = [column for column in rows[0] if column not in apart]
    ordered = [*(column for column in FIRST if column in listed), *(one for one in listed if one not in FIRST)]
    common = {
        column: first or ""
        for column in ordered
        if (first := rows[0][column]) in (None, "") or isinstance(first, str)
        if all(row[column] == first for row in rows)
        if column not in MARKED or not any(row[MARKED[column]] for row in rows)
    }
    shown = [column for column in ordered if column not in common]
    return Table(
        [HEADINGS.get(column, column) for column in shown],
        [[_cell(row, column, notes) for column in shown] for row in rows],
        {HEADINGS.get(column, column): text for column, text in common.items() if text},
        "; ".join(dict.fromkeys(MEANINGS[column] for column in shown if column in MEANINGS)),
        notes,
    )


def settings(data: Mapping[str, Any]) -> dict[str, dict[str, str]]:
    """Settings of a manifest, text by key, in a group for every table of its top level.

    The time that it took is left out: equal families have equal pages.
    """
    groups: dict[str, dict[str, str]] = {"run": {}}
    for key, value in data.items():
        if key == "time_taken_s":
            continue
        if isinstance(value, Mapping):
            groups[key] = dict(_flat(value))
        else:
            groups["run"][key] = _in_words(value)
    return groups


def markup(source: bytes) -> markupsafe.Markup:
    """HTML of a Markdown file, without its pictures and with its own HTML shown as text.

    Its headings stand below the page's, which are of two levels.
    """
    markdown = MarkdownIt("js-default").disable("image")
    tokens = markdown.parse(source.decode("utf-8", "replace"))
    for token in tokens:
        if token.type in ("heading_open", "heading_close"):
            token.tag = f"h{min(int(token.tag[1]) + 2, 6)}"
    return markupsafe.Markup(markdown.renderer.render(tokens, markdown.options, {}))


def _cell(row: Mapping[str, Any], column: str, notes: Sequence[str]) -> Cell:
    """Cell of a row, with the number of its note."""
    cell, note = _plain_cell(row, column), row[MARKED[column]] if column in MARKED else ""
    return cell._replace(text=f"{cell.text} [{notes.index(note) + 1}]") if note else cell


def _plain_cell(row: Mapping[str, Any], column: str) -> Cell:
    """Cell of a row, whose values are numbers, words or None."""
    value = row[column]
    text = "" if value is None else str(value)
    if not isinstance(value, (int, float)):
        return Cell(text or "-", text)
    if column in ERRORS and ERRORS[column] in row:
        bar = row[ERRORS[column]]
        return Cell(f"{_fixed(value)} ± {'?' if bar is None else _fixed(bar)}", text)
    if column in RANGES and (upper := row[RANGES[column]]) is not None:
        return Cell(f"{_fixed(value)} to {_fixed(upper)}", text)
    if column in ("nominal_mm_s", "speed_mm_s", "speed_mesh_mm_s", "theory_mm_s"):
        return Cell(_fixed(value), text)
    if column.startswith("factor_"):
        return Cell(_fixed(value, 3), text)
    exact = column == "tilt_deg" or isinstance(value, int)
    return Cell(_minus(f"{value:g}" if exact else f"{value:#.4g}".rstrip(".")), text)


def _fixed(value: float, digits: int = 1) -> str:
    """Number with so many decimals, without a minus on zero."""
    return _minus(f"{round(value, digits) + 0.0:.{digits}f}")


def _minus(text: str) -> str:
    return text.replace("-", "−")


def _part(member: Member) -> dict[str, Any]:
    """Data of a member for the viewer, which takes its mesh from the download of its STL file.

    The file has members as they print; the viewer, whose y is up, stands them on their feet.
    """
    legs_up = not solids.on_side(member.design)
    return {"name": member.name, "legs": member.row.legs, "tilt_deg": member.row.tilt_deg, "legs_up": legs_up}


def _offered(name: str) -> bool:
    """True for a file that is handed out beside the parts' meshes."""
    path = PurePosixPath(name)
    return path.suffix in DOWNLOADS and path.parts[0] != "stl"


def _download(files: Mapping[str, bytes], name: str) -> Download:
    """File of the folder, whole, as a link that needs nothing but the page."""
    kind, data = DOWNLOADS[PurePosixPath(name).suffix], files[name]
    url = f"data:{kind};base64,{base64.b64encode(data).decode()}"
    return Download(name, PurePosixPath(name).name, url, f"{len(data) / 1e3:,.1f} kB")


def _plates(files: Mapping[str, bytes], suffix: str) -> list[str]:
    return [name for name in files if name.startswith("plates/") and name.endswith(suffix)]


def _picture(files: Mapping[str, bytes], name: str) -> str | None:
    """Data URL of a PNG file; None when the folder has none."""
    data = files.get(name)
    return None if data is None else f"data:image/png;base64,{base64.b64encode(data).decode()}"


def _flat(data: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, str]]:
    for key, value in data.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", _in_words(value)


def _in_words(value: Any) -> str:
    if value is None:
        return "-"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return ", ".join(map(_in_words, value)) if isinstance(value, list) else str(value)
