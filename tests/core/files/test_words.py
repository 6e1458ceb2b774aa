"""Numbers, spans and times as people write them; tables that cut no number at any width."""

import io
import re

import pytest
from rich.console import Console
from rich.table import Table

from walkergen.core.files import formatting
from walkergen.field_values import parse_time
from walkergen.files import rich_tables


@pytest.mark.parametrize(
    ("value", "digits", "told"),
    [
        (260.0, 2, "260"),
        (264.0, 2, "260"),
        (0.26, 2, "0.26"),
        (12345.0, 3, "12300"),
        (9.99e5, 2, "1000000"),
        (7.035e-20, 4, "0"),
        (-0.0, 3, "0"),
        (0.00012345, 3, "0.000123"),
        (-260.0, 2, "-260"),
        (2.5e-5, 2, "0.000025"),
        (3e-9, 2, "3e-09"),
        (3.2e9, 2, "3.2e+09"),
        (1.0, 3, "1"),
    ],
)
def test_numbers_have_exponents_only_far_from_one(value, digits, told):
    assert formatting.format_number(value, digits) == told


@pytest.mark.parametrize(
    ("low", "high", "told"),
    [(None, None, "any value"), (0.2, None, "above 0.2"), (None, 0.3, "below 0.3"), (0.25, 1234.6, "0.25 to 1235")],
)
def test_spans_name_the_end_that_is_known(low, high, told):
    assert formatting.format_range(low, high) == told


@pytest.mark.parametrize(
    ("seconds", "told"),
    [
        (0.26, "260 ms"),
        (1.0, "1 s"),
        (100.0, "100 s"),
        (600.0, "10 min"),
        (7300.0, "2 h"),
        (2.6e-5, "26 us"),
        (3e8, "9.5 years"),
    ],
)
def test_durations_have_units_that_suit_them(seconds, told):
    assert formatting.format_duration(seconds) == told


@pytest.mark.parametrize("seconds", [1.0, 44.2, 119.0, 121.0, 5000.0, 7201.0, 86000.0])
def test_an_advised_budget_is_understood_and_no_shorter(seconds):
    assert seconds <= parse_time(formatting.format_budget(seconds)) <= 2.0 * seconds + 60.0


NUMBERS = [("-45.5", "123.456 ± 0.012", "-1234.5 to 1234.5", "9876543.21"), ("0", "1", "2", "3")]


def print_table(columns, no_wrap=True):
    table = Table(title="T", padding=(0, 1, 0, 0), pad_edge=False)
    for heading in ("tilt", "speed\nmm/s", "95 %", "last"):
        table.add_column(heading, justify="right", no_wrap=no_wrap)
    for row in NUMBERS:
        table.add_row(*row)
    text = io.StringIO()
    rich_tables.print_table(table, Console(file=text, width=columns))
    return text.getvalue()


@pytest.mark.parametrize("no_wrap", [True, False])
@pytest.mark.parametrize("columns", [5, 20, 30, 40, 60, 80])
def test_no_number_is_cut_at_any_width(columns, no_wrap):
    text = print_table(columns, no_wrap)
    shown = re.findall(r"-?\d+(?:\.\d+)?", text)
    for cell in (cell for row in NUMBERS for cell in row):
        for number in re.findall(r"-?\d+(?:\.\d+)?", cell):
            assert number in shown, (number, text)
    assert "…" not in text


def test_pieces_of_a_wide_table_repeat_its_first_column_and_fit():
    text = print_table(40)
    assert text.count("tilt") == text.count("-45.5") == 2
    assert len(re.findall(r"^ *T *$", text, re.MULTILINE)) == 1
    assert max(len(line) for line in text.splitlines()) <= 40
    assert print_table(80).count("tilt") == 1
