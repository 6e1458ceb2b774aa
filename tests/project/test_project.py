"""The project's own papers agree with one another."""

import json
import os
import re
import subprocess
import sys
import tomllib
from importlib.metadata import metadata, packages_distributions
from pathlib import Path

import pytest
import yaml
from packaging.requirements import Requirement

import hatch_build
from walkergen import __version__

ROOT = Path(__file__).parents[2]
PYPROJECT = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
PROJECT = tomllib.loads(PYPROJECT)["project"]
CITATION = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
ZENODO = json.loads((ROOT / ".zenodo.json").read_text(encoding="utf-8"))
RECIPE = yaml.safe_load((ROOT / "packaging/conda/recipe.yaml").read_text(encoding="utf-8"))

CONDA_NAMES = {"matplotlib": "matplotlib-base"}
"""Packages that are called otherwise there."""


def test_version_and_licence_are_the_same_everywhere():
    changes = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert metadata("walkergen")["Version"] == PROJECT["version"] == __version__
    assert CITATION["version"] == ZENODO["version"] == RECIPE["context"]["version"] == __version__
    assert re.search(r"^## (\S+)", changes, re.MULTILINE)[1] == __version__
    for paper in (ROOT / "README.md", *(ROOT / "docs").glob("*.md")):
        told = re.findall(r"walkergen (\d+\.\d+\.\d+)", paper.read_text(encoding="utf-8"))
        assert set(told) <= {__version__}, paper.name
    licences = CITATION["license"], ZENODO["license"], RECIPE["about"]["license"]
    assert set(licences) == {PROJECT["license"]} == {"MIT"}
    assert (ROOT / "LICENSE").read_text().startswith("MIT License")


def test_the_citation_file_has_the_fields_of_its_format():
    """The fields that the schema of version 1.2.0 requires, and no other names of persons and entities."""
    assert CITATION["cff-version"] == "1.2.0"
    assert CITATION["type"] in ("software", "dataset")
    for work in (CITATION, *CITATION["references"]):
        assert isinstance(work["title"], str)
        for author in work["authors"]:
            assert set(author) <= {"name"} or set(author) <= {"family-names", "given-names", "orcid", "affiliation"}
    assert {"message", "title", "authors"} <= set(CITATION)
    for reference in CITATION["references"]:
        assert {"type", "title", "authors"} <= set(reference)


def test_authors_titles_and_keywords_are_the_same_everywhere():
    authors = [author["name"] for author in PROJECT["authors"]]
    assert [author["name"] for author in CITATION["authors"]] == authors
    assert [author["name"] for author in ZENODO["creators"]] == authors
    assert ZENODO["title"] == CITATION["title"]
    assert ZENODO["keywords"] == CITATION["keywords"] == PROJECT["keywords"]
    assert ZENODO["description"] == RECIPE["about"]["summary"] == PROJECT["description"]
    (paper,) = CITATION["references"]
    assert paper["title"] in ZENODO["references"][0]


def test_the_conda_recipe_has_the_requirements_of_the_package():
    asked = {}
    for text in PROJECT["dependencies"]:
        requirement = Requirement(text)
        asked[CONDA_NAMES.get(requirement.name, requirement.name)] = requirement.specifier
    assert asked.pop("lib3mf")  # not packaged; without it plates are STL files
    run = [Requirement(text) for text in RECIPE["requirements"]["run"] if "${{" not in text]
    assert {one.name: one.specifier for one in run} == asked
    assert PROJECT["requires-python"] == f">={RECIPE['context']['python_min']}"
    (hatchling,) = tomllib.loads(PYPROJECT)["build-system"]["requires"]
    assert Requirement(hatchling) in map(Requirement, RECIPE["requirements"]["host"][1:])


WITHOUT = """
import sys

class Blocked:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in {blocked}:
            raise ModuleNotFoundError(name)

sys.meta_path.insert(0, Blocked())
from walkergen.__main__ import main
main()
"""
"""Command line where some packages are not installed."""


@pytest.mark.slow
@pytest.mark.parametrize("words", [*hatch_build.FIRST, *hatch_build.MORE], ids=lambda words: " ".join(words[:2]))
def test_an_editable_install_compiles_kernels_with_its_build_requirements(words, tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "packaging"))
    monkeypatch.chdir(ROOT)
    import backend

    given = {Requirement(text).name for text in backend.get_requires_for_build_editable()}
    assert given >= backend.COMPILES
    others = {Requirement(text).name for text in PROJECT["dependencies"]} - given
    blocked = {module for module, names in packages_distributions().items() if others & set(names)}
    command = [sys.executable, "-c", WITHOUT.format(blocked=blocked), *words]
    subprocess.run(command, cwd=tmp_path, env=os.environ | {"PYTHONPATH": str(ROOT)}, check=True)


def test_a_tag_makes_wheels_of_five_platforms_and_of_every_python_named():
    jobs = yaml.safe_load((ROOT / ".github/workflows/wheels.yml").read_text())["jobs"]
    matrix = jobs["kernels"]["strategy"]["matrix"]
    assert len(set(matrix["machine"])) == 5
    named = "Programming Language :: Python :: "
    pythons = [text.removeprefix(named) for text in PROJECT["classifiers"] if named in text]
    assert [python for python in pythons if "." in python] == matrix["python"]
    commands = [step.get("run") for step in jobs["kernels"]["steps"]]
    assert "make wheel PYTHON=python" in commands


def test_a_pull_request_runs_the_gate_and_the_tests_of_other_systems():
    workflow = yaml.safe_load((ROOT / ".github/workflows/tests.yml").read_text())
    assert "pull_request" in workflow[True]  # YAML reads the key "on" as true
    jobs = workflow["jobs"]
    assert [step["run"] for step in jobs["gate"]["steps"] if "run" in step] == ["sudo .ci/run"]
    assert [name.split("-")[0] for name in jobs["quick"]["strategy"]["matrix"]["machine"]] == ["macos", "windows"]
    assert jobs["quick"]["steps"][-1]["run"] == "python -m pytest"


def test_links_within_the_papers_lead_somewhere():
    papers = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *(ROOT / "docs").glob("*.md")]
    for paper in papers:
        for link in re.findall(r"\]\((?!https?:|#)([^)#]+)", paper.read_text(encoding="utf-8")):
            assert (paper.parent / link).exists(), (paper.name, link)
