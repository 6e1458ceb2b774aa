"""Claims against physics engines that share no code with ours; each only if installed."""

import importlib.util
import math
from collections.abc import Iterator
from importlib import metadata

import numpy as np

from evidence.validate.claim import Claim, Effort, Outside
from evidence.validate.ensembles import mean_speed, simulate_runs
from walkergen.core.numerics.quantity import mean
from walkergen.core.scene import Scene
from walkergen.core.simulation.plan import Plan, prepare
from walkergen.core.simulation.space.walker import mobility
from walkergen.core.theory import impact, tensors
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.points import experiments

Pair = tuple[float, float]

MISSING_EXTRA = "{} is not installed here: pip install 'walkergen[rivals]'"

FRICTION = 0.25

RIGID = {"rigid_tips": True}
"""Tips that do not give, near the rigid corners of an engine: only the legs are elastic."""

SPEED_SHARE = 0.1
"""Allowed difference of speeds, as a share: engines judge friction by the slip at a step's end, and with
that rule speeds of legs on springs in a plane were 5 and 8 % higher."""

SLIP_AND_FEET = (
    "The friction law of the row above explains 5 to 8 %. We attribute the rest to the feet: MuJoCo's feet are "
    "damped along the plate too, ours are not. MuJoCo's restitution is measured, not set."
)
REVERSED_FRICTION = (
    "Within an impact our friction reverses with the slip (Routh, Keller). An engine judges it once, by the slip "
    "at the end."
)

BLOCK = (0.833, 55.07)
"""Mass (g) and moment of inertia (g mm^2) of a rigid body that strikes with one foot."""


def is_installed(name: str) -> bool:
    """Return whether a package can be imported."""
    return importlib.util.find_spec(name) is not None


def format_version(name: str) -> str:
    """Version of an installed package; nothing for a missing package."""
    return f" {metadata.version(name)}" if is_installed(name) else ""


def _mujoco_source() -> str:
    return f"MuJoCo{format_version('mujoco')}, our walker without twist of its legs"


def _pymunk_source() -> str:
    return f"pymunk{format_version('pymunk')} (Chipmunk), plastic impacts"


def _make_plan(tilt_deg: float, effort: Effort, restitution: float = 0.02) -> Plan:
    """Plan of a walker without twist, on nearly plastic feet."""
    design = Design().variant(tilt_deg=tilt_deg)
    tables = {
        "drive": {"frequency_hz": 90.0, "gamma": 1.8},
        "contact": {"restitution": restitution, "friction": FRICTION},
        "arena": {"kind": "plane"},
        "effects": {"off": ["leg_twist"]},
        "feet": RIGID,
        "run": {"seconds": 0.5 * effort.seconds, "discard_seconds": 0.5, "runs": effort.runs},
    }
    return prepare(Scene.model_validate(tables), design, solids.mass_of(design))


def inverse_mass(effort: Effort) -> Iterator[Claim]:
    """Claim on the inverse mass at a corner of the walker in space, by MuJoCo's own dynamics."""
    outside = Outside(_mujoco_source(), 1e-9, "rounding of two factorisations")
    if not is_installed("mujoco"):
        yield outside.missing("inverse mass at a corner", "1/g", MISSING_EXTRA.format("MuJoCo"))
        return
    from evidence.validate import mujoco_walker

    for tilt in (10.0, 35.0):
        plan = _make_plan(tilt, effort)
        ours = mobility(plan.world.walker)
        theirs = mujoco_walker.compute_mobility(plan.case.design, plan.case.mass)
        for name, place in (("normal", (0, 0)), ("along", (1, 1)), ("normal to along", (0, 1))):
            quantity = f"inverse mass at a back corner at {tilt:g} deg, {name}"
            yield outside.claim(quantity, "1/g", float(ours[place]), float(theirs[place]))


def plastic_speeds(effort: Effort) -> Iterator[Claim]:
    """Claim on speeds of the walker in space on nearly plastic feet, against rigid corners."""
    tilts, quantity = (10.0, 15.0, 20.0), "speed at {:g} deg, nearly plastic feet"
    reason = "10 %: engines judge friction by the slip at the end of a step"
    outside = Outside(_mujoco_source(), SPEED_SHARE, reason, SLIP_AND_FEET)
    if not is_installed("mujoco"):
        for tilt in tilts:
            yield outside.missing(quantity.format(tilt), "mm/s", MISSING_EXTRA.format("MuJoCo"))
        return
    from evidence.validate import mujoco_walker

    for tilt in tilts:
        plan = _make_plan(tilt, effort)
        case, walker = plan.case, plan.world.walker
        ours = mean_speed(simulate_runs(experiments.Walker(plan.scene, case.design, case.mass)))
        hinge = float(walker.stiffness[0]), float(walker.damping[0])
        seconds, seeds = 0.25 * effort.seconds + 0.5, range(3 if effort.quick else 6)
        runs = mujoco_walker.simulate_speeds(case.design, case.mass, hinge, FRICTION, plan.world.drive, seconds, seeds)
        yield outside.compare(quantity.format(tilt), ours._replace(unit="mm/s"), mean("speed", "mm/s", runs))


def impact_spins(effort: Effort) -> Iterator[Claim]:
    """Claim on single impacts of a rigid body's foot, plastic, against pymunk."""
    cases = (
        ("without friction", 20.0, 0.0),
        ("sliding on", 80.0, 0.1),
        ("stopped and stuck", 20.0, 2.0),
        ("stopped and slid back", 5.0, 0.1),
    )
    reason = "its iteration ends, and turns the body within the step"
    for slip, sliding, friction in cases:
        quantity, outside = f"spin after an impact, foot {slip}", Outside(_pymunk_source(), 1e-8, reason)
        if not is_installed("pymunk"):
            yield outside.missing(quantity, "rad/s", MISSING_EXTRA.format("pymunk"))
            continue
        lever, velocity = (-6.5, -9.0), (sliding, -30.0)
        ours, theirs = (spin(lever, velocity, friction) for spin in (_spin_after, _pymunk_spin_after))
        yield outside._replace(why=REVERSED_FRICTION if "back" in slip else "").claim(quantity, "rad/s", ours, theirs)


def _spin_after(lever: Pair, velocity: Pair, friction: float) -> float:
    M, J = BLOCK
    H = tensors.rigid_tensor(M, J, np.array(lever))
    entries = float(H.xx), float(H.xy), float(H.yy)
    outcome = impact.resolve(entries, velocity, 0.0, friction)
    return (lever[0] * outcome.F_y - lever[1] * outcome.F_x) / J


def _pymunk_spin_after(lever: Pair, velocity: Pair, friction: float) -> float:
    """Spin (rad/s) after one very short step, while a point at `lever` (mm) touches the plate."""
    import pymunk

    M, J = BLOCK
    radius = 1e-3
    space = pymunk.Space()
    space.iterations, space.collision_slop = 2000, 0.0
    plate = pymunk.Segment(space.static_body, (-1e5, -10.0), (1e5, -10.0), 10.0)
    body = pymunk.Body(M, J)
    body.position, body.velocity = (-lever[0], -lever[1] - 1e-7), velocity
    foot = pymunk.Circle(body, radius, (lever[0], lever[1] + radius))
    for shape in (plate, foot):  # pymunk multiplies the two surfaces' values
        shape.elasticity, shape.friction = 0.0, math.sqrt(friction)
    space.add(plate, body, foot)
    space.step(1e-9)
    return float(body.angular_velocity)


TESTS = (impact_spins, inverse_mass, plastic_speeds)
