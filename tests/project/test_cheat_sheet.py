"""The cheat sheet names commands and options that exist."""

import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

from walkergen.cli import command_line
from walkergen.command_table import COMMANDS

TEXT = (Path(__file__).parents[2] / "docs" / "cheat-sheet.md").read_text(encoding="utf-8")
ROWS = re.findall(r"^\| `walkergen (\w+)([^`]*)` \|.*\| (.*) \|$", TEXT, re.MULTILINE)


def test_the_sheet_has_eight_commands_and_one_page():
    assert len({name for name, *_ in ROWS}) == 8
    pdf = (Path(__file__).parents[2] / "docs" / "cheat-sheet.pdf").read_bytes()
    assert len(re.findall(rb"/Type ?/Page\b", pdf)) == 1


@pytest.mark.parametrize(("name", "keys"), [(name, keys) for name, _, keys in ROWS])
def test_each_row_has_three_options_that_its_command_has(name, keys):
    options = re.findall(r"`(--[a-z-]+)", keys)
    assert len(options) == 3
    assert name in COMMANDS
    shown = CliRunner().invoke(command_line, [name, "--help"], prog_name="walkergen").output
    assert {option for option in options if not re.search(rf"{option}\b", shown)} == set()
