"""Real plates: they also move horizontally, shake more in one place than in another, and rock.

All motion has the drive's frequency, phi its phase. Along x the plate is at q A sin(phi + p), and likewise to the left.
Its height has a gradient: A (1 + g . r) sin(phi), as over a shaker with one stiffer side. It rocks about the start by
A (k . r) cos(phi), which leaves its middle in place. Feet feel height, slope and velocity of the plate under
them; walls, lid and bumps move with it. Limits: small slopes, so that walls and lid stay at their places; an axis of
rocking below the surface adds motion along the plate. Only in 3D simulations.
"""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from walkergen.core.errors import InputError
from walkergen.core.numerics.kernels import lean
from walkergen.core.scene import Scene
from walkergen.core.simulation.effects.effect import Case, Effect, Rule, decide_from_key, describe_number

NAMES = ALONG, GRADIENT, ROCKING = "motion along the plate", "plate gradient", "plate rocking"

KEYS = ALONG_KEY, GRADIENT_KEY, ROCKING_KEY = (
    "plate.horizontal_ratio",
    "plate.gradient_percent_per_mm",
    "plate.rocking_percent_per_mm",
)
STILL, USUAL = [0.0, 0.0], [0.1, 0.0]
"""Numbers of these keys, along x and to the left, of a plate without the effect, and of a usual one."""

MAX_AMPLITUDE_CHANGE = 1.0
"""Largest relative change of the amplitude within the reach of a walker: no plate has a larger one."""

MAX_SPEED_RATIO = 2.0
"""Largest speed of walkers over the plate's peak speed that their reach is computed with; few are faster."""

Four = tuple[float, float, float, float]


class Sway(NamedTuple):
    """A plate that moves along itself and tilts, by four numbers: displacements along x and z (mm) and slopes."""

    moves: bool
    """Whether it does either."""
    with_sine: Four
    """Amplitudes of what goes with the sine of the drive's phase, as the plate's height does,"""
    with_cosine: Four
    """and a quarter of a period ahead of it."""


OFF = Sway(False, (0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0))
"""A plate that moves up and down equally everywhere."""


def decide_along(case: Case) -> Effect:
    """Return the effect "motion along the plate". Number: peak horizontal acceleration over the largest by friction."""
    on, reason = _decide_from_key(case, ALONG_KEY, "plate_along")
    shaken = math.hypot(*case.scene.plate.horizontal_ratio) * case.equivalent_drive.peak_gamma
    meaning = "peak acceleration along the plate over what friction holds"
    return Effect(ALONG, on, shaken / max(case.scene.contact.friction, 1e-9), meaning, reason, "plate_along")


def decide_gradient(case: Case) -> Effect:
    """Return the effect "plate gradient". Number: relative change of the drive's amplitude between the feet."""
    return _decide_linear(case, GRADIENT, GRADIENT_KEY, "plate_gradient", "change of the amplitude between the feet")


def decide_rocking(case: Case) -> Effect:
    """Return the effect "plate rocking". Number: rocking amplitude between the feet over the drive's."""
    return _decide_linear(case, ROCKING, ROCKING_KEY, "plate_rocking", "rocking between the feet over the amplitude")


def _decide_linear(case: Case, name: str, key: str, switch: str, meaning: str) -> Effect:
    """Return the effect `name`, which grows with distance from the start. Raises InputError if it is too large.

    `key`: of the scene. `switch`: name of the effect in effects.on and effects.off. `meaning`: of the effect's number.
    """
    on, reason = _decide_from_key(case, key, switch)
    per_mm, path = 0.01 * math.hypot(*case.scene.value(key)), _max_distance(case)
    if on and per_mm * path > MAX_AMPLITUDE_CHANGE:
        raise InputError(
            f"{describe_number(case.scene, key)}: a walker may get {path:.3g} mm far, where the amplitude would change "
            f"by {100.0 * per_mm * path:.3g} %. At most {100.0 * MAX_AMPLITUDE_CHANGE:g} % are allowed. Limit the "
            "ground (arena.length_mm, on a plane arena.width_mm too), or lower run.seconds."
        )
    return Effect(name, on, per_mm * case.design.foot_span, meaning, reason, switch)


def _max_distance(case: Case) -> float:
    """Return the largest distance (mm) that walkers may reach from the start: the ground's ends, or the fastest run."""
    arena, run = case.scene.arena, case.scene.run
    distance = MAX_SPEED_RATIO * case.equivalent_drive.peak_speed * (run.seconds + run.discard_seconds)
    ends = [math.inf if size is None else 0.5 * size for size in (arena.length_mm, arena.width_mm)]
    return min(distance, ends[0] if arena.kind == "lane" else math.hypot(*ends))


def _decide_from_key(case: Case, key: str, switch: str) -> tuple[bool, str]:
    """Return what `effect.decide_from_key` returns. Raises InputError if on for a walker with a motor."""
    on, reason = decide_from_key(case, key, switch)
    if on and case.scene.drive.kind == "motor":
        raise InputError(
            f"{describe_number(case.scene, key)}: the plate under a motor is still. Leave the key out, or take "
            "a shaken plate (drive.kind = 'plate')"
        )
    return on, reason


RULES = (
    Rule(decide_along, "plate_along", absent_values={ALONG_KEY: STILL}, typical_values={ALONG_KEY: USUAL}),
    Rule(decide_gradient, "plate_gradient", absent_values={GRADIENT_KEY: STILL}, typical_values={GRADIENT_KEY: USUAL}),
    Rule(decide_rocking, "plate_rocking", absent_values={ROCKING_KEY: STILL}, typical_values={ROCKING_KEY: USUAL}),
)


def check_still_plate(scene: Scene, reason: str) -> None:
    """Raise InputError, which states the `reason`, if the scene's plate sways."""
    for key in KEYS:
        if not scene.is_zero(key):
            raise InputError(f"{describe_number(scene, key)}: {reason}. Leave the key out, or simulate one walker")


def parameters(case: Case, on: Mapping[str, bool]) -> Sway:
    """Return the sway of the plate. `on`: by name, whether each effect is simulated."""
    if not any(on[name] for name in NAMES):
        return OFF
    plate, size = case.scene.plate, case.scene.drive.amplitude
    sines, cosines = [0.0] * 4, [0.0] * 4
    if on[ALONG]:
        along, left = plate.horizontal_ratio
        for axis, (ratio, phase) in enumerate(zip((along, -left), plate.horizontal_phase_deg, strict=True)):
            sines[axis] = size * ratio * math.cos(math.radians(phase))
            cosines[axis] = size * ratio * math.sin(math.radians(phase))
    if on[GRADIENT]:
        sines[2:] = _slopes(size, plate.gradient_percent_per_mm)
    if on[ROCKING]:
        cosines[2:] = _slopes(size, plate.rocking_percent_per_mm)
    return Sway(True, (sines[0], sines[1], sines[2], sines[3]), (cosines[0], cosines[1], cosines[2], cosines[3]))


def _slopes(size: float, percent: Sequence[float]) -> tuple[float, float]:
    """Return slopes along x and z of a plate of amplitude `size` (mm), which grows by `percent` per mm of (x, left)."""
    along, left = percent
    return size * 0.01 * along, -(size * 0.01 * left)


@lean
def moves(sway):
    """Return whether the plate moves horizontally, or by different heights at different points."""
    return sway.moves


@lean
def displacements_and_slopes(sway, phase):
    """Return the plate's displacements (mm) along x and z, then its slopes along both, at a drive's phase (rad)."""
    p, q, s, c = sway.with_sine, sway.with_cosine, math.sin(phase), math.cos(phase)
    return s * p[0] + c * q[0], s * p[1] + c * q[1], s * p[2] + c * q[2], s * p[3] + c * q[3]


@lean
def motion(sway, omega, phase, x, z):
    """Compute velocity (mm/s), then acceleration (mm/s^2), along x, y, z of the plate's point (x, z), mm.

    Both are relative to the vertical motion of the plate's middle. `omega` (rad/s) and `phase` (rad) are the drive's.
    """
    p, q, s, c = sway.with_sine, sway.with_cosine, math.sin(phase), math.cos(phase)
    v_x, v_z, t_x, t_z = c * p[0] - s * q[0], c * p[1] - s * q[1], c * p[2] - s * q[2], c * p[3] - s * q[3]
    a_x, a_z, b_x, b_z = displacements_and_slopes(sway, phase)
    square = -omega * omega
    return (
        omega * v_x,
        omega * (t_x * x + t_z * z),
        omega * v_z,
        square * a_x,
        square * (b_x * x + b_z * z),
        square * a_z,
    )


@lean
def bounds(sway):
    """Return the largest horizontal displacement (mm) and the largest slope of the plate."""
    p, q = sway.with_sine, sway.with_cosine
    return (
        math.sqrt(p[0] * p[0] + p[1] * p[1] + q[0] * q[0] + q[1] * q[1]),
        math.sqrt(p[2] * p[2] + p[3] * p[3] + q[2] * q[2] + q[3] * q[3]),
    )
