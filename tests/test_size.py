"""No folder of Python grows: a feature pays for its lines inside its own folder.

A limit may only fall. Where a folder has shrunk by more than SLACK, its limit is lowered in the same commit.
"""

from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent

SLACK = 200
"""Lines by which a folder may be below its limit."""

LIMITS = {
    "walkergen/analysis": 5410,
    "walkergen/api": 310,
    "walkergen/app": 2620,
    "walkergen/cli": 890,
    "walkergen/crowd": 7780,
    "walkergen/files": 3380,
    "walkergen/jobs": 11770,
    "walkergen/lab": 5200,
    "walkergen/numerics": 950,
    "walkergen/points": 3110,
    "walkergen/printing": 2970,
    "walkergen/readers": 170,
    "walkergen/shapes": 4230,
    "walkergen/simulation": 5970,
    "walkergen/theory": 2570,
    "walkergen/track": 3680,
    "walkergen/walker": 4900,
    "benchmarks": 2740,
    "docs": 630,
    "evidence": 7080,
    "tests": 39050,
}


def count_lines(folder: Path) -> int:
    """Return the number of lines of Python below a folder."""
    files = (path for path in folder.rglob("*.py") if "assets" not in path.parts)
    return sum(len(path.read_text(encoding="utf-8").splitlines()) for path in files)


@pytest.mark.parametrize("folder", LIMITS)
def test_a_folder_stays_below_its_limit(folder):
    lines, limit = count_lines(ROOT / folder), LIMITS[folder]
    assert lines <= limit, f"{folder} grew to {lines} lines"
    assert lines >= limit - SLACK, f"{folder} shrank to {lines} lines: lower its limit"


def test_every_folder_of_the_package_has_a_limit():
    folders = {f"walkergen/{path.parent.name}" for path in (ROOT / "walkergen").glob("*/__init__.py")}
    assert folders == {folder for folder in LIMITS if folder.startswith("walkergen/")}
