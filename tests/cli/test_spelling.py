"""Texts name fields once: a command spells them as flags, Python as arguments, and no other file spells a flag."""

import ast
import json
import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

import walkergen as wg
from walkergen.cli import command_line, console
from walkergen.command_table import COMMANDS, for_call, for_shell, load_request
from walkergen.core.errors import FIELD_PATTERN, InputError, spell, spell_all, spell_for_python, use_spelling
from walkergen.files.report import Report, Table, key_columns

PACKAGE = Path(wg.__file__).parent

DOORS = ("cli/", "command_table.py", "app/document.py", "app/command_results.py", "app/downloads.py")
"""Files that make or read command lines."""

SLICERS = ("core/printing/slicer.py", "core/printing/print_sheet.py")
"""Files that write command lines of slicers."""

NO_FIELD = {"help"}
"""What a message may name that is a flag of every command."""

COMMAND = re.compile(r"`[^`]*`|walkergen [a-z]+[^;,:()]*|with(?:out )?--model.*")
"""Whole command, which is one in Python too."""

TEXT = "‹mm_per_px›, ‹tilt=›12, ‹cost=False›"


def test_a_text_is_spelled_as_its_reader_writes_fields():
    assert for_shell(TEXT) == "--mm-per-px, --tilt 12, --no-cost"
    assert for_shell("leave ‹design› out", {"design": "DESIGN"}) == "leave DESIGN out"
    assert spell_for_python(TEXT) == "mm_per_px, tilt=12, cost=False"
    source = "‹command line›: scene.run.runs = 0: must be"
    assert for_shell(source) == "command line: scene.run.runs = 0: must be"
    assert spell_for_python(source) == "scene.run.runs = 0: must be"
    assert for_call(source, {"scene.run.runs": "runs"}) == "runs=0: must be"
    assert for_call(source, {"scene.run.seed": "seed"}) == "scene.run.runs = 0: must be"


def test_what_a_person_wrote_in_the_same_quotes_stays():
    assert spell_for_python("‹Ärger›: ‹12›") == for_shell("‹Ärger›: ‹12›") == "‹Ärger›: ‹12›"


def test_an_error_keeps_the_spelling_of_the_door_that_it_leaves_by():
    error = InputError(TEXT)
    assert str(error) == "mm_per_px, tilt=12, cost=False"
    with use_spelling(for_shell):
        assert str(error) == spell(TEXT) == "--mm-per-px, --tilt 12, --no-cost"
    assert str(error) == spell(TEXT) == "mm_per_px, tilt=12, cost=False"
    with pytest.raises(InputError) as left, use_spelling(for_shell):
        raise error
    assert str(left.value) == "--mm-per-px, --tilt 12, --no-cost"
    assert left.value.text == TEXT


def test_files_have_pythons_names_and_a_terminal_has_flags(capsys):
    table = Table(
        "rows", [(1.5, "‹tilt›")], ("speed", "note"), key_columns(("speed", "note"), ("note",)), "", ["‹legs›"]
    )
    report = Report(name="a", title="A", tables=[table], facts={"n": [(1, "‹tilt›")]}, lines=["‹runs=›3"])
    for text in (report.markdown(), repr(report), report._repr_html_()):
        assert "runs=3" in text
        assert "‹" not in text
    assert report.table["note"].tolist() == ["tilt"]
    assert list(report.table) == [{"speed": 1.5, "note": "tilt"}]
    page, rows = report.markdown(), report.table.csv()
    assert rows.split() == ["speed,note", "1.5,tilt"]
    with use_spelling(for_shell):
        assert (report.markdown(), report.table.csv()) == (page, rows)
        console.print_report(report, json=False, quiet=False)
        console.print_report(report, json=True, quiet=False)
    table, _, facts = capsys.readouterr().out.partition("{")
    assert "--tilt" in table
    assert "--legs\n--runs 3\n" in table
    assert json.loads("{" + facts) == {"n": [[1, "--tilt"]]}


def test_reports_of_functions_name_arguments():
    report = wg.simulate(tilt=10, seconds=0.05, runs=1)
    assert report.lines
    assert "--" not in "".join(report.lines)
    assert "‹" not in repr(report.facts) + "".join(report.lines)


def test_spelling_leaves_data_as_they_are():
    data = {"a": [1, 2.5, None, True, "x"], "b": ("y", {"c": "z"})}
    assert spell_all(data) == data


CALLS = [
    (lambda: wg.predict(tilt=95), r"^tilt=95: must be a number in -85\.\.85 deg$"),
    (lambda: wg.predict(mode="exact"), r"^mode='exact': must be one of"),
    (lambda: wg.simulate(runs=0), r"^runs=0: must be a whole number >= 1"),
    (lambda: wg.simulate(set={"scene.run.runs": 0}), r"^scene\.run\.runs = 0: must be a whole number >= 1"),
    (lambda: wg.simulate(error="5%", seconds=3), r"^seconds=3\.0: cannot be combined with error, which chooses it\."),
    (lambda: wg.predict(tilt=9, set={"legs.tilt_deg": 8}), r"^set legs\.tilt_deg: tilt=9\.0 sets it too"),
    (lambda: wg.track("x.mp4"), r"^the scale: give either mm_per_px, .*, or length, the length"),
    (lambda: wg.crowd("koumakis2016", count={"rotator": 3}), r"already names the designs\. Leave design out\.$"),
    (lambda: wg.calibrate(), r"^what is missing. Write plate, drop or a filled form, or plate=FILE\.$"),
    (lambda: wg.movie(seconds=1, periods=3), r"^seconds and periods: both set the duration"),
]


@pytest.mark.parametrize(("call", "told"), CALLS, ids=[told for _, told in CALLS])
def test_python_reads_of_its_arguments(call, told):
    with pytest.raises(InputError, match=told) as refused:
        call()
    assert "--" not in str(refused.value)
    assert "command line" not in str(refused.value)


def test_a_command_reads_of_its_flags_after_python_and_before():
    for _ in range(2):
        with pytest.raises(InputError, match=r"^tilt=95"):
            wg.predict(tilt=95)
        error = CliRunner().invoke(command_line, ["predict", "--tilt", "95"]).exception
        assert str(error) == "--tilt '95': must be a number in -85..85 deg"


def texts():
    """Yield the file and the text of every string of the package that is no docstring and no help."""
    for path in sorted(PACKAGE.rglob("*.py")):
        name = str(path.relative_to(PACKAGE))
        if name.startswith(DOORS + SLICERS):
            continue
        tree = ast.parse(path.read_text(encoding="utf-8"))
        skipped = set()
        for node in ast.walk(tree):
            helps = isinstance(node, ast.Call) and getattr(node.func, "id", getattr(node.func, "attr", ""))
            if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
                skipped.add(node.value)
            elif helps in ("Flag", "file_flag"):
                skipped.update(ast.walk(node))
            elif isinstance(node, ast.JoinedStr) and node not in skipped:
                skipped.update(node.values)
                parts = [part.value if isinstance(part, ast.Constant) else "…" for part in node.values]
                yield name, "".join(parts)
        for node in ast.walk(tree):
            if isinstance(node, ast.Constant) and isinstance(node.value, str) and node not in skipped:
                yield name, node.value


def test_no_text_spells_a_flag():
    flag = re.compile(r"(?<![\w-])--[a-z][a-z-]+")
    found = [(name, text) for name, text in texts() if flag.search(COMMAND.sub("", text))]
    assert found == []


def test_every_field_that_a_text_names_is_one():
    fields = {field for name, own in COMMANDS.items() if own.folder for field in load_request(name).model_fields}
    named = {found[1] for _, text in texts() for found in FIELD_PATTERN.finditer(text)}
    assert named - fields - NO_FIELD == set()
    assert len(named) > 50
