"""No folder of Python grows: a feature pays for its lines inside its own folder.

A limit may only fall. Where a folder has shrunk by more than SLACK, its limit is lowered in the same commit. Sections
of docstrings (Parameters, Returns and so on) do not count: they are the reference, which tests/api/test_docstrings.py
requires.
"""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "walkergen"

SLACK = 200
"""Number of lines that a folder may be below its limit."""

LIMITS = {
    "walkergen/analysis": 5730,
    "walkergen/api": 310,
    "walkergen/app": 2670,
    "walkergen/cli": 880,
    "walkergen/commands": 8390,
    "walkergen/core": 18040,
    "walkergen/files": 1540,
    "walkergen/guests/crowd": 7320,
    "walkergen/guests/lab": 5080,
    "walkergen/guests/movie": 1510,
    "walkergen/guests/sweep": 2320,
    "walkergen/guests/track": 3640,
    "walkergen/points": 3440,
    "walkergen/readers": 6250,
    "walkergen/sheets": 560,
    "benchmarks": 2760,
    "docs": 690,
    "evidence": 8000,
    "tests": 41260,
}


SECTIONS = re.compile(
    r"^\n( +)(?:Parameters|Returns|Raises|Notes|References|Examples)\n\1-{5,}\n[\s\S]*?(?=^\1\"\"\"$)", re.MULTILINE
)
"""Sections of a docstring, from the blank line before the first to the closing quotes."""


def count_lines(folder: Path) -> int:
    """Return the number of lines of Python below a folder, without sections of docstrings."""
    files = (path for path in folder.rglob("*.py") if "assets" not in path.parts)
    return sum(len(SECTIONS.sub("", path.read_text(encoding="utf-8")).splitlines()) for path in files)


def test_sections_of_docstrings_do_not_count(tmp_path):
    sections = "\n    Returns\n    -------\n    int\n        Twice."
    (tmp_path / "code.py").write_text(f'def double(x):\n    """Double.\n{sections}\n    """\n    return 2 * x\n')
    assert count_lines(tmp_path) == 4


@pytest.mark.parametrize("folder", LIMITS)
def test_a_folder_stays_below_its_limit(folder):
    lines, limit = count_lines(ROOT / folder), LIMITS[folder]
    assert lines <= limit, f"{folder} grew to {lines} lines"
    assert lines >= limit - SLACK, f"{folder} shrank to {lines} lines: lower its limit"


def test_every_folder_of_the_package_has_a_limit():
    found = [path.parent for pattern in ("*/__init__.py", "guests/*/__init__.py") for path in PACKAGE.glob(pattern)]
    folders = {path.relative_to(ROOT).as_posix() for path in found} - {"walkergen/guests"}
    assert folders == {folder for folder in LIMITS if folder.startswith("walkergen/")}
