"""Effects of a page's scene: the command that measures their changes, and its picture for the page."""

from pathlib import Path

from walkergen.app import document as documents
from walkergen.app import walker_answers
from walkergen.app.document import Document
from walkergen.core.errors import InputError
from walkergen.files import web_page

MAX_BYTES = 10_000_000
"""Largest picture that the page can show, bytes."""


def explain_arguments(document: Document, folder: Path) -> list[str]:
    """Return the words after `walkergen` that measure each effect, and draw it below `folder`. Raises InputError."""
    return documents.arguments(document, "explain", "--measure", "--json", "--out", str(_folder(document, folder)))


def read_picture(document: Document, folder: Path) -> dict[str, str]:
    """Return the picture as a data address. Raises InputError if there is none."""
    path = _folder(document, folder) / "explain.png"
    try:
        data = path.read_bytes()[:MAX_BYTES]
    except OSError:
        raise InputError(f"{documents.SOURCE}: no effects of this walker were measured") from None
    return {"picture": web_page.data_url("image/png", data)}


def _folder(document: Document, folder: Path) -> Path:
    return folder / walker_answers.part_name(document)
