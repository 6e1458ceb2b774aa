"""HTML pages that need no other file.

A content security policy allows only the page's scripts, and no requests. The template engine escapes text, and HTML
inside Markdown is shown as text.
"""

import base64
import hashlib
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import markupsafe

if TYPE_CHECKING:
    import jinja2

ASSETS = Path(__file__).with_name("assets")


def render(title: str, body: markupsafe.Markup, styles: Sequence[str], scripts: Sequence[str] = ()) -> str:
    """Return the HTML of a page that needs no other file.

    Parameters
    ----------
    title : str
        Title of the browser's window.
    body : Markup
        HTML of the page's body, with its scripts.
    styles : sequence of str
        Names of the style sheets in the assets.
    scripts : sequence of str
        Texts of the scripts that may run.
    """
    style = markupsafe.Markup("".join(read_asset(name) for name in styles))
    hashes = [f"sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}" for text in scripts]
    return str(fill(ASSETS / "page.html.jinja", title=title, body=body, style=style, hashes=hashes))


def fill(template: Path, **values: Any) -> markupsafe.Markup:
    """Return the HTML of a template file filled with values by name."""
    return markupsafe.Markup(_load_template(template).render(values))


def from_markdown(text: str, level: int = 1) -> markupsafe.Markup:
    """Return the HTML of Markdown without its pictures; headings begin at `level`."""
    from markdown_it import MarkdownIt

    markdown = MarkdownIt("js-default").disable("image")
    tokens = markdown.parse(text)
    for token in tokens:
        if token.type in ("heading_open", "heading_close"):
            token.tag = f"h{min(int(token.tag[1]) + level - 1, 6)}"
    return markupsafe.Markup(markdown.renderer.render(tokens, markdown.options, {}))


def data_url(kind: str, data: bytes) -> str:
    """Return a data: address that contains a file of this media type."""
    return f"data:{kind};base64,{base64.b64encode(data).decode()}"


def read_asset(name: str) -> str:
    """Return the text of a file in the assets."""
    return (ASSETS / name).read_text(encoding="utf-8")


@cache
def _load_template(path: Path) -> "jinja2.Template":
    import jinja2

    environment = jinja2.Environment(
        autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    return environment.from_string(path.read_text(encoding="utf-8"))
