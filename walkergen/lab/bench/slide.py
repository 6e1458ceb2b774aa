"""Incline: the angle at which a walker gives way on a plate at rest that is tilted slowly.

The slope grows by steps with time to settle; one after which the walker keeps moving is taken back
and halved. A rigid block slides at tan(angle) = friction, and so does a walker that faces downhill:
legs and moments share the load out among its feet, but once all of them slide their sum counts
(Amontons). One that faces uphill may go sooner where friction exceeds tan(tilt): its upper foot
slips first. Where friction on a leg that leans against its sliding presses the foot on
(docs/physics.md section 7: jamming, from 0.23 at 10 deg), the foot jumps, as chalk does, and the
walker chatters down; where it does not, the other foot holds on to nearly the angle of a block.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from walkergen.files.progress import Progress
from walkergen.lab import resting
from walkergen.lab.inverse import Curve
from walkergen.scene import Scene
from walkergen.simulation import batch, record
from walkergen.simulation.effects import slope
from walkergen.simulation.model import Plan
from walkergen.simulation.space.state import C_X, C_Y, C_Z, Q_0, Q_Z, QUIET
from walkergen.simulation.world import OK, State
from walkergen.walker.design import Design

FRICTIONS = (0.02, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5, 0.7, 1.0)
"""Friction coefficients at which the curve is simulated."""

HEADINGS = {"downhill": 0.0, "uphill": 180.0, "across": 90.0}
"""Ways in which the walker faces, deg."""

STEEPEST, FIRST_STEP, LAST_STEP = 59.0, 8.0, 0.1
"""Steepest slope that is tried; first step of the slope and the least, deg."""

SETTLE_S, RAMP_S, CALM_S, HOLD_S = 0.3, 0.03, 0.01, 0.02
"""Times (s) for the walker to come to rest on the level plate; for a step of the slope, several
periods of its sway on stuck legs; for what that leaves of it; and twice for it to slide."""

PARTS = 30
"""Parts in which a step of the slope is made."""

CREPT_MM, GONE_MM = 1e-3, 0.2
"""Way (mm) in the second hold that counts as sliding, of which a slope 0.06 deg too steep gives
6e-3; and way at which a walker has gone before."""


class Slid(NamedTuple):
    """Angle at which a walker gave way on the incline."""

    angle: float | None
    """Slope, deg; None when it held up to the steepest."""
    toppled: bool
    """Whether it fell over instead of sliding."""


def friction_angle(plan: Plan, heading_deg: float) -> Slid:
    """Angle at which a plan's walker slides or falls over when its plate is tilted slowly."""
    state = plan.start(0.0, 0.0, 0.0)
    half = 0.5 * math.radians(heading_deg)
    q = state[Q_0 : Q_Z + 1].copy()
    # Turned about the vertical: (cos, 0, sin, 0) times the attitude
    c, s = math.cos(half), math.sin(half)
    state[Q_0 : Q_Z + 1] = (c * q[0] - s * q[2], c * q[1] + s * q[3], c * q[2] + s * q[0], c * q[3] - s * q[1])
    held, step, toppled, calm = 0.0, FIRST_STEP, False, _calm(plan)
    _advance(calm, state, 0.0, SETTLE_S)
    while step >= LAST_STEP and held + step <= STEEPEST:
        trial = state.copy()
        if _stays(plan, calm, trial, held, held + step):
            held, state = held + step, trial
        else:
            toppled = _turned(state, trial)
            step *= 0.5
    return Slid(held + step if step < LAST_STEP else None, toppled)


def _calm(plan: Plan) -> Plan:
    """Plan whose legs are damped critically: put down or tilted, its walker does not sway for long.

    Where it stands does not depend on that.
    """
    world = plan.world
    damping = 2.0 * world.walker.stiffness / np.sqrt(world.walker.fast)
    world = world._replace(walker=world.walker._replace(damping=damping))
    return plan._replace(world=plan.model.coarser(world, 1.0))  # with flights for this damping


def _stays(plan: Plan, calm: Plan, state: State, low: float, high: float) -> bool:
    """Tilt the plate from one slope (deg) to another; returns whether the walker stays.

    It comes to rest as `calm`, and is then left to itself.
    """
    start = state[C_X : C_Z + 1].copy()
    for part in range(1, PARTS + 1):
        share = 0.5 - 0.5 * math.cos(math.pi * part / PARTS)
        status = _advance(calm, state, low + share * (high - low), RAMP_S / PARTS)
        if status != OK or np.abs(state[C_X : C_Z + 1] - start).max() > GONE_MM:
            return False
    status = max(_advance(calm, state, high, CALM_S), _advance(plan, state, high, HOLD_S))
    if status != OK:
        return False
    start = state[C_X : C_Z + 1].copy()
    status = _advance(plan, state, high, HOLD_S)
    return status == OK and bool(np.abs(state[C_X : C_Z + 1] - start).max() < CREPT_MM)


def _turned(before: State, after: State) -> bool:
    """Whether a walker that gave way turned about its feet rather than slid."""
    angle = 2.0 * np.linalg.norm(after[Q_0 : Q_Z + 1] - before[Q_0 : Q_Z + 1])
    way = np.linalg.norm(after[C_X : C_Z + 1] - before[C_X : C_Z + 1])
    return bool(angle * before[C_Y] > 0.5 * way)


def _advance(plan: Plan, state: State, slope_deg: float, seconds: float) -> int:
    """Advance a state on a slope; returns a status of `world`."""
    gravity = slope.gravity_of(math.radians(slope_deg))
    world = plan.world._replace(acting=plan.world.acting._replace(gravity=gravity))
    state[QUIET] = 0.0  # it may be at rest no longer
    return int(plan.model.advance(world, state, seconds, record.new(0)))


def edge_angle(plan: Plan, heading_deg: float) -> float:
    """Slope (deg) at which C stands over the lowest feet: a walker that does not slide topples."""
    walker = plan.world.walker
    feet = walker.root + np.column_stack([walker.reach, walker.side])
    heading = math.radians(heading_deg)
    # Body axes are turned about y: its x shows along (cos, -sin), its z along (sin, cos)
    downhill = feet[:, 0] * math.cos(heading) + feet[:, 2] * math.sin(heading)
    return math.degrees(math.atan2(float(downhill.max()), float(-feet[:, 1].mean())))


def first_slip(plan: Plan, tilt: float, friction: float) -> float:
    """Slope (deg) at which the upper foot of a walker that faces uphill slips first.

    Statics of legs (tilt in rad) without weight or length to lose on torsional springs: stuck feet
    make a parallelogram, both legs bend alike, so that T_f - T_b = tan(tilt) (N_f - N_b).
    """
    walker = plan.world.walker
    x = walker.root[:, 0] + walker.reach[:, 0]
    height = -float((walker.root[:, 1] + walker.reach[:, 1]).mean())
    back, front = -float(x[:2].mean()), float(x[2:].mean())
    back, front = (back, front) if back + front > 0.0 else (-front, -back)
    length, lean = back + front, math.tan(tilt)
    carried = friction * back - 0.5 * lean * (back - front)
    lever = 0.5 * length + (friction - lean) * height
    return math.degrees(math.atan2(carried, lever))


class Incline(NamedTuple):
    """Angles at which a walker slides, by friction and by the way in which it faces."""

    frictions: Sequence[float]
    by_heading: dict[str, list[Slid]]
    slips: Sequence[float | None]
    """Slope (deg) at which its upper foot slips first when it faces uphill; None: no foot does, or
    its legs are unlike, for which no closed form is known here."""
    edges: dict[str, float]
    """Slope (deg) at which the walker topples, by the way in which it faces."""

    def curve(self, facing: str) -> Curve | None:
        """Curve from friction to the angle of sliding; None with fewer than two points."""
        points = [
            (friction, slid.angle)
            for friction, slid in zip(self.frictions, self.by_heading[facing], strict=True)
            if slid.angle is not None and not slid.toppled
        ]
        if len(points) < 2:
            return None
        at, seen = np.array(points).T
        return Curve(at, seen, np.zeros(len(at)), np.ones(len(at)))

    def off(self, facing: str) -> float:
        """Largest distance of an angle of sliding from that of a rigid block, deg."""
        curve = self.curve(facing)
        if curve is None:
            return 0.0
        return float(np.abs(curve.seen - np.degrees(np.arctan(curve.at))).max())


def _angles(plans: Sequence[Plan], heading_deg: float) -> list[Slid]:
    """Angles at which the walkers of plans give way, side by side."""
    return batch.every(lambda number, stopped, tell: friction_angle(plans[number], heading_deg), len(plans))


def slide(scene: Scene, design: Design, progress: Progress) -> Incline:
    """Tilt the plate under a walker, at every friction and facing every way that it may run.

    Raises InputError for feet of more than one material.
    """
    resting.one_material(design, "friction")
    plans = [resting.plan_of(resting.with_contact(scene, friction=friction), design, 1.0) for friction in FRICTIONS]
    lean = sum(math.tan(limb.tilt) for limb in design.limbs)
    backward = 180.0 if lean < 0.0 else 0.0  # it runs toward -x
    by_heading: dict[str, list[Slid]] = {}
    for number, (facing, heading) in enumerate(HEADINGS.items()):
        progress(f"facing {facing}", number, len(HEADINGS))
        by_heading[facing] = _angles(plans, heading + backward)
    tilt = design.limbs[0].tilt
    slips = [
        first_slip(plan, tilt, friction)
        if tilt > 0.0 and design.alike and not design.rigid and friction > math.tan(tilt)
        else None
        for plan, friction in zip(plans, FRICTIONS, strict=True)
    ]
    edges = {facing: edge_angle(plans[0], heading + backward) for facing, heading in HEADINGS.items()}
    return Incline(FRICTIONS, by_heading, slips, edges)
