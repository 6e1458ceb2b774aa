"""The order of the step's error in scenes too short for chaos: sliding and landings (docs/physics.md section 7)."""

import numpy as np
import pytest

from walkergen.commands.accuracy.report import convergence_order
from walkergen.core.scene import Scene
from walkergen.core.simulation import record
from walkergen.core.simulation.plan import prepare
from walkergen.core.simulation.run import MAX_DROP_TURN_RAD
from walkergen.core.simulation.space.state import HEIGHT, PITCH, SHOWN_X
from walkergen.core.simulation.world import OK
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design

STEP_SHARES, EXACT_SHARE = (1.2, 1.0, 0.7, 0.5, 0.35, 0.25), 1.0 / 32.0
"""Steps over that which resolves the feet, and that of the reference. A landing may go another way by
a step half as long again."""

DROPS = 32
DESIGN = Design()
MASS = solids.mass_of(DESIGN)


def change_step(plan, share):
    """The plan by a share of the step that resolves the feet."""
    run = plan.scene.run.model_copy(update={"step_us": 1e6 * share * prepare(Scene(), DESIGN, MASS).world.options.step})
    return prepare(plan.scene.model_copy(update={"run": run}), DESIGN, MASS)


def sliding():
    """Slide for 5 ms, settled, 10 deg beyond the angle of friction, on a plate too calm to throw the walker."""
    scene = Scene()
    slope = float(np.degrees(np.arctan(scene.contact.friction))) + 10.0
    drive = {"frequency_hz": scene.drive.frequency, "gamma": 0.3}
    plan = prepare(Scene.model_validate({"drive": drive, "plate": {"slope_deg": slope}}), DESIGN, MASS)
    state = plan.initial_state(0.0, 0.0, 1.0)
    change_step(plan, 0.25).advance(state, 0.02, record.new_tally(len(state)))
    return plan, [state], 0.005


def landings():
    """Drop the walker over half a period, from many heights, pitches, rolls and phases."""
    plan = prepare(Scene(), DESIGN, MASS)
    drive, rng = plan.world.drive, np.random.default_rng(1)
    starts = [
        plan.initial_state(
            drive.amplitude * rng.uniform(0.5, 1.5),
            MAX_DROP_TURN_RAD * rng.normal(),
            rng.uniform(3.5, 4.5),
            MAX_DROP_TURN_RAD * rng.normal(),
        )
        for _ in range(DROPS)
    ]
    return plan, starts, 0.5 * drive.period


def ends(plan, starts, seconds):
    """Mean place, height and pitch (mm at the feet) at the end, so that instants inside a step average out."""
    found = []
    for start in starts:
        state = start.copy()
        assert plan.advance(state, seconds, record.new_tally(len(state))) == OK
        found.append(state[[SHOWN_X, HEIGHT, PITCH]])
    return np.mean(np.array(found) * (1.0, 1.0, 0.5 * DESIGN.foot_span), axis=0)


@pytest.mark.slow
@pytest.mark.nightly
@pytest.mark.parametrize(("scene", "claimed", "allowance"), [(sliding, 2.0, 0.6), (landings, 1.0, 0.4)])
def test_the_step_errs_by_the_order_that_is_claimed(scene, claimed, allowance):
    """Smooth sliding errs by second order; landings, where contacts close inside a step, by first.

    Tolerances: frames end at other instants for other steps; 32 drops leave 20 % of an error.
    """
    plan, starts, seconds = scene()
    true = ends(change_step(plan, EXACT_SHARE), starts, seconds)
    errors = [np.abs(ends(change_step(plan, share), starts, seconds) - true).max() for share in STEP_SHARES]
    slope, _ = convergence_order(STEP_SHARES, errors)
    assert slope == pytest.approx(claimed, abs=allowance)
