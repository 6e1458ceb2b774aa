"""3D view of parts in a frame of HTML that needs nothing but itself, for notebooks.

The frame is a page of its own: a sandbox keeps it from the notebook's page, a content security
policy lets only its own scripts run and nothing be fetched, and text is escaped by the template
engine. The viewer and the meshes are packed, so that a saved notebook grows by a fifth of a
megabyte and the meshes; every view holds the viewer, because no frame can reach another's.
"""

import base64
import hashlib
import zlib
from collections.abc import Sequence
from functools import cache
from html import escape
from pathlib import Path
from typing import NamedTuple

import jinja2
import markupsafe
import numpy as np
import numpy.typing as npt

ASSETS = Path(__file__).with_name("assets")

MOST_TRIANGLES = 300_000
"""Triangles of all parts in a view: some 4 MB of a notebook, and what a laptop turns smoothly."""

HEIGHT_PX = 360
"""Height of a frame, pixels of the page."""


class Part(NamedTuple):
    """Part in a view."""

    name: str
    kind: str
    """Kind of its legs, which gives its colour: flexible or braced."""
    vertices: npt.NDArray[np.float64]
    """Corners of the mesh, shape (n, 3), mm, y up, as the part stands."""
    triangles: npt.NDArray[np.int64]
    """Corners of each triangle, shape (k, 3)."""


def script() -> str:
    """The viewer's bundle, built from viewer/: it defines walkergenViewer."""
    return _asset("viewer.min.js")


def hashed(text: str) -> str:
    """Hash of a script as a content security policy names it."""
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()


def frame(parts: Sequence[Part], title: str) -> str:
    """Frame (HTML) in which one of the parts is seen, with its size in words below it.

    Parts beyond MOST_TRIANGLES are left out, and named. Equal parts give equal text.
    """
    seen = _fitting(parts)
    left_out = [part.name for part in parts[len(seen) :]]
    html = []
    if seen:
        page = escape(_page(seen, title), quote=True)
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
            f"{MOST_TRIANGLES} triangles at most: {escape(names)}</p>"
        )
    return "".join(html)


def _fitting(parts: Sequence[Part]) -> Sequence[Part]:
    """First parts that have MOST_TRIANGLES together at most."""
    total = np.cumsum([len(part.triangles) for part in parts])
    return parts[: int(np.searchsorted(total, MOST_TRIANGLES, side="right"))]


def _page(parts: Sequence[Part], title: str) -> str:
    """Page within the frame."""
    corners = [part.vertices[part.triangles].astype("<f4").tobytes() for part in parts]
    own = _asset("part.js")
    listed = [{"name": part.name, "kind": part.kind, "triangles": len(part.triangles)} for part in parts]
    return template_of(ASSETS / "part.html.jinja").render(
        title=title,
        parts=listed,
        meshes=_packed(b"".join(corners)),
        viewer=_packed_viewer(),
        style=markupsafe.Markup(_asset("part.css")),
        script=markupsafe.Markup(own),
        hashes=[hashed(own), hashed(script())],
    )


def _packed(data: bytes) -> str:
    return base64.b64encode(zlib.compress(data, 9)).decode()


@cache
def _packed_viewer() -> str:
    return _packed(script().encode())


def _asset(name: str) -> str:
    """Text of a file that is shipped beside this module."""
    return (ASSETS / name).read_text(encoding="utf-8")


@cache
def template_of(path: Path) -> jinja2.Template:
    """Template of a page in a file that is shipped."""
    environment = jinja2.Environment(
        autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    return environment.from_string(path.read_text(encoding="utf-8"))
