"""Hostile tries by class: refused in one clear line or done, nothing half-written."""

import datetime
import os
import sys
import warnings
from pathlib import Path

import hostile_inputs
import numpy as np
import pytest
from nightly_cases import mostly_nightly
from typer.testing import CliRunner

from walkergen.cli import command_line
from walkergen.command_table import load_request
from walkergen.core.errors import InputError
from walkergen.core.files import config, file_reading, safe_text
from walkergen.core.printing.printers import Printer
from walkergen.core.scene import Scene
from walkergen.core.walker.design import Design

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="forks, and limits memory")

SEED = int(os.environ.get("WALKERGEN_HOSTILE_SEED", "16"))
TRIES = int(os.environ.get("WALKERGEN_HOSTILE_TRIES", "2400"))


def judged(tries, folder):
    """Faults of tries, with what was tried."""
    found = []
    for number, one in enumerate(tries):
        place = folder / f"t{number}"
        place.mkdir()
        seen = hostile_inputs.run_try(one, place)
        if told := hostile_inputs.faults(one, seen):
            found.append((number, one.label, told, one.words, seen.err[-500:]))
    return found


@pytest.mark.parametrize(("kind", "count"), [("keys", 4), ("kinds", 5), ("commands", 4)])
def test_a_few_hostile_command_lines(kind, count, tmp_path):
    assert not judged(hostile_inputs.draw_tries(SEED, count, kind), tmp_path)


@pytest.mark.parametrize("kind", ["keys", "names"])
def test_hundreds_of_hostile_files_are_read_or_refused_in_lines(kind, tmp_path):
    path = tmp_path / "x.toml"
    for one in hostile_inputs.draw_tries(SEED, 200, kind):
        if "x.toml" not in one.files:
            continue
        path.write_bytes(one.files["x.toml"])
        model = {"--scene": Scene, "--printer": Printer}.get(one.words[1], Design)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                config.read_section(path, model)
        except InputError as error:
            for line in str(error).splitlines():
                assert str(path) in line, one
        except Warning as seen:
            pytest.fail(f"{one}: {seen!r}")


@pytest.mark.parametrize("kind", sorted({*hostile_inputs.KINDS} - {"growing"}))  # that gives what it has
def test_what_is_no_file_is_not_read(kind, tmp_path):
    hostile_inputs.KINDS[kind](tmp_path / "x")
    with pytest.raises(InputError):
        file_reading.read_bytes(tmp_path / "x", 1000)
    with pytest.raises(InputError):
        list(file_reading.read_lines(tmp_path / "x", "a CSV file", 1000))


@pytest.mark.nightly
def test_thousands_of_hostile_tries(tmp_path):
    hostile_inputs.warm()
    assert not judged(hostile_inputs.draw_tries(SEED, TRIES), tmp_path)


@pytest.mark.nightly
def test_a_body_of_a_million_triangles_becomes_a_family_and_a_plate(tmp_path):
    import trimesh

    mesh = trimesh.creation.box((20.0, 10.0, 4.0))
    for _ in range(8):
        mesh = mesh.subdivide()
    assert len(mesh.faces) == 786_432
    data = mesh.export(file_type="stl")
    for number, name in enumerate(("family", "plate")):
        words = (
            name,
            "--tilt",
            "10",
            "--legs",
            "flexible",
            "--set",
            'body={mesh="b.stl"}',
            "--no-pictures",
            "--out",
            "out",
        )
        place = tmp_path / str(number)
        place.mkdir()
        tried = hostile_inputs.Try(name, words, {"b.stl": data})
        seen = hostile_inputs.run_try(tried, place)
        assert (seen.code, hostile_inputs.faults(tried, seen)) == (0, []), seen.err


@pytest.mark.slow
@pytest.mark.parametrize("name", mostly_nightly(["c.csv", "f.csv", "t.csv", "o.csv"], "t.csv", "o.csv"))
def test_the_tables_that_tries_spoil_are_sound(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = Path(name)
    path.write_text(hostile_inputs.TABLES[name][0])
    words = [word.format(name) for word in hostile_inputs.READERS[name]]
    result = CliRunner().invoke(command_line, words)
    assert result.exit_code == 0, result.output


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("export", "--text", "\udcff"), "text holds bytes that are not UTF-8"),
        (("predict", "--set", "body.outline=[[{}]]"), "outline"),
        (("predict", "u.toml"), "byte 0x00. Save it as UTF-8"),
    ],
)
def test_shapes_and_files_of_other_kinds_are_refused(tmp_path, monkeypatch, words, told):
    monkeypatch.chdir(tmp_path)
    Path("u.toml").write_bytes("name = 'a'\n".encode("utf-16-be"))
    result = CliRunner().invoke(command_line, words)
    assert isinstance(result.exception, InputError), result.exception
    assert told in str(result.exception)
    assert "\n" not in str(result.exception)


def test_hidden_letters_are_written_as_json_writes_them():
    import json

    text = "a\x1b[31m\x9b\u202e\ud800\U000e0001\x00é\n"
    seen = safe_text.escape_hidden(text)
    assert seen == "a\\u001b[31m\\u009b\\u202e\\ud800\\udb40\\udc01\\u0000é\n"
    told = json.dumps({"name": "b\u202e\x7fé"}, ensure_ascii=False)
    assert json.loads(safe_text.escape_hidden(told)) == {"name": "b\u202e\x7fé"}


def test_a_line_keeps_its_beginning_and_its_end():
    found = safe_text.shorten_line("file.toml: " + "x" * 5000 + "\ntry less")
    assert len(found) == safe_text.MAX_LINE_LENGTH
    assert found.startswith("file.toml: xx")
    assert found.endswith("x\\ntry less")


def test_what_is_printed_is_plain_and_what_is_told_is_short(monkeypatch, capsys):
    monkeypatch.setattr(sys, "stdout", sys.stdout)
    monkeypatch.setattr(sys, "stderr", sys.stderr)
    safe_text.guard_output()
    print("name\x1b[31m" + "y" * 300)
    print("error: " + "y" * 3000 + "\x07", "next", sep="\n", file=sys.stderr)
    seen = capsys.readouterr()
    assert seen.out == "name\\u001b[31m" + "y" * 300 + "\n"
    assert [len(line) for line in seen.err.splitlines()] == [safe_text.MAX_MESSAGE_LENGTH, 4]
    assert seen.err.endswith("y\\u0007\nnext\n")


@pytest.mark.parametrize("text", ["a = 0x%s" % ("f" * 9000), "a = [{b = 0b1%s}]" % ("0" * 10_000)])
def test_whole_numbers_that_nothing_could_print_are_not_read(text):
    with pytest.raises(ValueError, match=r"a whole number of .* bits"):
        config.parse_toml(text)


@pytest.mark.parametrize(
    ("name", "field", "value"),
    [
        ("predict", "set", 5),
        ("predict", "set", [1]),
        ("predict", "set", {1: 2}),
        ("fit", "fix", int),
        ("sweep", "set", ...),
        ("predict", "set", np.array(5.0)),
        ("accuracy", "budget", datetime.date(2020, 1, 1)),
    ],
)
def test_values_of_python_of_any_type_are_refused_in_a_line(name, field, value):
    required = {"speeds": "speeds.csv"} if name == "fit" else {}
    with pytest.raises(InputError, match=f"^{field}=") as refused:
        load_request(name).from_values({**required, field: value})
    assert "\n" not in str(refused.value)
