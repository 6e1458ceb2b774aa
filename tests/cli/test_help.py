"""Help as people read it: at every width, with examples that the options understand."""

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

from walkergen.cli import command_line
from walkergen.cli.command_builder import OPTION_HEADINGS
from walkergen.command_table import COMMANDS

FOLDER = Path(__file__).parents[2]
ROOT = typer.main.get_command(command_line)


def leaves(command=ROOT, path=()):
    """Every command of the command line by its words."""
    for name, one in command.commands.items():
        words = (*path, name)
        yield " ".join(words), one
        if hasattr(one, "commands"):
            yield from leaves(one, words)


NAMES = [name for name, _ in leaves()]
EXAMPLES = {name: (own.example, own.other) for name, own in COMMANDS.items()}


def told(monkeypatch, columns, name):
    """Help of a command on a terminal of some width (the library's own runner has 80 columns)."""
    monkeypatch.setenv("COLUMNS", str(columns))
    context = ROOT.make_context("walkergen", [], resilient_parsing=True)
    command = dict(leaves()).get(name, ROOT)
    if name:
        context = command.make_context(name, [], parent=context, resilient_parsing=True)
    return command.get_help(context) + "\n"


def understood(words):
    """Words that no command takes, once the program has read them; refuses what is no option."""
    context, command = None, ROOT
    while command is not None:  # as the program does, but for running it
        context = command.make_context("walkergen", list(words), parent=context)
        words = [*getattr(context, "_protected_args", []), *context.args]
        if not (words and hasattr(command, "commands")):
            break
        _, command, words = command.resolve_command(context, words)
    return words


def test_every_command_has_two_examples_and_there_are_eighteen():
    assert len(EXAMPLES) == 18
    assert all(len(set(examples)) == 2 for examples in EXAMPLES.values())


@pytest.mark.parametrize(("name", "example"), [(name, one) for name, both in EXAMPLES.items() for one in both])
def test_an_example_is_of_its_command_and_its_options_are_real(name, example):
    words = shlex.split(example)
    assert words[: len(name.split())] == name.split()
    words = understood(words)
    assert not words, "left over"


PAGES = [FOLDER / "README.md", FOLDER / "CONTRIBUTING.md", *sorted((FOLDER / "docs").glob("*.md"))]
SHOWN = {
    (page.name, command)
    for page in PAGES
    for text in [page.read_text(encoding="utf-8").replace("\\\n", " ")]
    for command in [
        *re.findall(r"(?<=`)walkergen [^`]*(?=`)", text),
        *(
            line
            for block in re.findall(r"```sh\n(.*?)```", text, re.DOTALL)
            for line in block.splitlines()
            if line.startswith("walkergen ")
        ),
    ]
}
"""Commands in the blocks and sentences of all pages."""

NAMES_OF_OTHERS = {"walkergen prusa-mk3s"}
"""What is no command: an entry among a slicer's print settings."""


@pytest.mark.parametrize(("page", "command"), sorted(SHOWN))
def test_a_command_on_a_page_is_understood(page, command):
    words = shlex.split(command.removesuffix("&"), comments=True)[1:]
    if command in NAMES_OF_OTHERS or words[-1] == "-h" or words[0] == "--version":
        return
    if " ".join(words) not in NAMES:  # a command that a sentence names is one
        assert not understood(words)


def test_an_example_that_no_option_understands_is_seen():
    (command,) = (one for name, one in leaves() if name == "predict")
    with pytest.raises(Exception, match="No such option"):
        command.make_context("predict", ["--colour", "red"])


@pytest.mark.parametrize("columns", [60, 80, 200])
@pytest.mark.parametrize("name", ["", *NAMES])
def test_help_fits_and_shows_no_types(monkeypatch, columns, name):
    text = told(monkeypatch, columns, name)
    lines = text.partition("Examples:")[0].splitlines()
    assert max(len(line) for line in lines) <= min(columns, 80)
    assert not re.search(r"<(str|bool|float|int|path)|\bTEXT\b|<=x|…|\[default: (no-)?pict", text)
    assert "-h, --help" in text
    for example in EXAMPLES.get(name, ()):
        assert f"  walkergen {example}\n" in text  # in one line, to be copied


@pytest.mark.parametrize("words", [["-h"], ["predict", "-h"], ["templates", "copy", "--help"]])
def test_both_flags_ask_for_help(words):
    result = CliRunner().invoke(command_line, words)
    assert result.exit_code == 0
    assert result.stdout.startswith("Usage:")


def test_commands_stand_under_their_headings(monkeypatch):
    text = told(monkeypatch, 80, "")
    headings = re.findall(r"^(\w+):$", text, re.MULTILINE)
    assert headings == ["Options", *dict.fromkeys(own.heading for own in COMMANDS.values())]
    assert re.findall(r"^  ([a-z]+)  ", text, re.MULTILINE) == list(COMMANDS)
    for name, command in leaves():  # each has its own sentence, read without importing it
        assert " ".join(command.help.split("\n\n")[0].split()) in " ".join(text.split()) or " " in name
    assert "..." not in text.partition("Make:")[2]  # whole sentences


def complete(words, shell="bash"):
    """What the program answers to the shell's key for completion."""
    line = f"walkergen {words}"
    own = {"_WALKERGEN_COMPLETE": f"complete_{shell}", "COMP_WORDS": line, "COMP_CWORD": str(len(line.split(" ")) - 1)}
    code = "from walkergen.cli import command_line; command_line(prog_name='walkergen')"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, env=own)
    return result.stdout.split()


@pytest.mark.parametrize(
    ("words", "found"),
    [
        ("sel", ["selftest"]),
        ("predict kou", ["koumakis2016"]),
        ("simulate --scene lane-90hz-f", ["lane-90hz-fitted"]),
        ("templates copy ender", ["ender3", "ender3-v3"]),
    ],
)
def test_the_shell_completes_commands_and_names(words, found):
    assert complete(words) == found


def test_many_options_stand_under_headings_each_once(monkeypatch):
    text = told(monkeypatch, 80, "simulate")
    headings = re.findall(r"^([A-Z][\w ]+):$", text, re.MULTILINE)
    assert headings == ["Arguments", "Options", *OPTION_HEADINGS]
    command = dict(leaves())["simulate"]
    flags = [max(param.opts, key=len) for param in command.params if param.opts[0][0] == "-"]
    assert all(len(re.findall(rf"^  {flag}\b", text, re.MULTILINE)) == 1 for flag in flags)
    assert "Contact and drive" not in told(monkeypatch, 80, "check")
