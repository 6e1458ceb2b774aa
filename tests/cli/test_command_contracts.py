"""Contracts that every command keeps: a new one is tested without editing this file."""

import functools
import json
import re
import shlex
import shutil

import pytest
import typer
from command_checks import refusal_of

from walkergen.api import functions
from walkergen.cli import command_line
from walkergen.command_table import COMMANDS, load_request
from walkergen.core.errors import InputError, WalkergenError
from walkergen.files import templates
from walkergen.request import field_flag, flag_name

PROGRAM = typer.main.get_command(command_line)
REQUESTS = [name for name, command in COMMANDS.items() if command.folder]
LONG = {"accuracy", "calibrate", "crowd", "explain", "fit", "movie", "selftest", "simulate", "sweep"}
"""Commands whose first example takes more than two seconds; the tests of each run it shorter."""


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
    result = run(name, *words)
    assert result.exit_code == 2 or isinstance(result.exception, InputError)  # several files may be given: none exists
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
