"""What is refused, and with which words: every input of tests/golden/refusals.toml against the lines that it holds.

A table has a command, `{}` in which is the input, or one of whose files has the input for its text. Without a command
the input is a command line, of walkergen or of the program `evidence`. `files` are there for all inputs of a table.
After a change of words `python tests/cli/test_refusals.py` writes the file again: read what it changed, then commit it.
"""

import json
import os
import shlex
import tempfile
import tomllib
from pathlib import Path

import pytest
from typer.testing import CliRunner

from evidence.commands import commands
from walkergen.cli import command_line
from walkergen.core.errors import OutputError, WalkergenError

GOLDEN = Path(__file__).parents[1] / "golden" / "refusals.toml"
TABLES = tomllib.loads(GOLDEN.read_text(encoding="utf-8"))


def answer(table, text):
    """Return the lines with which an input is refused with exit code 2, here, in the working folder."""
    for name, content in table.get("files", {}).items():
        Path(name).write_text(content, encoding="utf-8")
    if "file" in table:
        Path(table["file"]).write_bytes(text.encode())
    before = sorted(Path.cwd().iterdir())
    words = shlex.split(table.get("run", text))
    words = [text if word == "{}" else word for word in words]
    program = commands if table.get("program") == "evidence" else command_line
    error = CliRunner().invoke(program, words, catch_exceptions=True).exception
    assert isinstance(error, WalkergenError), (words, error)
    assert not isinstance(error, OutputError)  # of exit code 1
    assert sorted(Path.cwd().iterdir()) == before  # nothing is written
    return str(error)


def entries():
    for name, table in TABLES.items():
        for number, (text, says) in enumerate(table["refused"].items()):
            yield pytest.param(table, text, says, id=f"{name}-{number}-{text[:40]!r}")


@pytest.mark.parametrize(("table", "text", "says"), list(entries()))
def test_a_refusal_says_what_it_said(tmp_path, monkeypatch, table, text, says):
    monkeypatch.chdir(tmp_path)
    assert answer(table, text) == says
    assert says.replace("\n", "").isprintable()
    assert max(map(len, says.splitlines())) < 600


LEGS = "[[legs]]\nalong_mm = -6\n[[legs]]\nalong_mm = 6\n"
ORDERS = "design,tilt_deg,legs,copies\n"
SVG = '<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="100mm" viewBox="0 0 100 100">{}</svg>'
USES = "".join(f'<g id="u{n}">' + f'<use href="#u{n - 1}"/>' * 10 + "</g>" for n in range(1, 12))
LONG = [
    ("set", "body.length_mm=" + "9" * 20_000, "At most 10000"),
    ("set", "body.length_mm=" + "9" * 9_000, "must be a number"),
    ("set", "body.length_mm=" + "[" * 9_000, "is not a list or table of TOML"),
    ("set", "x" * 9_000 + "=1", "unknown key"),
    ("axes", "a." * 5000 + "a=1", "At most 10000"),
    ("design", "a = " + "[" * 20_000, "not valid TOML"),
    ("design", LEGS * 33, "mine.toml:1: legs: has 66 entries. It must have at most 64."),
    ("orders", ORDERS + "koumakis2016,10,," + "9" * 5000 + "\n", ":2: copies = "),
    ("orders", ORDERS + "koumakis2016,5,,1\n" * 5001, "5001 rows, at most 5000 are possible. Split the list."),
    ("orders", ORDERS + "#" * 10_000_000, "10000028 bytes, more than 1000000"),
    ("svg_body", SVG.format(f'<defs><rect id="u0" width="1" height="1"/>{USES}</defs><use href="#u11"/>'), "20000 ele"),
    ("svg_body", SVG.format("<g>" * 3000 + '<rect width="1" height="1"/>' + "</g>" * 3000), "nested"),
]


@pytest.mark.parametrize(("name", "text", "told"), LONG, ids=[f"{name}-{told}" for name, _, told in LONG])
def test_an_input_too_long_to_be_listed_is_refused_in_a_line(tmp_path, monkeypatch, name, text, told):
    monkeypatch.chdir(tmp_path)
    (line,) = answer(TABLES[name], text).splitlines()
    assert told in line
    assert len(line) < 400


def written(tables):
    """Return the file of tables of refusals."""
    for name, table in tables.items():
        yield f"[{name}]"
        yield from (f"{key} = {json.dumps(table[key])}" for key in ("program", "run", "file") if key in table)
        if "files" in table:
            yield f"[{name}.files]"
            yield from (f"{quoted(file)} = {quoted(content)}" for file, content in table["files"].items())
        yield f"[{name}.refused]"
        yield from (f"{quoted(text)} = {quoted(says)}" for text, says in table["refused"].items())
        yield ""


def quoted(text):
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


if __name__ == "__main__":
    for one in TABLES.values():
        for text in one["refused"]:
            with tempfile.TemporaryDirectory() as folder:
                os.chdir(folder)
                one["refused"][text] = answer(one, text)
                os.chdir(GOLDEN.parent)
    GOLDEN.write_text("\n".join(written(TABLES)), encoding="utf-8")
