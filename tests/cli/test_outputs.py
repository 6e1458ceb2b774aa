"""What every command prints: a small run of each (tests/golden/runs.toml) against its file there.

Numbers of simulations are masked, because chaos makes other digits of another processor. Times and names of machines
are masked everywhere. After a change of words `python tests/cli/test_outputs.py` writes the files again: read what it
changed, then commit it.
"""

import os
import re
import shlex
import tempfile
import tomllib
from pathlib import Path
from typing import NamedTuple
from unittest import mock

import numpy as np
import pytest
import rendered_films
from synthetic_tracks import film
from typer.testing import CliRunner

from walkergen.cli import command_line
from walkergen.command_table import COMMANDS
from walkergen.core.files.tables import csv_text

GOLDEN = Path(__file__).parents[1] / "golden"


class Run(NamedTuple):
    """Command lines of one file."""

    lines: list[str]
    simulated: bool = False
    """Whether numbers are masked."""
    slow: bool = False
    columns: int = 100
    """Width of the terminal. Masked numbers must not wrap lines."""


RUNS = {name: Run(**run) for name, run in tomllib.loads((GOLDEN / "runs.toml").read_text()).items()}
"""Runs by the names of their files."""

TIMES = re.compile(r"(?<![\w.])[\d.]+ (?:ms|s|min|h)\b(?! \()")
NUMBERS = re.compile(r"(?<![\w.])[-+]?\d[\d.,]*(?:e[-+]?\d+)?(?!\w)")


def write_inputs():
    """Write the files that the commands read into the working folder."""
    tables = {
        "orders.csv": "design,tilt_deg,legs,copies\nkoumakis2016,10,,2\nmaker-large,,braced,1\n",
        "weights.csv": "part,grams\nwalker_t10.0_flexible_s0.40,0.9\n",
        "speeds.csv": "tilt_deg,speed_mm_s,speed_se_mm_s\n5,60,1\n10,62,1\n20,25,1\n30,8,1\n",
    }
    for name, text in tables.items():
        Path(name).write_text(text, encoding="utf-8")
    tracks = ((one.particle, place) for one in film(3, 9, 20.0).tracks for place in enumerate(10.0 * one.position))
    rows = [(frame, particle, *place) for particle, (frame, place) in tracks if not np.isnan(place).any()]
    Path("tracks.csv").write_text(csv_text(("frame", "particle", "x", "y"), rows), encoding="utf-8")
    CliRunner().invoke(command_line, ["export", "--tilt", "10", "--quiet", "--out", "part.stl"])


def write_film():
    """Write a film of three walkers."""
    walkers = [[(60.0 + 2.0 * at, 60.0 + 60.0 * one, 0.0) for one in range(3)] for at in range(60)]
    rendered_films.write(Path("film.mp4"), [rendered_films.picture(own, seed=at) for at, own in enumerate(walkers)])


def mask(text, simulated):
    """Return printed text without what differs from run to run, or from machine to machine."""
    text = re.sub(r"measured on: .*(?:\n(?! ).*)*", "measured on: MACHINE\n", text)
    text = NUMBERS.sub("#", text) if simulated else TIMES.sub("# s", text)
    if simulated or "# s" in text:  # columns are as wide as their numbers
        text = re.sub(" {2,}", "  ", re.sub(r"[─━-]{3,}", "---", text))
    return "".join(f"{line.rstrip()}\n" for line in text.splitlines()).rstrip() + "\n"


def printed(run):
    """Return what the command lines of a run print in the working folder."""
    write_inputs()
    if any("film.mp4" in line for line in run.lines):
        write_film()
    text = ""
    for line in run.lines:
        with mock.patch("walkergen.commands.accuracy.machine_speed.cpu_per_s", return_value=0.05):
            result = CliRunner(env={"COLUMNS": "400" if run.simulated else str(run.columns)}).invoke(
                command_line, shlex.split(line)
            )
        assert result.exit_code == 0, (line, result.output, result.exception)
        notes = [one for one in result.stderr.splitlines() if one.startswith(("warning: ", "note: "))]
        text += f"$ walkergen {line}\n" + mask("\n".join([*notes, result.stdout]), run.simulated) + "\n"
    return text


def test_every_command_has_a_file():
    assert set(RUNS) == set(COMMANDS)
    assert {path.stem for path in GOLDEN.glob("*.txt")} == set(RUNS)


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * run.slow) for name, run in RUNS.items()]
)
def test_a_command_prints_what_it_printed(home, name):
    assert printed(RUNS[name]) == (GOLDEN / f"{name}.txt").read_text(encoding="utf-8")


if __name__ == "__main__":
    import sys

    sys.path[:0] = [str(Path(__file__).parents[2])]
    for name in sys.argv[1:] or RUNS:
        with tempfile.TemporaryDirectory() as folder:
            os.chdir(folder)
            os.environ["XDG_CACHE_HOME"] = str(Path(folder) / "cache")
            text = printed(RUNS[name])
            os.chdir(GOLDEN)
            (GOLDEN / f"{name}.txt").write_text(text, encoding="utf-8")
