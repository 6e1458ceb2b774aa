"""The project's own papers agree with one another."""

import re
import tomllib
from importlib.metadata import metadata
from pathlib import Path

from walkergen import __version__

ROOT = Path(__file__).parent.parent


def test_version_and_licence_are_told_alike_everywhere():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    citation = (ROOT / "CITATION.cff").read_text()
    assert re.search(r"^version: (.+)$", citation, re.MULTILINE)[1] == __version__
    assert project["version"] == __version__
    assert re.search(r"^license: (.+)$", citation, re.MULTILINE)[1] == project["license"] == "MIT"
    assert (ROOT / "LICENSE").read_text().startswith("MIT License")
    assert metadata("walkergen")["Version"] == __version__


def test_links_within_the_papers_lead_somewhere():
    papers = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *(ROOT / "docs").glob("*.md")]
    for paper in papers:
        for link in re.findall(r"\]\((?!https?:|#)([^)#]+)", paper.read_text(encoding="utf-8")):
            assert (paper.parent / link).exists(), (paper.name, link)
