"""What every command prints: a small run of each against its file in tests/golden/.

Numbers of simulations are masked, because chaos makes other digits of another processor. Times and names of machines
are masked everywhere. After a change of words `python tests/cli/test_outputs.py` writes the files again: read what it
changed, then commit it.
"""

import os
import re
import shlex
import tempfile
from pathlib import Path
from typing import NamedTuple
from unittest import mock

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

    lines: tuple[str, ...]
    simulated: bool = False
    """Whether numbers are masked."""
    slow: bool = False


RUNS = {
    "app": Run(("app --help",)),
    "family": Run(
        ("family --tilt 5,10 --no-pictures", "family maker-large --tilt 10 --legs flexible --copies 4 --no-pictures")
    ),
    "export": Run(("export --tilt 12 --format stl,3mf", "export coinbot --tilt 10 --format mjcf")),
    "check": Run(("check --tilt 5,10 --printer ender3", "check name --strict", "check part.stl --weigh")),
    "plate": Run(
        (
            "plate --tilt 5,10 --copies 8 --serial 1 --no-pictures",
            "plate --orders orders.csv --how-many",
            "plate --copies 2 --caps aruco --no-pictures",
        )
    ),
    "predict": Run(
        (
            "predict --tilt 10",
            "predict --tilt 5:30:5 --legs flexible,braced",
            "predict --tilt 10 --uncertain --why",
            "predict --weights weights.csv --tilt 10 --legs flexible",
        )
    ),
    "sweep": Run(
        (
            "sweep --set legs.tilt_deg=5,10,15 --no-pictures",
            "sweep --set legs.tilt_deg=5:40:5 --wish 40 --no-pictures --out near",
        )
    ),
    "simulate": Run(
        (
            "simulate --tilt 10 --seconds 0.5 --runs 4",
            "simulate --tilt 10 --scene plane-90hz --seconds 1 --runs 4 --all",
            "simulate --tilt 5,10 --seconds 0.3 --runs 4",
            "simulate --tilt 10 --error 30%",
        ),
        simulated=True,
    ),
    "crowd": Run(("crowd --count 3 --arena disc:90 --seconds 0.5 --runs 2 --no-pictures",), simulated=True, slow=True),
    "movie": Run(("movie --tilt 10 --seconds 0.1 --out film.gif",), simulated=True, slow=True),
    "explain": Run(("explain --tilt 10 --no-cost", "explain --scene plane-noisy --no-cost --all"), simulated=True),
    "track": Run(("track film.mp4 --length 40 --fps 50 --no-pictures",), simulated=True, slow=True),
    "analyse": Run(
        ("analyse tracks.csv --fps 50 --mm-per-px 0.1", "analyse tracks.csv --fps 50 --mm-per-px 0.1 --all")
    ),
    "fit": Run(("fit speeds.csv --predict 8,12",), slow=True),
    "calibrate": Run(("calibrate plate --printer ender3", "calibrate form.csv"), simulated=True),
    "accuracy": Run(("accuracy --tilt 10",)),
    "selftest": Run(("selftest --only 6.2",), simulated=True),
    "templates": Run(("templates", "templates copy koumakis2016 my.toml")),
}
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
    rows = [(frame, particle, *place) for particle, (frame, place) in tracks]
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
    if simulated:  # columns are as wide as their numbers
        text = re.sub(r"(?<=\S) {2,}", "  ", re.sub(r"[─━-]{3,}", "---", text))
    return "".join(f"{line.rstrip()}\n" for line in text.splitlines()).rstrip() + "\n"


def printed(run):
    """Return what the command lines of a run print in the working folder."""
    write_inputs()
    if any("film.mp4" in line for line in run.lines):
        write_film()
    text = ""
    for line in run.lines:
        with mock.patch("walkergen.commands.accuracy.machine_speed.cpu_per_s", lambda: 0.05):
            result = CliRunner(env={"COLUMNS": "100"}).invoke(command_line, shlex.split(line))
        notes = [one for one in result.stderr.splitlines() if one.startswith(("warning: ", "note: ", "error: "))]
        notes += [f"error: {one}" for one in str(result.exception or "").splitlines() if result.exit_code == 1]
        text += f"$ walkergen {line}\n" + mask("\n".join([*notes, result.stdout]), run.simulated) + "\n"
    return text


def test_every_command_has_a_file():
    assert set(RUNS) == set(COMMANDS)
    assert {path.stem for path in GOLDEN.glob("*.txt")} == set(RUNS)


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * run.slow) for name, run in RUNS.items()]
)
def test_a_command_prints_what_it_printed(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    assert printed(RUNS[name]) == (GOLDEN / f"{name}.txt").read_text(encoding="utf-8")


if __name__ == "__main__":
    import sys

    sys.path[:0] = [str(Path(__file__).parents[2])]
    for name in sys.argv[1:] or RUNS:
        with tempfile.TemporaryDirectory() as folder:
            os.chdir(folder)
            text = printed(RUNS[name])
            os.chdir(GOLDEN)
            (GOLDEN / f"{name}.txt").write_text(text, encoding="utf-8")
