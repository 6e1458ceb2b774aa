"""Rows of walkers in lanes are what the model in space gives."""

import math

import pytest

from evidence.tables import lanes
from walkergen.points.measure import Runs, measure
from walkergen.simulation.experiments import Walker
from walkergen.walker import solids


def test_every_row_is_a_walker_that_can_be_built():
    rows = list(lanes.read())
    assert len(rows) > 5000
    assert sum(row["held_out"] for row in rows) > 190
    for row in rows[:: len(rows) // 50]:
        scene, design = lanes.case(row)
        assert (scene.arena.kind == "lane") == (row["play_mm"] is not None)
        assert design.tilt_deg == row["tilt_deg"]


@pytest.mark.slow
def test_rows_come_out_again():
    rows = [row for row in lanes.read() if row["se_mm_s"] and not row["held_out"] and not row["toppled"]][::1000]
    for row in rows:
        scene, design = lanes.case(row)
        walker = Walker(scene, design, solids.mass_of(design))
        speed = measure(walker, Runs(scene.run.runs)).quantities["speed_mm_s"]
        # five digits of every number are another walker, whose runs are others: four errors of the difference
        se = math.hypot(row["se_mm_s"], speed.se or 0.0)
        assert abs(speed.value - row["speed_mm_s"]) < 4.0 * se + 0.1
