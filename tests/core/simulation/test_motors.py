"""Walkers with a motor: simulated, and the heading follows the motor's side."""

import numpy as np

from walkergen.core.scene import Scene
from walkergen.core.simulation.plan import prepare
from walkergen.core.simulation.run import simulate
from walkergen.core.simulation.space.state import HEADING
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.files import templates

TABLE = templates.load("table-motor", "scenes", Scene)
SPINNER = templates.load("spinner", "walkers", Design)


def test_a_motor_at_the_other_side_circles_the_other_way():
    """The template's comment: 1.8 rad/s to the left."""
    image = SPINNER.variant(**{"motor.across_mm": -SPINNER.motor.across_mm})
    short = {"run.seconds": 0.8, "run.discard_seconds": 0.2, "run.runs": 3}
    rates = []
    for design in (SPINNER, image):
        plan = prepare(TABLE.variant(**short), design, solids.mass_of(design))
        for number in range(3):
            result = simulate(plan, number, sample_interval=0.02, sample_size=HEADING + 1)
            samples = result.tally.samples
            times, *_, heading = samples.rows[: samples.cursor[0]].T
            rates.append((heading[-1] - heading[0]) / (times[-1] - times[0]))
    left, right = np.reshape(rates, (2, 3))
    assert left.mean() > 0.5
    assert right.mean() < -0.5
