"""Cells of CSV files: none is a formula, and our own readers get back what was written."""

import csv
import io

import pytest

from walkergen.core.files.columns import parse_records
from walkergen.core.files.tables import csv_text

FORMULAS = ["=1+1", "@SUM(A1)", "+cmd|' /C calc'!A0", "-2+3", "\t=1", "'=1", "''@x", "=HYPERLINK(1)"]
PLAIN = ["walker", "-5", "+3.5", "-inf", "'quoted'", "", "é", 'a "b", c']


@pytest.mark.parametrize("text", [*FORMULAS, *PLAIN])
def test_a_written_table_is_read_back(text):
    written = csv_text(("name", text or "x"), [(text, 1.5)])
    (line,) = parse_records(written.splitlines(keepends=True), "x").rows
    assert line[1]["name"] == text
    assert list(line[1])[1] == (text or "x").strip()


@pytest.mark.parametrize("text", FORMULAS)
def test_no_cell_begins_as_a_formula(text):
    for row in csv.reader(io.StringIO(csv_text((text,), [(text,)]))):
        assert row[0][0] == "'"


@pytest.mark.parametrize("text", PLAIN)
def test_other_text_and_numbers_stay_as_they_are(text):
    (row,) = list(csv.reader(io.StringIO(csv_text((), [(text, -1.5, None)]))))[1:]
    assert row == [text, "-1.5", ""]
