"""Laws that every planar model obeys, through the plans that a scene makes."""

import math

import numpy as np
import pytest
from night import by_day

from walkergen.errors import InputError
from walkergen.scene import Scene
from walkergen.simulation import ensemble, record
from walkergen.simulation.effects.resolve import changed, in_a_plane
from walkergen.simulation.effects.slope import RULE as SLOPE
from walkergen.simulation.plan import prepare
from walkergen.simulation.run import Outcome, simulate
from walkergen.simulation.world import OK
from walkergen.walker import mass as masses
from walkergen.walker import solids
from walkergen.walker.design import Design

MODELS = ("rigid", "relaxed", "compliant")


def plan_of(model="auto", *, design=None, **tables):
    design = design or Design()
    mass = solids.mass_of(design)
    data = {key: dict(value) for key, value in tables.items()}
    data.setdefault("legs", {})["model"] = model
    scene = Scene.model_validate(data)
    return prepare(scene, design, mass)


def flown(plan, seconds, pitch=2e-3, phase=0.3, clearance=0.05):
    state = plan.start(clearance, pitch, phase)
    tally = record.new(len(state))
    assert plan.advance(state, seconds, tally) == OK
    return state, tally


@pytest.mark.parametrize("model", MODELS)
def test_energy_balances_and_the_outcome_is_ok(model):
    plan = plan_of(model, run={"seconds": 1.0, "discard_seconds": 0.1})
    result = simulate(plan, 0)
    assert result.outcome is Outcome.OK
    assert result.energy_error < (0.02 if model == "compliant" else 1e-4)
    assert result.tally.sums[record.ELAPSED] == pytest.approx(1.0, rel=1e-9)
    assert result.tally.counts[0] > 50


@pytest.mark.parametrize("model", MODELS)
def test_threads_change_no_bit_and_few_runs_are_the_first_of_many(model):
    few = plan_of(model, run={"seconds": 0.2, "discard_seconds": 0.0, "runs": 2})
    many = plan_of(model, run={"seconds": 0.2, "discard_seconds": 0.0, "runs": 5})
    one = ensemble.run(few, lambda *told: None, threads=1)
    four = ensemble.run(many, lambda *told: None, threads=4)
    for a, b in zip(one, four, strict=False):
        np.testing.assert_array_equal(a.block_speeds, b.block_speeds)
        np.testing.assert_array_equal(a.tally.counts, b.tally.counts)


@pytest.mark.parametrize("model", by_day(MODELS, "compliant"))
def test_a_second_harmonic_is_driven_and_paid_for(model):
    drive = {"frequency_hz": 90.0, "gamma": 1.8, "second_harmonic_ratio": 0.3}
    run = {"seconds": 0.3, "discard_seconds": 0.05}
    plan = plan_of(model, drive=drive, run=run)
    result = simulate(plan, 0)
    assert plan.world.drive.harmonic.ratio == 0.3
    assert result.outcome is Outcome.OK
    assert result.energy_error < (0.02 if model == "compliant" else 1e-4)  # steps of 30 us


@pytest.mark.slow
def test_stiff_legs_slide_like_rigid_ones():
    """k_t -> infinity, without impacts: a steep plate shaken at 0.5 g.

    The springs take up the weight in a time of order k^(-1/2), in which friction is less: the
    distance differs by that order.
    """

    def slid(model, modulus):
        design = Design.model_validate({"material": {"youngs_modulus_gpa": modulus}})
        plan = plan_of(
            model,
            design=design,
            drive={"frequency_hz": 90.0, "gamma": 0.5},
            plate={"slope_deg": 30.0},
            legs={"damping_ratio": 1.0},
        )
        state, tally = flown(plan, 0.02, pitch=0.0, phase=0.5 * math.pi, clearance=0.0)
        moved = state[0] - plan.start(0.0, 0.0, 0.5 * math.pi)[0]
        return moved, tally

    rigid, _ = slid("rigid", 3.0)
    errors = [abs(slid("compliant", modulus)[0] - rigid) for modulus in (30.0, 300.0, 3000.0)]
    assert errors[0] < 0.02 * abs(rigid)
    # k a hundred times larger; 20 %: the next order at the softest spring.
    assert errors[0] / errors[2] == pytest.approx(10.0, rel=0.2)


def test_descent_helps_and_ascent_hinders():
    speeds = {}
    for slope in (-20.0, 0.0, 20.0):
        plan = plan_of(
            "rigid",
            design=Design().variant(kind="braced"),
            plate={"slope_deg": slope},
            run={"seconds": 2.0, "discard_seconds": 0.2},
        )
        speeds[slope] = simulate(plan, 0).speed
    assert speeds[-20.0] < speeds[0.0] < speeds[20.0]


def test_frozen_joints_weigh_like_the_solid():
    design = Design()
    back, built = design.limbs[0], solids.build(design)
    loose = solids.weigh(design, built)
    frozen = masses.as_rigid(loose)
    whole = masses.weigh(built.walker, 1.24e-3)
    assert frozen.M == pytest.approx(whole.mass, rel=1e-12)
    assert frozen.J == pytest.approx(whole.inertia, rel=1e-12)
    foot = whole.centre[:2] + frozen.legs[0].foot
    np.testing.assert_allclose(foot, np.array(back.anchor) + back.anchor_to_foot)


def verdicts(plan):
    return {effect.name: effect.on for effect in plan.resolved.effects}


def test_the_scene_decides_which_effects_are_simulated():
    plan = plan_of()
    assert plan.resolved.model == "space"
    assert verdicts(plan)["leg compliance"]
    assert verdicts(plan)["yaw and roll"]
    assert verdicts(plan)["sticking in impacts"]
    assert not verdicts(plan)["plate slope"]
    assert not verdicts(plan)["air drag"]
    braced = plan_of(design=Design().variant(kind="braced"))
    assert braced.resolved.model == "space"
    steep = plan_of(plate={"slope_deg": 3.0}, design=Design().variant(tilt_deg=30.0))
    assert verdicts(steep)["plate slope"]
    assert not verdicts(steep)["sticking in impacts"]


def test_effects_can_be_forced_on_and_off():
    level = plan_of(plate={"slope_deg": 3.0}, effects={"off": ["plate_slope"]})
    assert not verdicts(level)["plate slope"]
    assert level.world.acting.gravity.along == 0.0
    assert any("forced off" in effect.reason for effect in level.resolved.effects)
    drag = plan_of(effects={"on": ["air_drag"]})
    assert verdicts(drag)["air drag"]


def test_an_effect_that_does_not_exist_is_no_verdict():
    with pytest.raises(KeyError, match="plate_slope"):
        plan_of().resolved.on("plate_slope")


@pytest.mark.parametrize(
    ("choices", "word"),
    [
        ({"model": "compliant", "design": Design().variant(kind="braced")}, "braced legs are rigid"),
        ({"model": "relaxed", "effects": {"on": ["air_drag"]}}, "without drag"),
        ({"model": "rigid", "effects": {"on": ["air_drag"]}}, "air_drag.*: .*'space'"),
    ],
)
def test_contradictions_are_refused(choices, word):
    with pytest.raises(InputError, match=word):
        plan_of(**choices)


def test_an_absent_effect_is_absent_from_the_state():
    assert [len(plan_of(model).start(0.05, 0.0, 0.0)) for model in MODELS] == [9, 9, 13]


def test_the_frequency_of_a_leg_is_that_of_the_spring_simulated():
    plan = plan_of("compliant")
    (compliance,) = [e for e in plan.resolved.effects if e.name == "leg compliance"]
    legs = plan.world.walker.legs[0]
    frequency = math.sqrt(legs.stiffness / legs.inertia) / (2.0 * math.pi)
    assert compliance.number == pytest.approx(frequency / 90.0, rel=1e-12)


def test_without_an_effect_the_rest_stays():
    relaxed = plan_of("relaxed", plate={"slope_deg": 3.0})
    design = Design()
    mass = solids.mass_of(design)
    plan = prepare(in_a_plane(relaxed.scene, "rigid"), design, mass)
    assert plan.resolved.model == "rigid"
    assert plan.resolved.on("plate slope")
    level = prepare(changed(relaxed.scene, SLOPE.off), design, mass)
    assert level.resolved.model == "relaxed"
    assert not level.resolved.on("plate slope")
