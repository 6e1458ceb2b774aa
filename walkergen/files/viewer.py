"""3D view of parts, for a page of its own, or for a notebook in a frame.

A frame is a sandboxed page of its own. Every view contains the compressed viewer, a fifth of a megabyte, and the
compressed meshes.
"""

import base64
import zlib
from collections.abc import Sequence
from functools import cache
from html import escape
from typing import NamedTuple

import markupsafe
import numpy as np

from walkergen.core.numerics import Array, Whole
from walkergen.files import web_page

STYLE_SHEET = "part.css"
"""Style sheet of the view."""

MAX_TRIANGLES = 300_000
"""Largest number of triangles of all parts in a view. They take about 4 MB, and a laptop turns them smoothly."""

HEIGHT_PX = 360
"""Height of a frame, pixels of the page."""


class Part(NamedTuple):
    """Part in a view."""

    name: str
    kind: str
    """Kind of its legs, flexible or braced, which determines its colour."""
    vertices: Array
    """Corners of the mesh, shape (n, 3), mm, y up, in the part's upright position."""
    triangles: Whole
    """Corners of each triangle, shape (k, 3)."""
    words: str = ""
    """Description shown next to its name."""


def viewer_script() -> str:
    """Read the viewer's bundle, built from viewer/; it defines walkergenViewer."""
    return web_page.read_asset("viewer.min.js")


def page_scripts() -> list[str]:
    """Return the texts of the scripts that a page with a view must allow."""
    return [web_page.read_asset("part.js"), viewer_script()]


def render_view(parts: Sequence[Part]) -> markupsafe.Markup:
    """Return HTML of a 3D view that shows one of the parts at a time. A page can contain only one."""
    corners = [part.vertices[part.triangles].astype("<f4").tobytes() for part in parts]
    return web_page.fill(
        web_page.ASSETS / "part.html.jinja",
        parts=[
            {"name": part.name, "kind": part.kind, "triangles": len(part.triangles), "words": part.words}
            for part in parts
        ],
        meshes=_compress(b"".join(corners)),
        viewer=_compressed_viewer(),
        script=markupsafe.Markup(web_page.read_asset("part.js")),
    )


def render_frame(parts: Sequence[Part], title: str) -> str:
    """Return HTML of a frame with the 3D view of parts, for a notebook, and a line of text below it.

    Parts beyond MAX_TRIANGLES are left out, and the line names them. Equal parts give equal HTML.
    """
    seen = _parts_within_limit(parts)
    left_out = [part.name for part in parts[len(seen) :]]
    html = []
    if seen:
        page = escape(web_page.render(title, render_view(seen), (STYLE_SHEET, "frame.css"), page_scripts()), quote=True)
        size = f"{len(page) / 1e6:.2f}"
        html.append(
            f'<iframe title="{escape(title)}" sandbox="allow-scripts" srcdoc="{page}" style="width:'
            f'100%;max-width:44rem;height:{HEIGHT_PX}px;border:0"></iframe>'
            f"<p><small>3D view: {size} MB of this notebook, nothing is fetched.</small></p>"
        )
    if left_out:
        names = ", ".join(left_out[:3]) + (" ..." if len(left_out) > 3 else "")
        html.append(
            f"<p>{len(left_out)} of {len(parts)} parts are not in the 3D view, which has "
            f"{MAX_TRIANGLES} triangles at most: {escape(names)}</p>"
        )
    return "".join(html)


def _parts_within_limit(parts: Sequence[Part]) -> Sequence[Part]:
    """Return the first parts that have at most MAX_TRIANGLES together."""
    total = np.cumsum([len(part.triangles) for part in parts])
    return parts[: int(np.searchsorted(total, MAX_TRIANGLES, side="right"))]


def _compress(data: bytes) -> str:
    """Return compressed data as base64 text."""
    return base64.b64encode(zlib.compress(data, 9)).decode()


@cache
def _compressed_viewer() -> str:
    return _compress(viewer_script().encode())
