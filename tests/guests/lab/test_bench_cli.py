"""`calibrate drop` as a user meets it."""

import json

import numpy as np
import pytest

from walkergen.guests.lab import drops
from walkergen.guests.lab.bench import drop

COMMAND = ("calibrate",)


@pytest.fixture
def run(run, monkeypatch):
    for name, few in (("TILTS", (10.0,)), ("FRICTIONS", (0.25,)), ("HEIGHTS", (10.0,))):
        monkeypatch.setattr(drop, name, few)
    return run


@pytest.mark.slow
def test_a_drop_is_inverted_flat_and_from_the_hand(run, tmp_path):
    words = ("--tilt", "10", "--measured", "0.8", "--measured-sd", "0.05", "--drops", "6")
    data = json.loads(run("drop", *words, "--out", "a", "--json").stdout)
    level, hand = data["answers"]
    assert level["branches"][0]["value"] == pytest.approx(0.745, abs=0.03)
    assert "no foot restitution gives that at 10 deg" in hand["told"]
    assert data["settings"] == {}
    rows = data["tables"]["drop"]
    assert [row["restitution"] for row in rows] == list(drops.RESTITUTIONS)
    assert np.all(np.diff([row["flat"] for row in rows]) > 0)
    assert {"drop.csv", "drop.md", "drop.png", "tilts.csv"} <= {path.name for path in (tmp_path / "a").iterdir()}


def test_a_flat_drop_sets_the_scene(run):
    words = ("--roll-deg", "0", "--drops", "2", "--measured", "0.64", "--measured-sd", "0.05")
    data = json.loads(run("drop", *words, "--no-pictures", "--json").stdout)
    (only,) = data["answers"]
    assert only["condition"] == "let go flat"
    assert data["settings"]["contact.restitution"] == pytest.approx(0.5, abs=0.03)
    assert 0.03 < data["settings"]["contact.restitution_sd"] < 0.12


@pytest.mark.nightly
def test_a_drop_is_filmed(run, tmp_path):
    result = run("drop", "--height-mm", "1", "--drops", "2", "--movie", "a.gif", "--quiet")
    assert result.exit_code == 0
    assert result.stdout == ""
    assert (tmp_path / "a.gif").read_bytes()[:6] == b"GIF89a"
