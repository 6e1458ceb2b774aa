"""Sheet of markers in true size, to be printed on paper, cut out and glued: PDF, and PNG a page."""

from collections.abc import Sequence
from io import BytesIO

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure
from matplotlib.patches import Polygon, Rectangle

from walkergen.core.numerics import Array
from walkergen.core.walker.fittings import Cap
from walkergen.files import figures
from walkergen.readers.walkers import caps

PAGE_MM = (210.0, 297.0)
"""Width and height of a page: A4. On US Letter, only its lower edge is missing."""
MM_PER_INCH = 25.4
DPI = 600
"""Pixels per inch of the PNG: a cell of 1.2 mm has 28."""

EDGE_MM, TOP_MM, BOTTOM_MM = 15.0, 30.0, 32.0
"""Margins of a page at the sides, above (with text) and below (with the ruler), mm."""
COLUMN_GAP_MM, ROW_GAP_MM = 3.0, 6.0
"""Horizontal and vertical distance between tiles, mm. The vertical one has room for a number."""
RULE_MM = 100.0
"""Length of the printed ruler that shows whether a page was printed in true size, mm."""


def draw_pages(markers: Sequence[Cap]) -> list[Figure]:
    """Draw pages with a tile for each cap in true size, in a grid that fits the widest tile. Fronts point up."""
    width, height = PAGE_MM
    side = max(cap.side for cap in markers)
    across = max(1, int((width - 2 * EDGE_MM + COLUMN_GAP_MM) / (side + COLUMN_GAP_MM)))
    down = max(1, int((height - TOP_MM - BOTTOM_MM + ROW_GAP_MM) / (side + ROW_GAP_MM)))
    per_page = across * down
    sheets = [markers[first : first + per_page] for first in range(0, len(markers), per_page)]
    return [_draw_page(sheet, number, len(sheets), (side, across)) for number, sheet in enumerate(sheets, 1)]


@figures.style({})
def _draw_page(sheet: Sequence[Cap], number: int, count: int, grid: tuple[float, int]) -> Figure:
    """Draw page `number` (from 1) of `count` pages. `grid`: side of a tile, mm, and number of tiles in a row."""
    width, height = PAGE_MM
    side, across = grid
    figure = Figure(figsize=(width / MM_PER_INCH, height / MM_PER_INCH))
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_xlim(0.0, width)
    axes.set_ylim(0.0, height)
    axes.set_axis_off()
    for index, cap in enumerate(sheet):
        row, column = divmod(index, across)
        x = EDGE_MM + column * (side + COLUMN_GAP_MM) + 0.5 * side
        y = height - TOP_MM - row * (side + ROW_GAP_MM) - 0.5 * side
        _draw_tile(axes, cap, (x, y))
        half = 0.5 * cap.side
        axes.text(x, y - half - 0.8, str(cap.number), ha="center", va="top", fontsize=6.0)
    cap = sheet[0]
    page_note = "" if count == 1 else f", page {number} of {count}"
    axes.text(
        EDGE_MM,
        height - 12.0,
        f"walkergen: markers {cap.dictionary} (OpenCV's ArUco), {cap.marker_mm:g} mm wide{page_note}",
        fontsize=10.0,
        va="top",
    )
    axes.text(
        EDGE_MM,
        height - 17.5,
        "Print at 100 %, on matt paper. Cut along the grey lines, and glue each flat on its walker "
        "with the notch to the front.",
        fontsize=7.5,
        va="top",
    )
    axes.plot([EDGE_MM, EDGE_MM + RULE_MM], [20.0, 20.0], color="black", lw=0.6)
    for tick in np.arange(0.0, RULE_MM + 1.0, 10.0):
        axes.plot([EDGE_MM + tick] * 2, [20.0, 22.0], color="black", lw=0.6)
    axes.text(
        EDGE_MM,
        18.5,
        f"{RULE_MM:g} mm: if your print differs, give `track` the true size of the markers",
        fontsize=7.5,
        va="top",
    )
    return figure


def _draw_tile(axes: Axes, cap: Cap, middle: tuple[float, float]) -> None:
    """Draw the tile of a cap at a point of the page (mm), its front up."""

    def to_page(points: Array) -> Array:
        """Transform points of the tile (x forward) to the page, mm."""
        return np.column_stack([-points[:, 1], points[:, 0]]) + middle

    axes.add_patch(Polygon(to_page(caps.tile_outline(cap)), fill=False, edgecolor="0.6", linewidth=0.2))
    for cell in caps.black_rectangles(cap):
        (left, bottom), (right, top) = to_page(cell).min(axis=0), to_page(cell).max(axis=0)
        size = (right - left, top - bottom)
        axes.add_patch(Rectangle((left, bottom), *size, color="black", linewidth=0.0))


def pdf(drawn: Sequence[Figure]) -> bytes:
    """Return all pages in one PDF, without the date: equal pages give equal bytes."""
    buffer = BytesIO()
    with figures.style(), PdfPages(buffer, metadata={"CreationDate": None, "Title": "walkergen: markers"}) as book:
        for page in drawn:
            book.savefig(page)
    return buffer.getvalue()


def pngs(drawn: Sequence[Figure]) -> list[bytes]:
    """Return each page as PNG of DPI pixels per inch."""
    return [figures.png(page, DPI) for page in drawn]
