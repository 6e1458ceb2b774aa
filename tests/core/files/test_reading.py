"""The one reader of people's files: what it forgives, what it refuses, what it leaves alone."""

import csv
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import walkergen as wg
from walkergen.core.errors import InputError
from walkergen.core.files import columns, config, file_reading, tables
from walkergen.core.walker.design import Design


def test_a_byte_order_mark_and_foreign_line_ends_are_forgiven(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_bytes(b"\xef\xbb\xbf[legs]\r\ntilt_deg = 12\r\n")
    assert list(file_reading.read_lines(path, "a TOML file")) == ["[legs]\n", "tilt_deg = 12\n"]
    assert config.read_section(path, Design).legs.tilt_deg == 12.0


@pytest.mark.parametrize(
    ("name", "told"),
    [
        (".", "is a folder. Give a CSV file"),
        ("none.csv", "no such file. Check the path."),
        ("latin.csv", "not a CSV file in UTF-8: byte 0xe9. Save it as UTF-8"),
        ("large.csv", "11 bytes, more than 10: is it the right file?"),
        ("x" * 300, "cannot be read: File name too long"),
        ("a\0b", "its name holds control characters, or bytes that are not UTF-8: rename it"),
        ("a\udc80b", "or bytes that are not UTF-8: rename it"),
    ],
)
def test_an_unreadable_file_gives_one_line_that_names_it(tmp_path, monkeypatch, name, told):
    (tmp_path / "latin.csv").write_bytes(b"caf\xe9\n")
    (tmp_path / "large.csv").write_bytes(b"0123456789\n")
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError) as caught:
        list(file_reading.read_lines(Path(name), "a CSV file", 10))
    assert str(caught.value).endswith(told)
    assert name[:60] in str(caught.value).replace("\\x00", "\0").replace("\\udc80", "\udc80")
    assert "\n" not in str(caught.value)


def test_a_file_in_the_place_of_a_walker_is_named_once():
    with pytest.raises(InputError) as caught:
        wg.predict("../none.svg")
    assert str(caught.value) == "../none.svg: no such file. Check the path."


def test_an_error_in_the_reader_is_not_blamed_on_the_file(tmp_path):
    path = tmp_path / "sound.csv"
    path.write_text("a\n1\n")
    with pytest.raises(ValueError, match="mine"):
        [int(f"mine {line}") for line in file_reading.read_lines(path, "a CSV file")]


@given(st.text(alphabet="ab,'\"=- .\t\v\f\x1c\u2028é", max_size=12), st.sampled_from(["", "\n"]))
def test_cells_are_those_of_the_csv_module_and_apostrophes_before_formulas_go(text, end):
    by_module = [tables.unquote_formula(cell) for cell in next(csv.reader([text + end]), [])]
    assert columns.split_cells(text + end, "some.csv", 1) == by_module


def test_records_are_cells_by_column_and_line():
    found = columns.parse_records(["a, b\n", '1,"x,y"\n', "\n", " , \n", '2,"open\n', "3,z\n"], "mine")
    assert found.names == ["a", "b"]
    assert found.rows == [(2, {"a": "1", "b": "x,y"}), (5, {"a": "2", "b": "open\n"}), (6, {"a": "3", "b": "z"})]


@pytest.mark.parametrize(
    ("lines", "told"),
    [
        ([], "mine: is empty"),
        (["a,a\n"], "mine:1: column 'a' occurs twice"),
        (["a,b\n", "\n", "1,2,3\n"], "mine:3: 3 cells, the header has 2"),
        (["a\n", "x" * 200_000], "mine:2: not valid CSV: field larger"),
    ],
)
def test_records_are_refused_by_their_line(lines, told):
    with pytest.raises(InputError) as caught:
        columns.parse_records(lines, "mine")
    assert str(caught.value).startswith(told)
