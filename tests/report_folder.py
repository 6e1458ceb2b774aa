"""A family's folder to make pages of, with plate maps and a print sheet as larger runs have."""

import hashlib
import json

from walkergen import __version__
from walkergen.files import templates
from walkergen.jobs.make.family import make as family
from walkergen.jobs.page.report import contents
from walkergen.jobs.page.report import make as page
from walkergen.printing.printers import Printer
from walkergen.scene import Scene
from walkergen.walker.design import Design

SHEET = b"# Print sheet\n\n| part | mass (g) |\n|---|---:|\n| walker | 0.83 |\n"
MAP = b"plate,item,x_mm\n1,walker_t10.0_flexible_s0.40_1,5.0\n"


def folder_of(path, tilts=(0.0, 10.0, 35.0), law="poisson", pictures=True):
    """The folder that `family` writes for the paper's walkers."""
    design = templates.load("koumakis2016", "walkers", Design)
    scene = templates.load("lane-90hz", "scenes", Scene)
    contact = scene.contact.model_copy(update={"law": law})
    job = family.Job(
        design=design,
        members=design.members(tilts, None),
        scene=scene.model_copy(update={"contact": contact}),
        printer=templates.load("prusa-mk3s", "printers", Printer),
        mode="coulomb",
        pictures=pictures,
    )
    family.make(job, path, lambda what, done, total: None, lambda findings: None)
    return path


def add(folder, name, data):
    """Put a file into a folder as if its run had written it."""
    path = folder / name
    path.parent.mkdir(exist_ok=True)
    path.write_bytes(data)
    edit(folder, lambda facts: facts["files"].update({name: hashlib.sha256(data).hexdigest()}))


def edit(folder, change):
    """Change the manifest in place."""
    path = folder / "manifest.json"
    facts = json.loads(path.read_text(encoding="utf-8"))
    change(facts)
    path.write_text(json.dumps(facts), encoding="utf-8")


def rendered(folder):
    """The page's text."""
    return page.render(contents.read(folder), __version__).decode()


def written(folder):
    """The page as a file beside its folder's."""
    path = folder / "report.html"
    path.write_text(rendered(folder), encoding="utf-8")
    return path
