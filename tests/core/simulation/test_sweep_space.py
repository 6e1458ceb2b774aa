"""Any walker in space, drive and contact: refused in one clear line, or a lawful motion.

Each example is a whole walker on a whole plate, drawn within the allowed ranges and a little beyond. In CI noise and
roughness of the plate are left out, so that one kernel serves all examples; the nightly sweep draws them as well.
"""

import math
import re

import numpy as np
import pytest
from corner_rival import deepest_of
from hypothesis import event, given, settings
from hypothesis import strategies as st

from walkergen.core.errors import InputError
from walkergen.core.files import config
from walkergen.core.scene import GRAVITY, Scene
from walkergen.core.simulation import record
from walkergen.core.simulation.plan import prepare
from walkergen.core.simulation.run import Outcome, simulate
from walkergen.core.simulation.space.pose import fill_points, update_pose
from walkergen.core.simulation.space.state import LEGS, PHASE, V_X, W_X, work_for
from walkergen.core.walker import mass, solids
from walkergen.core.walker.design import Design

ENDINGS = {Outcome.OK, Outcome.STUCK, Outcome.TOPPLED, Outcome.FOLDED, Outcome.LEFT}
"""Physical ends of a run; an energy error, or no convergence, is none."""

MAX_EVENTS = 50_000

MAX_STEPS = 100_000
"""Steps of one example: feet of 1 MHz are followed for less time than those of 10 kHz."""

MAX_ENERGY_ERROR = 0.05
"""Share of the exchanged energy that may be unaccounted for, as scenes have it. Steps are of second order with 0.6 rad
of the fastest foot each: the worst of 700 examples came to 0.029, with a median of 4e-5."""

STEP_DIVISOR = 4.0
"""By how much smaller a step has to end an energy error."""


def decades(low, high):
    """Numbers spread evenly over the powers of ten from 10^low to 10^high."""
    return st.floats(low, high).map(lambda exponent: 10.0**exponent)


OUTSIDE_VALUES = {
    ("body", "length_mm"): (0.0, -1.0, 1.001e6, math.nan, "28"),
    ("body", "depth_mm"): (0.0, -8.0, math.inf),
    ("body", "thickness_mm"): (0.0, -1e-9, 1e300),
    ("legs", "kind"): ("soft", None),
    ("legs", "tilt_deg"): (85.01, -90.0, 90.0, math.nan),
    ("legs", "length_mm"): (0.0, -7.5, 1e7),
    ("legs", "contact_spacing_mm"): (0.0, -13.0, math.inf),
    ("legs", "flexible_thickness_mm"): (0.0, -0.4, True),
    ("legs", "braced_thickness_mm"): (0.0, -1.0, 2e6),
    ("legs", "brace_thickness_mm"): (0.0, -0.5, math.nan),
    ("legs", "foot"): ("oval", 3),
    ("material", "density_g_cm3"): (0.0, -1.0, 100.1),
    ("material", "youngs_modulus_gpa"): (0.0, -3.0, 1.001e4),
    ("weighed", "body_mass_g"): (0.0, -1.0, 2e12),
    ("weighed", "leg_mass_g"): (0.0, -1.0, math.nan),
    ("drive", "frequency_hz"): (0.0, -90.0, 2e9),
    ("drive", "gamma"): (0.0, -1.8, math.inf),
    ("drive", "second_harmonic_ratio"): (-0.1, 1.01),
    ("drive", "second_harmonic_phase_deg"): (361.0, math.nan),
    ("contact", "restitution"): (-0.01, 1.01, math.nan),
    ("contact", "friction"): (-0.01, 1.1e6, "rough"),
    ("plate", "slope_deg"): (60.0, -60.0, math.nan),
    ("scene_legs", "damping_ratio"): (-0.01, 10.1),
    ("run", "step_us"): (0.0, 1001.0),
}
"""Values just outside what each field allows."""


@st.composite
def unlike_legs(draw, leg, thickness, tilt, length, depth):
    """Legs that differ in place, thickness, lean, kind and friction, and some in height."""
    legs, count = [], draw(st.integers(2, 5))
    foot = draw(st.sampled_from(["flat", "flat", "square", "round"]))
    for number in range(count):
        place = (number + draw(st.floats(0.3, 0.7))) / count - 0.5
        legs.append(
            {
                "along_mm": 0.9 * place * length,
                "foot": foot,
                "across_mm": depth * draw(st.sampled_from([0.0, 0.0, -0.25, 0.25])),
                "width_mm": depth * draw(st.floats(0.1, 0.5)),
                "tilt_deg": tilt * draw(st.sampled_from([1.0, 1.0, 1.0, -1.0, -1.0, 0.5])),
                "length_mm": leg,
                "thickness_mm": thickness * draw(st.floats(0.5, 1.5)),
                "brace_thickness_mm": 0.4 * thickness,
                "kind": draw(st.sampled_from(["flexible", "flexible", "braced"])),
            }
        )
        if draw(st.booleans()):
            legs[-1]["friction"] = draw(st.floats(0.0, 1.0))
    return legs


@st.composite
def walkers(draw, plates):
    """Design and scene tables, keyed by table; `plates`: strategy of "is the plate uneven?"."""
    scale = draw(st.sampled_from([1.0, 1.0, 1.0, 0.1, 10.0]))
    length = scale * draw(st.floats(15.0, 60.0))
    leg = length * draw(st.floats(0.1, 0.5))
    thickness = leg * draw(st.floats(0.02, 0.3))
    tilt = draw(st.one_of(st.sampled_from([0.0, 10.0, -10.0, 35.0]), st.floats(-50.0, 50.0)))
    tilt = tilt if abs(tilt) >= 1e-12 else 0.0  # less is refused
    room = length - 2.0 * abs(leg * math.sin(math.radians(tilt))) - thickness
    depth = scale * draw(st.floats(1.0, 20.0))
    period = 1.0 / draw(st.floats(20.0, 500.0))
    flexible = draw(st.sampled_from([True, True, True, False]))
    lane = draw(st.booleans())
    tables = {
        "body": {"length_mm": length, "depth_mm": depth, "thickness_mm": scale * draw(st.floats(0.5, 8))},
        "legs": {
            "kind": "flexible" if flexible else "braced",
            "tilt_deg": tilt,
            "length_mm": leg,
            "contact_spacing_mm": max(room, 0.2 * length) * draw(st.floats(0.3, 1.02)),
            "flexible_thickness_mm": thickness,
            "braced_thickness_mm": thickness,
            "brace_thickness_mm": thickness * draw(st.floats(0.3, 1.0)),
        },
        "material": {"youngs_modulus_gpa": 3.0 * draw(decades(-2, 2))},
        "weighed": {},
        "drive": {"frequency_hz": 1.0 / period, "gamma": draw(st.one_of(st.just(1.0), st.floats(0.2, 10.0)))},
        "contact": {
            "restitution": draw(st.one_of(st.sampled_from([0.02, 1.0]), st.floats(0.01, 1.0))),
            "friction": draw(st.one_of(st.just(0.0), st.floats(0.0, 1.0), decades(-3, 3))),
        },
        "plate": {
            "youngs_modulus_gpa": draw(st.one_of(st.just(3.2), decades(-3, 3))),
            "slope_deg": draw(st.one_of(st.just(0.0), st.floats(-20.0, 20.0))),
        },
        "arena": {"kind": "lane" if lane else "plane"},
        "scene_legs": {"damping_ratio": draw(st.one_of(st.sampled_from([0.0, 0.05]), st.floats(0.0, 2.0)))},
        "feet": {
            "rigid_tips": draw(st.booleans()),
            "tip_radius_um": draw(st.one_of(st.just(5.0), decades(-3, 3))),
            "tangential_ratio": draw(st.one_of(st.just(0.8), decades(-2, 1))),
            "unevenness_um": draw(st.one_of(st.just(0.0), st.floats(0.0, 100.0))),
        },
        "effects": {"off": draw(st.sampled_from([[], [], [], ["roll_and_yaw"]]))},
        "run": {"discard_seconds": 0.0, "seconds": draw(st.integers(5, 40)) * period},
    }
    if draw(st.booleans()):
        tables["legs"] = draw(unlike_legs(leg, thickness, tilt, length, depth))
    if draw(st.integers(0, 3)) == 0:
        outline = draw(st.sampled_from(["disc", "ellipse"]))
        tables["body"] |= {"outline": outline}
        tables["legs"] = draw(unlike_legs(leg, thickness, tilt, 0.6 * length, 0.6 * depth))
        if outline == "disc":
            depth = length
            del tables["body"]["depth_mm"]
    if isinstance(tables["legs"], list) and tables["legs"][0]["foot"] != "flat":
        tables["stance"] = draw(st.sampled_from(["level", "as built"]))
    if lane:
        tables["arena"] |= {
            "gap_mm": depth * draw(st.floats(0.99, 1.5)),
            "wall_friction": draw(st.floats(0.0, 1.0)),
            "wall_restitution": draw(st.floats(0.02, 1.0)),
        }
    if draw(st.integers(0, 2)) == 0:
        body = scale**3 * draw(decades(-1, 1))
        tables["weighed"] = {"body_mass_g": body, "leg_mass_g": body * draw(decades(-4, 1))}
    if draw(plates):
        tables["plate"] |= {"noise_ratio": draw(st.floats(0.0, 1.0)), "roughness_um": draw(st.floats(0.0, 20.0))}
    if draw(plates):
        numbers = {"horizontal_ratio": (0.0, 2.0), "horizontal_phase_deg": (-180.0, 180.0)}
        numbers |= dict.fromkeys(("gradient_percent_per_mm", "rocking_percent_per_mm"), (-5.0, 5.0))
        tables["plate"] |= {key: [draw(st.floats(*ends)) for _ in range(2)] for key, ends in numbers.items()}
    table, key = draw(st.sampled_from(sorted(OUTSIDE_VALUES)))
    if draw(st.integers(0, 9)) == 0 and isinstance(tables[table], dict):
        tables[table][key] = draw(st.sampled_from(OUTSIDE_VALUES[table, key]))
    return tables


def build_plan(tables):
    """Plan of an example, with as many steps as it may take, or raises InputError."""
    design = config.validate(
        {key: tables[key] for key in ("body", "legs", "material", "weighed", "stance") if key in tables},
        Design,
        "sweep",
    )
    keys = ("drive", "contact", "plate", "arena", "feet", "effects", "run")
    scene = config.validate({key: tables[key] for key in keys} | {"legs": tables["scene_legs"]}, Scene, "sweep")
    plan = prepare(scene, design, solids.mass_of(design))
    seconds = min(scene.run.seconds, MAX_STEPS * plan.world.options.step)
    return plan.with_run_settings(seconds=seconds)


def check_refusal(error, tables):
    """One line a mistake, each naming a field that the example has set."""
    fields = set()
    for table, value in tables.items():
        name = table.removeprefix("scene_")
        if isinstance(value, str):
            fields.add(name)
        elif isinstance(value, list):
            numbered = enumerate(value, start=1)
            fields |= {f"{name}[{number}].{key}" for number, one in numbered for key in one}
        else:
            fields |= {f"{name}.{key}" for key in value}
    for line in str(error).splitlines():
        named = re.search(r"\b([a-z]+(\[\d+\])?(\.[a-z_0-9]+)?)( =|:)", line.removeprefix("sweep: "))
        assert named, line
        assert named[1] in fields | {"drive"}, line


def check_solid(design):
    """Parts of a box on two equal legs make up the whole."""
    shape = solids.build(design)
    whole, body, *legs = (mass.weigh(part, 1.0).volume for part in (shape.walker, shape.body, *shape.legs))
    # Round feet are polygons: the union against its own parts; coordinates carry 16 digits.
    assert whole == pytest.approx(body + sum(legs), rel=1e-11)
    assert body == pytest.approx(math.prod(design.size), rel=1e-12)
    for limb, volume in zip(design.limbs, legs, strict=True):
        if not limb.rigid and limb.foot != "round":
            assert volume == pytest.approx(limb.length * limb.thickness * limb.width, rel=1e-11)
        assert volume > 0.0


def sample_plan(plan):
    """Plan of run 0 with its own print and plate, drawn as `simulate` draws them."""
    rng = np.random.default_rng([plan.scene.run.seed, 0])
    rng.uniform(size=4)  # the drop
    return plan.sample_print(rng)


def gaps_of(world, state):
    """Gap (mm) of every contact of a state."""
    work, copy = work_for(world.walker, state), state.copy()
    update_pose(world, copy, work)
    fill_points(world, copy, work)
    return work.points["gap"]


def largest_speed(plan, rows):
    """Largest kinetic energy over the plate's own speed, g mm^2/s^2, as a speed of the walker."""
    walker = plan.world.walker
    n = len(walker.stiffness)
    v, w = rows[:, V_X : V_X + 3], rows[:, W_X : W_X + 3]
    rates = rows[:, LEGS + n : LEGS + 2 * n]
    twice = walker.mass * (v**2).sum(axis=1) + np.einsum("ti,ij,tj->t", w, walker.inertia, w)
    twice = twice + np.einsum("ti,ij,tj->t", rates, walker.hinge_inertia, rates)
    twice = twice + (walker.stiffness * rows[:, LEGS : LEGS + n] ** 2).sum(axis=1)
    return math.sqrt(twice.max() / walker.mass)


def check_motion(plan, result):
    """Laws of any motion in space."""
    assert result.outcome in ENDINGS, (result.outcome, result.energy_error)
    sums, samples = result.tally.sums, result.tally.samples
    rows = samples.rows[: samples.cursor[0], 1:]
    assert np.isfinite(rows).all()
    assert np.isfinite(result.places).all()
    assert np.isfinite(sums).all()
    assert result.energy_error <= MAX_ENERGY_ERROR, result.energy_error

    # A foot's spring takes at most the whole walker's energy, and its weight on a rising plate.
    drive = plan.scene.drive
    world = sample_plan(plan).world
    walker, noise = world.walker, world.acting.noise
    plate = plan.scene.plate  # along itself, and by slopes as much again where a walker may get
    swayed = 1.0 + (sum(plate.horizontal_ratio) + 2.0 if plate.sways else 0.0)
    shaken = swayed * drive.peak_speed * drive.omega + noise.strongest
    fast = largest_speed(plan, rows) + swayed * drive.peak_speed + noise.fastest
    drive_force = walker.mass * (GRAVITY + shaken)
    for k in range(len(walker.leg)):
        allowed = deepest_of(walker, k, drive_force, 2.0 * fast)
        deepest = -min(gaps_of(world, row)[k] for row in rows)
        assert deepest <= allowed, (k, deepest, allowed)

    # Forces never pull, and stay inside their cones.
    events = result.tally.events
    _, corner, along, normal, *_ = events.rows[: events.cursor[0]].T
    assert (normal >= 0.0).all()
    limit = walker.friction[corner.astype(int)] * normal
    assert (np.abs(along) - limit <= 1e-9 * (limit + normal)).all()

    # Losses are losses, to the accuracy of the balance.
    whole = abs(plan.energy(rows[0]))
    allowed = MAX_ENERGY_ERROR * max(np.abs(sums[record.PLATE_WORK :]).max(), whole)
    for loss in (record.IMPACT_LOSS, record.FRICTION_LOSS, record.DAMPING_LOSS):
        assert sums[loss] >= -allowed, (loss, sums)
    assert (rows[:, PHASE] >= 0.0).all()


def check(tables):
    """Return how an example ends; fail if it is neither refused by name nor physically sound."""
    try:
        plan = build_plan(tables)
    except InputError as error:
        check_refusal(error, tables)
        return "refused: " + type(error).__name__
    design = plan.case.design
    if design.has_legs_table and design.body.outline is None:
        check_solid(design)
    interval = plan.scene.run.seconds / 100.0
    result = simulate(plan, 0, sample_interval=interval, event_room=MAX_EVENTS)
    if result.outcome is Outcome.ENERGY:
        # The outcome asks the user for a smaller step, which must then succeed.
        step_us = max(1e6 * plan.world.options.step / STEP_DIVISOR, 0.01)
        finer = tables | {"run": tables["run"] | {"step_us": step_us}}
        plan = build_plan(finer)
        result = simulate(plan, 0, sample_interval=interval, event_room=MAX_EVENTS)
        event("finer steps")
    check_motion(plan, result)
    return result.outcome.value


def sweep(plates, **examples):
    @settings(deadline=None, database=None, **examples)
    @given(walkers(plates))
    def any_walker(tables):
        event(check(tables))

    any_walker()


def test_a_call_for_less_than_a_billionth_of_a_step_stays_finite():
    tables = {"arena": {"kind": "plane"}}
    design = Design.model_validate({})
    plan = prepare(Scene.model_validate(tables), design, solids.mass_of(design))
    state = plan.initial_state(-1e-6, 0.0, 0.0)
    tally = record.new_tally(len(state))
    plan.advance(state, 1e-9 * plan.world.options.step / 2.0, tally)
    assert np.isfinite(state).all()
    assert np.isfinite(tally.sums).all()


@pytest.mark.slow
def test_any_walker_in_space_is_refused_or_lawful():
    sweep(st.just(False), max_examples=12, derandomize=True)


@pytest.mark.nightly
def test_two_thousand_walkers_in_space_are_refused_or_lawful():
    sweep(st.booleans(), max_examples=2000, print_blob=True)
