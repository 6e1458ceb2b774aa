"""`walkergen analyse --dish`: a crowd from tracks of its runs."""

import json

import numpy as np
import pytest
from crowd_films import gas

from walkergen.core.errors import InputError
from walkergen.guests.crowd import files as crowd_files


@pytest.fixture
def runs(tmp_path):
    """Tracks of four runs of a crowd in a disc of 60 mm."""
    paths = [tmp_path / f"run{seed}.csv" for seed in range(4)]
    for seed, path in enumerate(paths):
        path.write_bytes(crowd_files.to_csv(gas("disc:60", 40, 12, seed)))
    return paths


def test_runs_become_a_page_tables_and_json(run, runs, tmp_path):
    first, *others = map(str, runs)
    more = [word for other in others for word in ("--run", other)]
    out = tmp_path / "out"
    words = ("analyse", first, *more, "--dish", "disc:60", "--body", "3x1", "--out", str(out))
    shown = run(*words, "--json", "--no-pictures")
    assert shown.exit_code == 0
    facts = json.loads(shown.stdout)
    assert facts["runs"] == 4
    assert facts["numbers"]["packing"]["value"] == pytest.approx(40 * 3.0 / (np.pi * 900.0))
    assert facts["numbers"]["polar_order"]["se"] > 0
    folder = out / "analysis"
    names = {path.name for path in folder.iterdir()}
    tables = {f"crowd{part}.csv" for part in ("", "_series", "_runs", "_pairs", "_walls")}
    assert tables | {"crowd.md", "manifest.json"} <= names
    assert "polar order" in (folder / "crowd.md").read_text(encoding="utf-8")


@pytest.mark.slow
def test_a_crowd_is_drawn_from_above_with_its_curves(run, runs, tmp_path):
    run("analyse", str(runs[0]), "--dish", "disc:60", "--out", str(tmp_path / "out"))
    names = {path.name for path in (tmp_path / "out" / "analysis").iterdir()}
    assert {"crowd_above.png", "crowd_course.pdf", "crowd_walls.png", "crowd_pairs.png"} <= names


def test_a_body_may_be_a_walker(run, runs, tmp_path):
    flags = ("--dish", "disc:60", "--no-pictures", "--json", "--out", str(tmp_path / "out"))
    packing = [
        json.loads(run("analyse", str(runs[0]), "--body", body, *flags).stdout)["numbers"]["packing"]
        for body in ("koumakis2016", "28x8")
    ]
    assert packing[0]["value"] == pytest.approx(packing[1]["value"])


def test_the_middle_of_the_dish_may_lie_anywhere(run, runs, tmp_path):
    header, *rows = runs[0].read_text().splitlines()
    moved = tmp_path / "moved.csv"
    cells = [row.split(",") for row in rows]
    shifted = [f"{t},{n},{float(x) + 70},{float(y) - 20},{a}" for t, n, x, y, a in cells]
    moved.write_text("\n".join([header, *shifted]))
    flags = ("--dish", "disc:60", "--no-pictures", "--json")
    there = run("analyse", str(moved), "--middle", "70,-20", "--out", str(tmp_path / "a"), *flags)
    here = run("analyse", str(runs[0]), "--out", str(tmp_path / "b"), *flags)
    density = [json.loads(each.stdout)["numbers"]["wall_density"]["value"] for each in (there, here)]
    assert density[0] == pytest.approx(density[1])
    lost = run("analyse", str(moved), *flags).exception
    assert isinstance(lost, InputError)
    assert "--middle X,Y (mm)" in str(lost)
