"""Any design, drive and contact: refused in one clear line, or a sound solid and a lawful motion.

Each example is a whole walker on a whole plate, drawn within the allowed ranges and, for one field
in ten, beyond them. One kernel of a model serves all of them, with or without a second harmonic and a slope.
"""

import math
import re

import numpy as np
import pytest
from hypothesis import event, given, settings
from hypothesis import strategies as st

from walkergen.errors import InputError
from walkergen.files import config
from walkergen.scene import Scene
from walkergen.simulation import record
from walkergen.simulation.plan import prepare
from walkergen.simulation.run import Outcome, simulate
from walkergen.walker import mass, solids
from walkergen.walker.design import Design

MODELS = ("rigid", "relaxed", "compliant")

ENDINGS = {Outcome.OK, Outcome.STUCK, Outcome.TOPPLED, Outcome.FOLDED, Outcome.LEFT}
"""Physical ends of a run; an energy error, or no convergence, is none."""

RESOLVED, MOST_STEPS = 0.04, 20_000
"""Oscillations of a leg in a time step beyond which its contact is followed only roughly: its
energy may then miss the balance, which the outcome says. Examples resolve the leg where that takes
no more than so many steps."""

MOST_EVENTS = 200_000

FINER = 100.0
"""By how much smaller a step has to end an energy error."""


def decades(low, high):
    """Numbers spread evenly over the powers of ten from 10^low to 10^high."""
    return st.floats(low, high).map(lambda exponent: 10.0**exponent)


BEYOND = {
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
    ("contact", "law"): ("hooke", 0),
    ("plate", "slope_deg"): (60.0, -60.0, math.nan),
    ("scene_legs", "damping_ratio"): (-0.01, 10.1),
    ("run", "step_us"): (0.0, 1001.0),
}
"""Values just outside what each field allows."""


def between(allowed, usual, wide):
    """Numbers of the `allowed` range where `wide`, else of the `usual` part of it."""
    return st.floats(*(allowed if wide else usual))


@st.composite
def walks(draw, model, wide=False):
    """Design and scene tables, keyed by table.

    `wide`: feet at any distance, legs damped up to 10 times the critical, plates almost at rest.
    """
    scale = draw(st.sampled_from([1.0, 1.0, 1.0, 1e-3, 1e-2, 10.0, 1e3]))
    flexible = model in ("relaxed", "compliant") or draw(st.booleans())
    body_length = scale * draw(st.floats(10.0, 80.0))
    tilt_deg = draw(st.one_of(st.sampled_from([0.0, 1e-12, -1e-12, 1e-6, 85.0, -85.0]), st.floats(-50, 50)))
    length = body_length * draw(st.floats(0.05, 0.5))
    thickness = length * draw(st.floats(0.01, 0.4))
    # What the legs leave of the body for the distance of their feet; a little beyond is refused.
    room = body_length - 2.0 * abs(length * math.sin(math.radians(tilt_deg))) - thickness
    tables = {
        "body": {
            "length_mm": body_length,
            "depth_mm": scale * draw(st.floats(0.1, 20.0)),
            "thickness_mm": scale * draw(st.floats(0.05, 10.0)),
        },
        "legs": {
            "kind": "flexible" if flexible else "braced",
            "tilt_deg": tilt_deg,
            "length_mm": length,
            "contact_spacing_mm": max(room, 0.2 * body_length) * draw(between((0.01, 1.02), (0.3, 1.02), wide)),
            "flexible_thickness_mm": thickness,
            "braced_thickness_mm": thickness,
            "brace_thickness_mm": thickness * draw(st.floats(0.1, 1.05)),
            "foot": draw(st.sampled_from(["flat", "square", "round"])),
        },
        "material": {"density_g_cm3": draw(decades(-2, 2)), "youngs_modulus_gpa": draw(decades(-4, 4))},
        "weighed": {},
        "drive": {
            "frequency_hz": draw(st.floats(5.0, 2000.0)),
            "gamma": draw(
                st.one_of(
                    st.sampled_from([1.0, 1.0 + 1e-9, *([1e-30, 0.5] if wide else [])]),
                    between((1e-3, 60.0), (0.2, 60.0), wide),
                )
            ),
            "second_harmonic_ratio": draw(st.one_of(st.just(0.0), st.floats(0.0, 1.0))),
            "second_harmonic_phase_deg": draw(st.floats(-360.0, 360.0)),
        },
        "contact": {
            "restitution": draw(st.one_of(st.sampled_from([0.0, 1.0]), st.floats(0.0, 1.0))),
            "friction": draw(st.one_of(st.just(0.0), st.floats(0.0, 1.0), decades(-3, 3))),
            "law": draw(st.sampled_from(["poisson", "newton", "stronge"])),
        },
        "plate": {"slope_deg": draw(st.one_of(st.just(0.0), st.floats(-30.0, 30.0)))},
        "scene_legs": {
            "model": model,
            "damping_ratio": draw(st.one_of(st.sampled_from([0.0, 0.05]), between((0.0, 10.0), (0.0, 3.0), wide))),
        },
        "effects": {},
        "run": {"step_us": 30.0, "discard_seconds": 0.0},
    }
    if draw(st.integers(0, 3)) == 0:
        tables["weighed"]["body_mass_g"] = scale**3 * draw(decades(-2, 2))
        tables["weighed"]["leg_mass_g"] = tables["weighed"]["body_mass_g"] * draw(decades(-5, 2))
    # A few periods, in steps that resolve them.
    period = 1.0 / tables["drive"]["frequency_hz"]
    tables["run"]["seconds"] = min(draw(st.integers(5, 60)) * period, 0.3)
    tables["run"]["step_us"] = min(max(1e6 * period / 400.0, 0.01), 30.0)
    if draw(st.integers(0, 9)) == 0:
        table, key = draw(st.sampled_from(sorted(BEYOND)))
        tables[table][key] = draw(st.sampled_from(BEYOND[table, key]))
    return tables


def fastest_swing(plan):
    """Frequency (Hz) of the faster mode of both legs on the free body, which a heavy leg turns."""
    walker = plan.world.walker
    fastest = max(walker.swing.mobility_1, walker.swing.mobility_2)
    return math.sqrt(walker.legs[0].stiffness * fastest) / (2.0 * math.pi)


def built(tables):
    """Design, scene and plan of an example, or raises InputError."""
    design = config.validate({key: tables[key] for key in ("body", "legs", "material", "weighed")}, Design, "sweep")
    scene = config.validate(
        {key: tables[key] for key in ("drive", "contact", "plate", "effects", "run")} | {"legs": tables["scene_legs"]},
        Scene,
        "sweep",
    )
    shape = solids.build(design)
    weighed = solids.weigh(design, shape)
    if scene.legs.model == "compliant":
        seconds, step_us = scene.run.seconds, scene.run.step_us
        frequency = fastest_swing(prepare(scene, design, weighed))
        finest = max(1e6 * seconds / MOST_STEPS, 0.01)
        step_us = min(step_us, max(0.8e6 * RESOLVED / frequency, finest))
        run = scene.run.model_copy(update={"step_us": step_us})
        scene = scene.model_copy(update={"run": run})
    return design, scene, shape, weighed, prepare(scene, design, weighed)


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


def check_solid(design, shape):
    whole, body, *legs = (mass.weigh(part, 1.0).volume for part in (shape.walker, shape.body, *shape.legs))
    # Round feet are polygons: the union against its own parts; coordinates carry 16 digits.
    assert whole == pytest.approx(body + sum(legs), rel=1e-11)
    assert body == pytest.approx(math.prod(design.size), rel=1e-12)
    for limb, volume in zip(design.limbs, legs, strict=True):
        if not limb.rigid and limb.foot != "round":
            assert volume == pytest.approx(limb.length * limb.thickness * limb.width, rel=1e-11)
        assert volume > 0.0


def feet_gaps(plan, weighed, rows, drive):
    """Height of both feet over the plate at every sample, straight from the state."""
    y, pitch, phase = rows[:, 2], rows[:, 3], rows[:, 7]
    if plan.resolved.model == "rigid":
        weighed = mass.as_rigid(weighed)
    alphas = rows[:, 10:12].T if plan.resolved.model == "compliant" else np.zeros((2, len(rows)))
    plate = np.sin(phase)
    if plan.resolved.on("second harmonic"):
        shift = math.radians(drive.second_harmonic_phase_deg)
        plate = plate + drive.second_harmonic_ratio * np.sin(2 * phase + shift)
    heights = []
    for leg, alpha in zip(weighed.legs, alphas, strict=True):
        anchor, reach, turn = leg.anchor, leg.c_A + leg.c_T, pitch + alpha
        foot = anchor[0] * np.sin(pitch) + anchor[1] * np.cos(pitch)
        foot = foot + reach[0] * np.sin(turn) + reach[1] * np.cos(turn)
        heights.append(y + foot - drive.amplitude * plate)
    return np.array(heights)


def impacts_may_gain(plan):
    """True where relaxed legs may gain energy: H of the body exceeds that of a foot for some F."""
    if plan.resolved.model != "relaxed":
        return False
    walker = plan.world.walker
    excess = [
        [
            1 / walker.mass + y * y / walker.inertia - foot.xx,
            -x * y / walker.inertia - foot.xy,
            1 / walker.mass + x * x / walker.inertia - foot.yy,
        ]
        for (x, y), foot in zip(walker.feet, walker.flexible, strict=True)
    ]
    return any(np.linalg.eigvalsh([[xx, xy], [xy, yy]]).max() > 0.0 for xx, xy, yy in excess)


def largest_at_once(times, values):
    """For each event the largest of the values that share its time."""
    if len(times) == 0:
        return values
    starts = np.flatnonzero(np.diff(times, prepend=-1.0))
    largest = np.maximum.reduceat(values, starts)
    return np.repeat(largest, np.diff(starts, append=len(times)))


def check_motion(design, scene, weighed, plan, result):
    unresolved = plan.resolved.model == "compliant" and (1e-6 * scene.run.step_us * fastest_swing(plan) > RESOLVED)
    assert result.outcome in ENDINGS | ({Outcome.ENERGY} if unresolved else set()) | (
        {Outcome.RUNAWAY} if impacts_may_gain(plan) else set()
    ), result.outcome
    if result.outcome is Outcome.RUNAWAY:
        return
    sums, rows = result.tally.sums, result.tally.samples.rows
    rows = rows[: result.tally.samples.cursor[0]]
    assert np.isfinite(rows).all()
    assert np.isfinite(result.block_speeds).all()
    assert np.isfinite(sums).all()

    events = result.tally.events
    count = events.cursor[0]  # the first MOST_EVENTS: restitution 1 at rest never stops bouncing
    times, _, F_x, F_y, _, v_y, _ = events.rows[:count].T
    gaps = feet_gaps(plan, weighed, rows, scene.drive)
    size = design.size.length + design.limbs[0].length + scene.drive.amplitude
    slack = 1e-9 * size
    if plan.resolved.model == "compliant":
        # Landings are located, but within the step that follows a leg may swing back as fast, and
        # the plate rise.
        fastest = scene.drive.peak_speed - v_y.min(initial=0.0)
        slack += 1e-6 * scene.run.step_us * fastest
    assert gaps.min() >= -slack, (gaps.min(), slack)

    limit = scene.contact.friction * F_y
    assert (F_y >= 0.0).all()
    # The impulses of a landing are sums of many, and those of both feet solve one system: rounding
    # of the largest component at that instant.
    worst = (np.abs(F_x) - limit - 1e-9 * largest_at_once(times, np.hypot(F_x, F_y))).max(initial=-1.0)
    assert worst <= 0.0, worst
    # Sliding that jams is stopped on feet whose normal speed is rounding.
    assert v_y.max(initial=-1.0) <= 1e-12 * scene.drive.peak_speed, v_y.max()

    # Losses are losses, to the accuracy of the balance: by time steps that of all the energy a
    # walker has (RunResult.energy_error), by events 1 % of what is exchanged, as slips below the
    # snap speed may be counted with either loss; and a billionth of its energy is rounding.
    whole = abs(plan.energy(rows[0, 1:]))
    exchanged = np.abs(sums[record.PLATE_WORK :]).max()
    step = plan.resolved.model == "compliant"
    allowed = 0.05 * max(exchanged, whole) if step else max(1e-2 * exchanged, 1e-9 * whole)
    assert sums[record.FRICTION_LOSS] >= -allowed or unresolved, sums
    assert sums[record.DAMPING_LOSS] >= -allowed, sums
    if scene.contact.law == "stronge" and plan.resolved.model != "relaxed":
        assert sums[record.IMPACT_LOSS] >= -1e-9 * max(exchanged, 1e-9 * whole), sums
    tolerance = 0.05 if plan.resolved.model == "compliant" else 1e-4
    assert result.energy_error <= tolerance or unresolved, result.energy_error


def check(tables):
    """How an example ends; fails where it is neither refused by name nor lawful."""
    try:
        design, scene, shape, weighed, plan = built(tables)
    except InputError as error:
        check_refusal(error, tables)
        return "refused: " + type(error).__name__
    check_solid(design, shape)
    interval = scene.run.seconds / 200.0
    result = simulate(plan, 0, sample_interval=interval, event_room=MOST_EVENTS)
    if result.outcome is Outcome.ENERGY and plan.resolved.model == "compliant":
        # The outcome tells the user to take a smaller step, which then has to do.
        run = scene.run.model_copy(update={"step_us": max(scene.run.step_us / FINER, 0.01)})
        scene = scene.model_copy(update={"run": run})
        plan = prepare(scene, design, weighed)
        result = simulate(plan, 0, sample_interval=interval, event_room=MOST_EVENTS)
    check_motion(design, scene, weighed, plan, result)
    return result.outcome.value


def sweep(model, wide=False, **examples):
    @settings(deadline=None, database=None, **examples)
    @given(walks(model, wide))
    def any_walker(tables):
        event(check(tables))

    any_walker()


@pytest.mark.slow
@pytest.mark.parametrize("model", MODELS)
def test_any_walker_is_refused_or_lawful(model):
    sweep(model, max_examples=15, derandomize=True)


def pinned(**tables):
    """A whole example from what differs from the paper's walker."""
    whole = {
        "body": {"length_mm": 28.0, "depth_mm": 8.0, "thickness_mm": 3.0},
        "legs": {"kind": "flexible", "tilt_deg": 0.0, "length_mm": 7.5, "contact_spacing_mm": 13.0},
        "material": {},
        "weighed": {},
        "drive": {"frequency_hz": 90.0, "gamma": 1.0},
        "contact": {},
        "plate": {},
        "scene_legs": {"model": "relaxed"},
        "effects": {},
        "run": {"seconds": 0.3, "discard_seconds": 0.0},
    }
    return {table: values | tables.get(table, {}) for table, values in whole.items()}


FOUND = {
    "a foot that rises from within a rounding of the plate, while the other rocks": (
        "ok",
        pinned(
            body={"length_mm": 31.587548992361302, "thickness_mm": 3.8677313301036182},
            legs={
                "tilt_deg": -1.1,
                "length_mm": 9.760665784700837,
                "foot": "round",
                "contact_spacing_mm": 27.924423785901528,
                "flexible_thickness_mm": 3.288365568090941,
            },
            weighed={"body_mass_g": 1.2744359371459175, "leg_mass_g": 31.63353335052381},
            drive={"frequency_hz": 5.0},
            contact={"restitution": 0.4577920141208508, "friction": 0.7434384115773104, "law": "stronge"},
            scene_legs={"model": "rigid"},
        ),
    ),
    "legs heavier than the body, which gain energy when they relax": (
        "energy without bound",
        pinned(
            body={"length_mm": 650.0, "depth_mm": 132.0, "thickness_mm": 0.87},
            legs={"length_mm": 263.8, "contact_spacing_mm": 546.0, "flexible_thickness_mm": 87.9},
            drive={"frequency_hz": 16.0},
            contact={"restitution": 1.0, "friction": 0.0, "law": "stronge"},
        ),
    ),
    "a walker of 0.1 mm that flies a thousand times as high": (
        None,
        pinned(
            body={"length_mm": 0.1, "depth_mm": 0.005, "thickness_mm": 0.06562929326774312},
            legs={
                "tilt_deg": -16.492017579482038,
                "length_mm": 0.049999999999999996,
                "contact_spacing_mm": 0.06435120223105012,
                "foot": "round",
                "flexible_thickness_mm": 0.0008884658956879748,
            },
            weighed={"body_mass_g": 1e-6, "leg_mass_g": 1e-6},
            drive={
                "frequency_hz": 6.562929326774312,
                "second_harmonic_ratio": 0.9099002638365152,
                "second_harmonic_phase_deg": 180.1054753560967,
            },
            contact={"restitution": 1e-9, "friction": 0.0},
        ),
    ),
    "a spinning walker of 10 um, whose flight in steps of a leg's period pumped its swing": (
        None,
        pinned(
            body={"length_mm": 0.01, "depth_mm": 0.001, "thickness_mm": 0.007},
            legs={
                "tilt_deg": 0.0,
                "length_mm": 0.00375,
                "contact_spacing_mm": 0.0044140625000000005,
                "flexible_thickness_mm": 0.001171875,
                "foot": "flat",
            },
            material={"density_g_cm3": 1.0, "youngs_modulus_gpa": 0.0011547819846894581},
            drive={"frequency_hz": 122.0, "gamma": 11.0},
            contact={"restitution": 0.0, "friction": 0.0, "law": "poisson"},
            plate={"slope_deg": 0.0},
            scene_legs={"model": "compliant", "damping_ratio": 0.0},
            run={"step_us": 20.491803278688526, "seconds": 0.09016393442622951},
        ),
    ),
    "a walker that turns as fast as its legs swing, in flights of coarser steps than asked": (
        None,
        pinned(
            body={"length_mm": 0.48132, "depth_mm": 0.001, "thickness_mm": 0.075907},
            legs={
                "tilt_deg": -37.133,
                "length_mm": 0.16007,
                "contact_spacing_mm": 0.20785,
                "flexible_thickness_mm": 0.06362,
                "foot": "square",
            },
            material={"density_g_cm3": 1.0, "youngs_modulus_gpa": 0.0025485},
            drive={"frequency_hz": 5.0, "gamma": 15.428},
            contact={"restitution": 1.0, "friction": 0.88738, "law": "poisson"},
            plate={"slope_deg": 0.0},
            scene_legs={"model": "compliant", "damping_ratio": 0.0},
            run={"step_us": 30.0, "seconds": 0.3},
        ),
    ),
    "overdamped legs, whose foot rebounded into the plate in every step": (
        None,
        pinned(
            body={"length_mm": 285.58, "depth_mm": 27.755, "thickness_mm": 52.781},
            legs={
                "tilt_deg": -36.139,
                "length_mm": 85.818,
                "contact_spacing_mm": 172.52,
                "flexible_thickness_mm": 0.85818,
                "foot": "flat",
            },
            material={"density_g_cm3": 10.0, "youngs_modulus_gpa": 161.48},
            weighed={"body_mass_g": 42.927, "leg_mass_g": 0.0014131},
            drive={"frequency_hz": 247.7, "gamma": 1.0},
            contact={"restitution": 0.97517, "friction": 0.6, "law": "poisson"},
            plate={"slope_deg": 0.0},
            scene_legs={"model": "compliant", "damping_ratio": 2.8774},
            run={"step_us": 10.093, "seconds": 0.20185},
        ),
    ),
    "legs that swing once in a step, whose foot sank while it rose at every step's end": (
        None,
        pinned(
            body={"length_mm": 0.1, "depth_mm": 0.10926674349438197, "thickness_mm": 0.0025},
            legs={
                "tilt_deg": 1e-08,
                "length_mm": 0.04341160473563344,
                "contact_spacing_mm": 0.028516483452350402,
                "flexible_thickness_mm": 0.004945055143678487,
                "foot": "square",
            },
            material={"density_g_cm3": 0.9547540534355297, "youngs_modulus_gpa": 0.3566880363554641},
            weighed={"body_mass_g": 3.566880363554641e-07, "leg_mass_g": 3.566880363554641e-07},
            drive={
                "frequency_hz": 244.05948159735212,
                "gamma": 1.000000001,
                "second_harmonic_ratio": 0.6495474605916366,
                "second_harmonic_phase_deg": 2.3916354370775e-06,
            },
            contact={"restitution": 4e-15, "friction": 0.9547540534355297, "law": "poisson"},
            plate={"slope_deg": 0.6495474605916366},
            scene_legs={"model": "compliant", "damping_ratio": 0.0},
            run={"step_us": 10.243404532524925, "seconds": 0.21716017608952842},
        ),
    ),
    "a plate of 10 m/s that throws the legs around within a step in contact": (
        "leg folded",
        pinned(
            body={"length_mm": 0.1, "depth_mm": 0.001, "thickness_mm": 0.067188},
            legs={
                "tilt_deg": 0.0,
                "length_mm": 0.005,
                "contact_spacing_mm": 0.073619,
                "flexible_thickness_mm": 5e-05,
                "foot": "flat",
            },
            material={"density_g_cm3": 3.4283, "youngs_modulus_gpa": 0.00097534},
            weighed={"body_mass_g": 1e-06, "leg_mass_g": 9.7534e-10},
            drive={"frequency_hz": 7.5, "gamma": 51.28},
            contact={"restitution": 0.0, "friction": 1.0, "law": "poisson"},
            plate={"slope_deg": 0.0},
            scene_legs={"model": "compliant", "damping_ratio": 0.0},
            run={"step_us": 30.0, "seconds": 0.3},
        ),
    ),
    "legs of 23 GHz that keep the rates of an impact over the step": (
        None,
        pinned(
            body={
                "length_mm": 0.07320754259443953,
                "depth_mm": 0.0096518165721802,
                "thickness_mm": 0.006475299517995902,
            },
            legs={
                "tilt_deg": 0.31879239824865824,
                "length_mm": 0.00397930778872772,
                "contact_spacing_mm": 0.05452390598509685,
                "flexible_thickness_mm": 0.0012685730733380748,
                "foot": "flat",
            },
            material={"density_g_cm3": 1.0, "youngs_modulus_gpa": 332.0985148975011},
            weighed={"body_mass_g": 1.2139578050364861e-11, "leg_mass_g": 3.617200557491966e-15},
            drive={"frequency_hz": 5.0, "gamma": 6.0},
            contact={"restitution": 0.0, "friction": 0.0, "law": "newton"},
            plate={"slope_deg": -9.121387832673388},
            scene_legs={"model": "compliant", "damping_ratio": 0.48587444448755834},
            run={"step_us": 30.0, "seconds": 0.3},
        ),
    ),
    "both feet hit at once at friction 100, one by the rounding of the other": (
        None,
        pinned(
            body={"length_mm": 0.74248, "depth_mm": 0.15955, "thickness_mm": 0.0005},
            legs={
                "tilt_deg": -21.352,
                "length_mm": 0.037124,
                "contact_spacing_mm": 0.24013,
                "flexible_thickness_mm": 0.0037124,
                "foot": "round",
            },
            material={"density_g_cm3": 1.0023, "youngs_modulus_gpa": 4.5578},
            weighed={"body_mass_g": 1.6262e-06, "leg_mass_g": 3.0157e-10},
            drive={"frequency_hz": 889.8, "gamma": 1.0},
            contact={"restitution": 1.0, "friction": 100.0, "law": "newton"},
            plate={"slope_deg": 0.0},
            scene_legs={"model": "compliant", "damping_ratio": 0.0},
            run={"step_us": 2.8096, "seconds": 0.010115},
        ),
    ),
}
"""What nightly sweeps found: the outcome (None: any physical one), and the walker."""


LONG = ("a walker of 0.1 mm that flies", "a spinning walker of 10 um, whose flight")
"""Beginnings of those that take more than ten seconds."""


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * name.startswith(LONG)) for name in FOUND]
)
def test_what_the_sweep_once_found_stays_lawful(name):
    outcome, tables = FOUND[name]
    found = check(tables)
    assert found == outcome or (outcome is None and not found.startswith("refused"))


@pytest.mark.nightly
@pytest.mark.parametrize("model", MODELS)
def test_ten_thousand_walkers_are_refused_or_lawful(model):
    sweep(model, wide=True, max_examples=2000, print_blob=True)
