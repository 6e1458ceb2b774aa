"""A family's folder with its page, and the page alone."""

import json

from walkergen.commands.family import make as family
from walkergen.commands.family import page, report
from walkergen.core.printing.printers import Printer
from walkergen.core.scene import Scene
from walkergen.core.walker.design import Design
from walkergen.files import templates


def job_of(tilts=(0.0, 10.0, 35.0), pictures=True, **more):
    """The family of the paper's walkers, with its page."""
    design = templates.load("koumakis2016", "walkers", Design)
    scene = templates.load("lane-90hz", "scenes", Scene)
    return family.Job(
        design=design,
        members=design.members(tilts, None),
        scene=scene,
        printer=templates.load("prusa-mk3s", "printers", Printer),
        mode="coulomb",
        pictures=pictures,
        page=True,
    )._replace(**more)


def silent(*told):
    """Nothing is said."""


def made_in(path, *words, **more):
    """Report of the family that `family --page` writes there."""
    return family.make(job_of(*words, **more), path, silent, silent)


def text_of(folder):
    """The page's text."""
    return (folder / "report.html").read_text(encoding="utf-8")


def files_of(folder):
    """Bytes of the folder's files, by name, but the page's."""
    names = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))["files"]
    return {name: (folder / name).read_bytes() for name in names if name != "report.html"}


def rendered(made, files, parts=None, **design):
    """The page's text of a family that was made, of other files, parts or keys of the design."""
    facts = json.loads((made.folder / "manifest.json").read_text(encoding="utf-8"))
    del facts["files"]
    facts["design"] |= design
    return page.render(parts or report.view_parts(made.members), files, facts).decode()
