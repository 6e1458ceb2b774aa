"""Page of a family: one HTML file that shows its folder, with the parts in 3D, and contains its files."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path, PurePosixPath
from typing import Any, NamedTuple

from walkergen import __version__
from walkergen.files import viewer, web_page
from walkergen.files.viewer import Part

TEMPLATE = Path(__file__).with_name("assets") / "page.html.jinja"

TABLE_PAGE = "family.md"

DOWNLOAD_TYPES = {
    ".3mf": "model/3mf",
    ".csv": "text/csv",
    ".ini": "text/plain",
    ".json": "application/json",
    ".pdf": "application/pdf",
    ".stl": "model/stl",
}
"""Types of files that the page offers for download, by their suffixes. The page contains them completely."""


class Download(NamedTuple):
    """File that the page offers for download."""

    path: str
    """Name of the file in its folder."""
    name: str
    """Name under which it is saved."""
    url: str
    size: str


def render(parts: Sequence[Part], files: Mapping[str, bytes], facts: Mapping[str, Any]) -> bytes:
    """Return the page (UTF-8) of parts in 3D and of the files of their folder by name.

    `facts` are those of the manifest; the elapsed time is left out. Equal input gives equal bytes.
    """
    design = facts["design"]
    name = str(design.get("name", "walkers"))
    plates = [file for file in files if file.startswith("plates/") and file.endswith(".png")]
    sheets = [file for file in files if file.endswith(".md") and file != TABLE_PAGE]
    settings = {key: value for key, value in facts.items() if key != "time_taken_s"}
    body = web_page.fill(
        TEMPLATE,
        name=name,
        description=str(design.get("description", "")),
        view=viewer.render_view(parts),
        speed=_picture_url(files, "speed.png"),
        preview=_picture_url(files, "preview.png"),
        table=web_page.from_markdown(_decode(files, TABLE_PAGE).partition("\n")[2]),
        downloads=[
            _download(path, data) for path, data in files.items() if PurePosixPath(path).suffix in DOWNLOAD_TYPES
        ],
        plates={file: _picture_url(files, file) for file in plates},
        sheets=[web_page.from_markdown(_decode(files, file), level=2) for file in sheets],
        settings=json.dumps(settings, indent=2, ensure_ascii=False),
        version=__version__,
    )
    styles = (viewer.STYLE_SHEET, "page.css")
    return web_page.render(f"{name} · walkergen", body, styles, viewer.page_scripts()).encode()


def _decode(files: Mapping[str, bytes], name: str) -> str:
    """Return the text of a file."""
    return files[name].decode("utf-8", "replace")


def _download(path: str, data: bytes) -> Download:
    """Return a complete file of the folder as a link that works offline."""
    file = PurePosixPath(path)
    return Download(path, file.name, web_page.data_url(DOWNLOAD_TYPES[file.suffix], data), f"{len(data) / 1e3:,.1f} kB")


def _picture_url(files: Mapping[str, bytes], name: str) -> str | None:
    """Return the data address of a picture (PNG); None if the folder has none."""
    return web_page.data_url("image/png", files[name]) if name in files else None
