"""A family's folder with its page, and the page alone."""

import json

from walkergen.commands.family import page, report
from walkergen.commands.family.request import FamilyRequest


def request_of(path, tilts=(0.0, 10.0, 35.0), **more):
    """The request of a family of the paper's walkers, with its page."""
    return FamilyRequest.from_values({"scene": "lane-90hz", "tilt": tilts, "page": True, "out": path} | more)


def silent(*step):
    """Nothing is reported."""


def made_in(path, *words, **more):
    """Report of the family that `family --page` writes there."""
    return request_of(path, *words, **more).run(silent)


def text_of(folder):
    """The page's text."""
    return (folder / "report.html").read_text(encoding="utf-8")


def files_of(folder):
    """Bytes of the folder's files, by name, but the page's."""
    names = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))["files"]
    return {name: (folder / name).read_bytes() for name in names if name != "report.html"}


def render_page(made, files, parts=None, **design):
    """The page's text of a family that was made, of other files, parts or keys of the design."""
    facts = json.loads((made.folder / "manifest.json").read_text(encoding="utf-8"))
    del facts["files"]
    facts["design"] |= design
    return page.render(parts or report.view_parts(made.members), files, facts).decode()
