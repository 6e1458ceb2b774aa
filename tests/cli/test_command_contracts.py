"""Contracts that every command keeps: a new one is tested without editing this file."""

import functools
import inspect
import json
import re
import shlex
import shutil
from pathlib import Path

import pytest
import rendered_films
import typer
from command_checks import assert_every_form, refusal_of
from synthetic_tracks import film

import walkergen as wg
from walkergen.api import functions
from walkergen.cli import command_line
from walkergen.command_table import COMMANDS, load_request
from walkergen.core.errors import WalkergenError
from walkergen.core.files.tables import csv_text
from walkergen.files import templates
from walkergen.request import field_flag, flag_name

PROGRAM = typer.main.get_command(command_line)
REQUESTS = [name for name, command in COMMANDS.items() if command.folder]
LONG = {"accuracy", "calibrate", "crowd", "explain", "fit", "movie", "selftest", "simulate", "sweep"}
"""Commands whose first example takes more than two seconds; the tests of each run it shorter."""
SLOW_CALLS = {"accuracy", "calibrate", "crowd", "fit", "movie", "track"}
"""Functions whose examples take more than two seconds, or kernels that others do not."""


def options_of(name):
    """Return the flags of a command, by the names of its parameters."""
    return {own.name: max(own.opts, key=len) for own in PROGRAM.commands[name].params if own.opts[0][0] == "-"}


def inputs_of(name):
    """Yield the fields of a request that name a file to read."""
    request = load_request(name)
    for field in request.model_fields:
        own = field_flag(request, field)
        if own.templates or (own.metavar == "FILE" and field != "out"):
            yield field


@pytest.mark.parametrize("name", COMMANDS)
def test_help_names_every_flag(run, name):
    result = run(name, "--help")
    assert result.exit_code == 0
    assert result.stdout.startswith("Usage:")
    for option in options_of(name).values():
        assert re.search(rf"(?<!\S){option}\b", result.stdout)


@pytest.mark.parametrize("name", REQUESTS)
def test_command_function_and_request_have_the_same_parameters(name):
    request = load_request(name)
    fields = set(request.model_fields)
    own = {"json", "quiet"} if request.reports else set()
    assert {parameter.name for parameter in PROGRAM.commands[name].params} == fields | own
    for field, option in options_of(name).items():
        assert field not in fields or option == flag_name(request, field)
    assert all(field_flag(request, field).help.endswith(".") for field in fields)
    if name in functions.FUNCTION_NAMES:
        assert set(functions.make_signature(name).parameters) == fields | {"progress"}


class AskedError(Exception):
    """A request, in place of its job."""


@pytest.mark.parametrize("example", ["example", "other"])
@pytest.mark.parametrize("name", functions.FUNCTION_NAMES)
def test_a_function_asks_what_its_command_asks(run, monkeypatch, name, example):
    @functools.wraps(load_request(name).run)
    def asked(request, progress):
        raise AskedError(request)

    monkeypatch.setattr(load_request(name), "run", asked)
    words = shlex.split(getattr(COMMANDS[name], example))
    (by_command,) = run(*words).exception.args
    values = {field: getattr(by_command, field) for field in by_command.model_fields_set}
    given = {field: value[0] if isinstance(value, tuple) else value for field, value in values.items()}
    with pytest.raises(AskedError) as told:
        functions.make_function(name)(**given)
    (by_function,) = told.value.args
    assert by_function.model_dump() == by_command.model_dump()
    assert (by_command._shell, by_function._shell) == (True, False)


@pytest.mark.parametrize("name", COMMANDS)
@pytest.mark.parametrize("words", [("--no-such-option",), ("a", "b", "c", "d", "e")])
def test_words_that_mean_nothing_exit_with_2(run, tmp_path, name, words):
    assert run(name, *words).exit_code == 2
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(("name", "field"), [(name, field) for name in REQUESTS for field in inputs_of(name)])
def test_a_file_that_is_missing_is_one_clear_line_and_nothing_is_written(run, tmp_path, name, field):
    request, own = load_request(name), field_flag(load_request(name), field)
    required = ["none.csv"] if any(info.is_required() for info in request.model_fields.values()) else []
    words = ["none.toml"] if own.argument else [*required, flag_name(request, field), "none.toml"]
    refusal_of(run, name, *words)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", [name for name in COMMANDS if name not in (*LONG, "app")])
def test_the_first_example_gives_json_or_a_line_where_its_file_is_missing(run, tmp_path, name):
    shutil.copy(templates.find("koumakis2016"), tmp_path / "my.toml")
    result = run(*shlex.split(COMMANDS[name].example), "--json")
    if isinstance(result.exception, WalkergenError):
        assert "no such file" in str(result.exception)
    else:
        json.loads(result.stdout, parse_constant=pytest.fail)


SPEEDS = "tilt_deg,speed_mm_s,speed_se_mm_s\n5,60,1\n10,62,1\n20,25,1\n30,8,1\n"


def write_inputs(folder, name):
    """Write the files that the examples of functions read."""
    (folder / "speeds.csv").write_text(SPEEDS, encoding="utf-8")
    tracks = ((one.particle, place) for one in film(3, 9, 2.0).tracks for place in enumerate(10.0 * one.position))
    rows = [(frame, particle, *place) for particle, (frame, place) in tracks]
    (folder / "tracks.csv").write_text(csv_text(("frame", "particle", "x", "y"), rows), encoding="utf-8")
    if name == "track":
        walkers = [[(60.0 + 2.0 * at, 60.0 + 60.0 * one, 0.0) for one in range(3)] for at in range(60)]
        pictures = [rendered_films.picture(own, seed=at) for at, own in enumerate(walkers)]
        rendered_films.write(folder / "film.mp4", pictures)


@pytest.mark.parametrize(
    "name", [pytest.param(one, marks=[pytest.mark.slow] * (one in SLOW_CALLS)) for one in functions.FUNCTION_NAMES]
)
def test_the_example_of_a_docstring_runs_and_its_report_is_sound(name, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    write_inputs(tmp_path, name)
    reports, run = [], load_request(name).run

    @functools.wraps(run)
    def kept(request, progress):
        reports.append(run(request, progress))
        return reports[-1]

    monkeypatch.setattr(load_request(name), "run", kept)
    (example,) = re.findall("^Example: `(.*)`$", inspect.getdoc(getattr(wg, name)), re.MULTILINE)
    assert example == COMMANDS[name].call
    assert eval(example, {"wg": wg}) is not False
    (report,) = reports
    assert_every_form(report, capsys)


def test_the_example_of_load_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (example,) = re.findall("^Example: `(.*)`$", inspect.getdoc(wg.load), re.MULTILINE)
    assert eval(example, {"wg": wg}) == wg.load(Path(templates.find("koumakis2016"))).variant(tilt_deg=12.0)
