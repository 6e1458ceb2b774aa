"""Pages of the site that are made of other files: the README, the pictures, the docstrings."""

import re
from pathlib import Path

from mkdocs.structure.files import File, Files
from mkdocs.structure.nav import Section

ROOT = Path(__file__).parent.parent
PAPERS = {
    "index.md": "README.md", "contributing.md": "CONTRIBUTING.md", "changelog.md": "CHANGELOG.md"
}  # fmt: skip
"""Pages that are papers of the project, whose links to docs/ become links within the site."""

ROOMS = {
    "walkers": ["walker/design", "walker/limbs", "walker/body", "walker/solids", "walker/mass"],
    "scenes": ["scene"],
    "theory": [
        "theory/impact",
        "theory/tensors",
        "theory/speed",
        "theory/balance",
        "theory/stationary",
    ],
    "predictions": ["theory/prediction", "theory/uncertain", "theory/discrepancy"],
    "simulation": [
        "simulation/plan",
        "simulation/experiments",
        "simulation/ensemble",
        "simulation/run",
        "simulation/observables",
        "simulation/resolution",
        "simulation/trajectory",
    ],
    "explorations": [
        "points/axes",
        "points/request",
        "points/point",
        "points/measure",
        "points/evaluate",
        "points/run",
        "points/worker_pool",
        "points/drops",
    ],
    "analysis": [
        "analysis/tracks",
        "analysis/motion",
        "analysis/fits",
        "analysis/speeds",
        "analysis/beams",
        "analysis/inverse",
    ],
    "printing": ["printing/printers", "printing/checks", "printing/plates", "printing/export"],
    "files": ["files/templates", "files/config", "files/assignments", "files/output", "errors"],
}
"""Modules of the reference, a page for each room."""


def on_files(files, config):
    """Add the pages that are made."""
    made = {page: _paper(ROOT / name) for page, name in PAPERS.items()}
    made["gallery.md"] = _gallery()
    for room, modules in ROOMS.items():
        names = [f"walkergen.{module.replace('/', '.')}" for module in modules]
        made[f"api/{room}.md"] = f"# {room.capitalize()}\n\n" + "\n\n".join(
            f"::: {name}" for name in names
        )
    for page, text in made.items():
        files.append(File.generated(config, page, content=text))
    return Files([file for file in files if not file.src_path.endswith(".py")])


def _paper(path):
    """Text of a paper of the project, as a page; what lies outside docs/ is no link there."""
    text = re.sub(
        r"\[([^]]+)\]\((?!https?:|#|docs/)[^)]+\)", r"\1", path.read_text(encoding="utf-8")
    )
    return re.sub(r"\]\(docs/", "](", text)


def _gallery():
    """Page of all pictures that the program makes, with what the pages say under each."""
    pages = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
    text = "".join(page.read_text(encoding="utf-8") for page in pages)
    shown = {name: told for told, name in re.findall(r"!\[(.*?)\]\((?:docs/)?(.*?)\)", text)}
    return "# Gallery\n\n" + "\n\n".join(
        f"## {told}\n\n![{told}]({name})" for name, told in shown.items()
    )


def on_nav(nav, config, files):
    """Put the reference behind the pages that are written."""
    pages = [files.get_file_from_path(f"api/{room}.md").page for room in ROOMS]
    nav.items.append(Section("Reference", pages))
    return nav
