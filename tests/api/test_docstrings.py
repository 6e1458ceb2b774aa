"""Docstrings of the public API: complete as the reference shows them, with examples that run."""

import doctest
import functools
import importlib
import inspect
import runpy
import types
from pathlib import Path

import griffe
import pytest
import rendered_films
from command_checks import assert_every_form

import walkergen as wg
from walkergen.api import functions
from walkergen.command_table import load_request

REFERENCE = runpy.run_path(str(Path(__file__).parents[2] / "docs" / "reference.py"))["REFERENCE"]
PATHS = [path for _, paths in REFERENCE.values() for path in paths]


def load(path):
    """Return the object of a path of the reference."""
    module, _, name = path.rpartition(".")
    return getattr(importlib.import_module(module), name)


SHOWN = {path: load(path) for path in PATHS}
PUBLIC = {f"wg.{name}": getattr(wg, name) for name in wg.__all__ if name != "__version__"}
NAMES = ("Quantity", "Report", "Table", "build", "mass_of", "predict", "prepare", "simulate")
PUBLIC |= {path: thing for path, thing in SHOWN.items() if thing.__name__ in NAMES and path.count(".") > 1}
"""Objects that need an example of their own."""


def public_functions(thing):
    """Return a function, or the public methods that a class defines."""
    if not inspect.isclass(thing):
        return [thing]
    members = {name: member for name, member in vars(thing).items() if not name.startswith("_")}
    return [getattr(thing, name) for name, own in members.items() if isinstance(own, types.FunctionType | classmethod)]


@pytest.mark.parametrize("thing", SHOWN.values(), ids=SHOWN)
def test_a_function_of_the_reference_has_parameters_and_returns(thing):
    members = vars(thing).values() if inspect.isclass(thing) else ()
    properties = [own for own in members if isinstance(own, (property, functools.cached_property))]
    assert all(map(inspect.getdoc, [thing, *properties]))
    for function in public_functions(thing):
        signature = inspect.signature(function)
        parsed = griffe.Docstring(inspect.getdoc(function)).parse("numpy", warnings=False)
        sections = {section.kind.value: section.value for section in parsed}
        parameters = {own.name.lstrip("*"): own.description for own in sections.get("parameters", [])}
        assert list(parameters) == [name for name in signature.parameters if name != "self"], function
        assert all(parameters.values())
        assert ("returns" in sections) == (signature.return_annotation not in (None, "None")), function


def test_the_reference_has_the_public_api():
    reports = {kind for name in functions.FUNCTION_NAMES for kind in functions.report_classes(name)}
    assert [thing for thing in (*PUBLIC.values(), *reports) if thing not in SHOWN.values()] == []


@pytest.mark.parametrize("name", PUBLIC)
def test_every_public_name_has_an_example_that_runs(name, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    reports, command = [], name.removeprefix("wg.")
    if command in functions.FUNCTION_NAMES:
        run = load_request(command).run
        kept = functools.wraps(run)(lambda request, progress: reports.append(run(request, progress)) or reports[-1])
        monkeypatch.setattr(load_request(command), "run", kept)
    if command == "track":
        walkers = [[(60.0 + 2.0 * at, 60.0 + 60.0 * one, 0.0) for one in range(3)] for at in range(20)]
        rendered_films.write("film.mp4", [rendered_films.picture(own, seed=at) for at, own in enumerate(walkers)])
    runner = doctest.DocTestRunner()
    for own in dict.fromkeys([PUBLIC[name], *public_functions(PUBLIC[name])]):
        test = doctest.DocTestParser().get_doctest(inspect.getdoc(own), {}, own.__qualname__, None, None)
        assert test.examples or own is not PUBLIC[name]
        runner.run(test)
    assert runner.summarize(verbose=False).failed == 0, capsys.readouterr().out
    for report in reports:
        assert_every_form(report, capsys)
