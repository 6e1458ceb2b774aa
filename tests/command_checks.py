"""What every answer keeps: an error is one clear line, a report is sound in every form; its tables read back."""

import csv
import json
import xml.etree.ElementTree as ElementTree

import pytest

from walkergen.cli import console
from walkergen.core.errors import WalkergenError, spell_for_python
from walkergen.files.report import Report


def assert_one_line(error):
    """Check that an error is one clear line that can be printed."""
    (line,) = str(error).splitlines()
    assert line.isprintable()
    assert 10 < len(line) < 400


def refusal_of(run, *words):
    """Run words that are refused, and return the line that says why."""
    result = run(*words)
    assert isinstance(result.exception, WalkergenError), (words, result.output, result.exception)
    assert_one_line(result.exception)
    return str(result.exception)


def assert_every_form(report, capsys):
    """Check that a report is shown on a terminal, as JSON, Markdown, HTML and text, and that its CSV has its keys."""
    assert isinstance(report, Report)
    capsys.readouterr()
    console.print_report(report, json=True, quiet=False)
    json.loads(capsys.readouterr().out, parse_constant=pytest.fail)
    console.print_report(report, json=False, quiet=False, width=80)
    assert "nan" not in capsys.readouterr().out.lower().split()
    title, opening = spell_for_python(report.title), spell_for_python(report.headline or report.title)
    assert report.markdown().startswith(f"# {title}\n")
    assert repr(report).startswith(opening)
    html = report._repr_html_()
    assert ElementTree.fromstring(f"<div>{html}</div>").tag == "div"
    assert all(table._repr_html_() in html for table in report.visible_tables())
    for table in report.tables:
        assert not table.keys or table.csv().splitlines()[0] == ",".join(table.keys)


def rows_of(path):
    """Return the rows of a CSV file, a dict each."""
    with path.open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))
