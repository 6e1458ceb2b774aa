"""Hard cases of contacts in space: friction, jamming, stiffness from soft to rigid, walls."""

import math
from collections.abc import Iterator

import numpy as np

from walkergen.jobs.trust.selftest.case import SPACE, Case, Check, exactly
from walkergen.jobs.trust.selftest.scenes import STILL, advance, design_of, masses, scene_of, shaken
from walkergen.jobs.trust.selftest.space_scenes import apart, in_space, reflected, survives, thrown, unslowed
from walkergen.simulation.model import Plan
from walkergen.simulation.plan import prepare
from walkergen.simulation.space.state import C_X, C_Z, Q_Z, V_X, V_Y, V_Z
from walkergen.simulation.space.walker import mobility, walker_of
from walkergen.walker.mass import as_rigid

RUN = 0.3
"""Duration, s: some hundred landings of corners."""

BALANCE = 1e-2, "second order in the steps, of landings inside a step; soft feet come to 4e-3"


def _smooth(model: str) -> Iterator[Check]:
    plan = in_space(drive=shaken(1.8), contact={"friction": 0.0, "restitution": 0.5})
    yield unslowed(plan, RUN)


def _rough(model: str) -> Iterator[Check]:
    for tilt, friction in ((10.0, 0.23), (10.0, 0.3), (10.0, 1e3), (20.0, 0.3), (35.0, 1.0)):
        for label in (0.02, 0.5, 1.0):
            plan = in_space(tilt, drive=shaken(1.8), contact={"friction": friction, "restitution": label})
            title = f"{tilt:g} deg, mu = {friction:g}, e = {label:g}"
            yield from survives(plan, thrown(plan), RUN, title, BALANCE)


def _without_slip(model: str) -> Iterator[Check]:
    """Check a landing at a tangential velocity of exactly zero: the limit of slow slips."""
    for friction in (0.1, 0.25, 2.0):
        plan = in_space(drive=STILL, contact={"friction": friction, "restitution": 0.5})
        ends = []
        for slip in (0.0, 1e-9, -1e-9):
            state = plan.start(0.0, 4e-3, 0.0, 2e-3)
            state[[V_X, V_Y]] = slip, -20.0
            advance(plan, state, 2e-3)
            ends.append(state)
        finite = all(bool(np.isfinite(state).all()) for state in ends)
        yield exactly(f"mu = {friction:g}: finite", finite)
        yield Check(
            f"mu = {friction:g}: end without slip against slips of +-1e-9 mm/s, mm",
            max(apart(ends[0], ends[1]), apart(ends[0], ends[2])),
            1e-9,
            "2e-12 mm of way, grown by a landing",
        )


def _lossless(model: str) -> Iterator[Check]:
    """Check that free bounces of undamped smooth feet keep their energy, at the order of a step."""
    changes = []
    for part in (4.0, 8.0, 16.0):
        step = 1e6 * in_space().world.options.step / part
        plan = in_space(
            drive=STILL,
            contact={"friction": 0.0, "restitution": 1.0},
            legs={"damping_ratio": 0.0},
            run={"step_us": step},
        )
        # The mean over drops: each errs with a sign and size of its own
        drops = np.linspace(-1.0, 1.0, 12)
        changes.append(float(np.sqrt(np.mean([_change(plan, drop) ** 2 for drop in drops]))))
    yield Check("change at a quarter of the step, rms of 12 drops", changes[0], 1e-2, "h^2")
    yield Check(
        "change at a sixteenth over that at a quarter",
        changes[2] / changes[0],
        0.2,
        "h^2 would be 1/16; landings inside a step scatter it",
    )


def _change(plan: Plan, place: float) -> float:
    """Relative change of energy over some 20 landings of a drop, `place` -1..1 telling them apart.

    Energies count from the walker that stands.
    """
    state = plan.start(0.5 + 0.1 * place, 4e-3 * place, 0.0, 3e-3 + 1e-3 * place)
    at_rest = plan.energy(plan.start(0.0, 0.0, 0.0))
    before = plan.energy(state) - at_rest
    advance(plan, state, 0.05)
    return (plan.energy(state) - at_rest) / before - 1.0


def _stiffness(model: str) -> Iterator[Check]:
    for ratio in (1e-2, 1e2, 1e4):
        for damping in ("viscous", "hysteretic"):
            plan = in_space(
                drive=shaken(1.8), contact={"restitution": 0.5}, feet={"stiffness_ratio": ratio, "damping": damping}
            )
            title = f"{damping}, stiffness x {ratio:g}"
            seconds = RUN if ratio <= 1e2 else 0.1 * RUN
            yield from survives(plan, thrown(plan), seconds, title, BALANCE)


def _frozen(model: str) -> Iterator[Check]:
    """Check joints without give: inverse mass and motion of the same walker without joints."""
    tilt, feet, modulus = 20.0, 1e-6, 9000.0
    design = design_of("space", tilt)
    stiff = design.model_copy(update={"material": design.material.model_copy(update={"youngs_modulus_gpa": modulus})})
    scene = scene_of(
        "space",
        drive=STILL,
        arena={"kind": "plane"},
        contact={"restitution": 0.5},
        feet={"stiffness_ratio": feet, "damping": "hysteretic"},
        run={"step_us": 1.0},
    )
    loose = prepare(scene, stiff, masses(stiff))
    case = loose.case._replace(mass=as_rigid(masses(stiff)))
    joined, _ = walker_of(case, loose.resolved)
    braced = loose._replace(world=loose.world._replace(walker=joined))
    walker = loose.world.walker
    frozen = mobility(walker._replace(hinge_mobility=0.0 * walker.hinge_mobility))
    whole = mobility(braced.world.walker)
    yield Check(
        "inverse mass at the corners, relative",
        float(np.abs(frozen - whole).max() / np.abs(whole).max()),
        1e-12,
        "rounding",
    )
    ends = []
    for plan in (loose, braced):
        state = plan.start(0.05, 4e-3, 0.0, 2e-3)
        advance(plan, state, 8e-3)
        ends.append(state[C_X : Q_Z + 1])
    yield Check(
        "velocities after five landings against those without joints, mm/s and rad/s",
        float(np.abs(ends[0] - ends[1]).max()),
        0.1,
        "give of the joints, 1/3000 of that of the feet; the walker falls at 31 mm/s",
    )


def _corner_of_lane(model: str) -> Iterator[Check]:
    """Check edges that touch a wall in the step in which feet touch the plate."""
    for label in (0.02, 0.5, 1.0):
        plan = in_space(
            drive=STILL,
            arena={"kind": "lane", "gap_mm": 8.5, "wall_restitution": label},
            contact={"restitution": label},
        )
        state = plan.start(0.0, 0.0, 0.0)
        state[C_Z] = 0.25
        state[[V_X, V_Y, V_Z]] = 10.0, -20.0, 30.0
        other = reflected(state)
        touched = state.copy()
        advance(plan, touched, 2e-5)
        yield exactly(f"e = {label:g}: wall and plate push at once", bool(touched[V_Z] < 30.0 and touched[V_Y] > -20.0))
        title = f"e = {label:g}: both walls, alike, mm"
        direct = state.copy()
        advance(plan, direct, 1e-3)
        advance(plan, other, 1e-3)
        yield Check(title, apart(reflected(direct), other), 1e-9, "rounding, grown by landings")
        yield from survives(plan, state, RUN, f"e = {label:g}", BALANCE)
        half = 0.5 * plan.scene.arena.gap_mm if plan.scene.arena.gap_mm else math.inf
        yield Check(
            f"e = {label:g}: middle of the walker between the walls, mm",
            abs(float(state[C_Z])),
            half - 4.0 + 0.05,
            "half of the play, and what a wall gives",
        )


CASES = [
    Case("space: no friction, no push along the plate", "7", "Newton: momentum along a smooth plate", SPACE, _smooth),
    Case("space: friction, jamming and beyond", "7", "first law: energy book; Coulomb's cone", SPACE, _rough),
    Case("space: landing without slip", "7", "Coulomb: continuous in the slip", SPACE, _without_slip),
    Case(
        "space: undamped smooth feet keep their energy",
        "7",
        "first law: no loss without damper or slip",
        SPACE,
        _lossless,
    ),
    Case(
        "space: feet a hundred times softer and stiffer",
        "7",
        "first law: energy book; static stiffness",
        SPACE,
        _stiffness,
    ),
    Case("space: stiff hinges and twist are braced legs", "7", "rigid bodies: parallel axes", SPACE, _frozen),
    Case("space: wall and plate in one step", "7", "mirror symmetry; first law", SPACE, _corner_of_lane),
]
