"""Stored tables: their rows are what the recipe makes and the model in space gives; a fit knows its error."""

import json
import math
from itertools import islice

import numpy as np
import pytest
from test_discrepancy import place_at

from evidence.tables import cases, make, plates
from walkergen.points.kinds import evaluate
from walkergen.points.point import Point
from walkergen.theory import discrepancy, motors
from walkergen.theory.surrogate import LINEAR_BELOW


@pytest.mark.parametrize("kind", make.KINDS.values(), ids=make.KINDS)
def test_the_recipe_makes_the_walkers_of_the_stored_rows(kind):
    stored, wide = make.read(kind), len(kind.columns) - len(make.MEASURED)
    chosen = islice(kind.cases(cases.whole(kind.groups)), 12)
    off = [np.abs(stored[:, :wide] - kind.place(case)[0]).max(axis=1).min() for case in chosen]
    assert sum(distance < 1e-3 for distance in off) >= 9  # of some no run ended well


@pytest.mark.slow
@pytest.mark.parametrize("kind", make.KINDS.values(), ids=make.KINDS)
def test_rows_of_the_table_are_what_the_model_in_space_gives(kind):
    """Chaotic runs: equal to the bit on one machine, elsewhere within errors of four runs."""
    stored, wide, compared = make.read(kind), len(kind.columns) - len(make.MEASURED), 0
    for case in islice(kind.cases(cases.whole(kind.groups)), 2, 8):
        row = make.row(kind, case, evaluate(Point(case.design, case.scene, simulated=True, keep=())))
        if row is None:
            continue
        nearest = stored[np.argmin(np.abs(stored[:, :wide] - row[:wide]).sum(axis=1))]
        assert nearest[:wide] == pytest.approx(row[:wide], abs=1e-3)
        # Five standard errors of a difference: t of three freedoms passes them once in 80.
        assert abs(nearest[wide] - row[wide]) <= 5.0 * math.hypot(nearest[wide + 1], row[wide + 1]) + 0.02
        compared += 1
    assert compared >= 3


def test_errors_stored_are_those_of_rows_left_out():
    """A table that says too little of its error, or too much, is not written unseen."""
    flexible, of_motors = (
        json.loads(str(np.load(path)["facts"]))["errors"] for path in (discrepancy.TABLE.path, motors.TABLE.path)
    )
    assert 0.9 < flexible["flexible"]["all"]["z_rms"] < 1.1
    assert 0.92 < flexible["flexible"]["all"]["z_within_95"] < 0.98
    assert 0.92 < of_motors["all"]["z_within_95"] < 0.98
    assert of_motors["all"]["z_rms"] < 1.01
    for group in ("two legs", "three to twelve legs", "axis across", "axis along"):
        assert 0.9 < of_motors[group]["z_within_95"] < 1.0, group
    assert of_motors["all"]["explained"] > 0.85


def synthetic(count=600):
    """Rows whose speeds, scatter in time and scatter between prints are known."""
    rng = np.random.default_rng(4)
    places = np.tile(np.array(place_at()), (count, 1))
    places[:, 0] = np.sqrt(rng.uniform(1.0, 40.0, count))
    places[:, 1] = rng.uniform(0.1, 0.9, count)
    places[:, 8] = rng.choice([0.0, 0.1, 0.2], count)
    y = 1.5 + np.sin(places[:, 0]) + places[:, 1]
    scatter = np.hypot(0.05, places[:, 8])[:, None] * rng.standard_normal((count, 4))
    speed = LINEAR_BELOW * np.sinh(y + scatter.mean(axis=1))
    se = 0.5 * scatter.std(axis=1, ddof=1) * np.hypot(speed, LINEAR_BELOW)
    rows = np.column_stack([np.zeros(count), places, speed, se, np.full(count, 4.0)])
    return np.vstack([rows, np.column_stack([np.ones(40), rows[:40, 1:]])]), places, y


def test_a_fit_knows_its_function_its_error_and_the_scatter_between_prints():
    made, places, y = synthetic()
    arrays = plates.table(made, cores=1, steps=120)
    found = discrepancy.fitted(arrays, "flexible", places)
    assert np.median(np.abs(found.centre - y)) < 0.03
    uneven = places[:, 8] > 0.0
    assert found.between_prints[uneven] == pytest.approx(places[uneven, 8], rel=0.4)
    assert np.all(found.between_prints[~uneven] == 0.0)
    told = json.loads(str(arrays["facts"]))["errors"]["flexible"]["all"]
    assert 0.85 < told["z_rms"] < 1.15
    assert make.as_bytes(arrays) == make.as_bytes(plates.table(made, cores=1, steps=120))
