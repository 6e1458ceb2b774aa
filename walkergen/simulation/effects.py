"""Which effects a scene calls for, and why: decided from dimensionless numbers.

An effect that is off is absent from the state and from the compiled code (physics.md section 5).
"""

import math
from typing import Literal, NamedTuple

from walkergen.errors import InputError
from walkergen.scene import GRAVITY, Scene
from walkergen.theory.tensors import feet
from walkergen.walker.design import Design
from walkergen.walker.mass import MassProperties

ModelName = Literal["rigid", "relaxed", "compliant"]
MethodName = Literal["event", "step"]

RELAXED_ERROR = 0.5
"""Relative error of the relaxed model's mean speed against the compliant one: of the order of the
speed itself (benchmarks/models.py measures it), so a tolerance below this calls for compliance."""

AIR_DENSITY = 1.2e-6
"""g/mm^3"""


class Effect(NamedTuple):
    """One effect, its size in this scene, and the verdict."""

    name: str
    on: bool
    number: float
    """The dimensionless number that decides."""
    meaning: str
    """What the number is."""
    reason: str
    switch: str
    """The scene's key that forces it; '' when it is part of the model or not available."""


class Resolved(NamedTuple):
    """What will be simulated."""

    model: ModelName
    method: MethodName
    effects: tuple[Effect, ...]

    def on(self, name: str) -> bool:
        """True when the effect of that name is simulated."""
        return any(effect.on for effect in self.effects if effect.name == name)


def resolve(scene: Scene, design: Design, mass: MassProperties) -> Resolved:
    """Decide the model, the method and every effect.

    Raises InputError where the scene's choices contradict each other or the design.
    """
    compliance = _compliance(scene, design, mass)
    tensor = _tensor(scene, design, mass, compliance.on)
    model: ModelName = "compliant" if compliance.on else "relaxed" if tensor.on else "rigid"
    effects = (
        tensor,
        compliance,
        _sticking(scene, mass),
        _sustained(scene),
        _pitch(design),
        _harmonic(scene),
        _slope(scene),
        *_absent(scene, design, mass),
    )
    return Resolved(model, _method(scene, model), effects)


def _method(scene: Scene, model: ModelName) -> MethodName:
    wanted = scene.run.method
    if wanted == "auto":
        return "step" if model == "compliant" else "event"
    if wanted == "step" and model == "relaxed":
        raise InputError(
            "run.method = 'step': the relaxed model's cascades of impacts have no time step; "
            "use method 'event', or model 'compliant'"
        )
    return wanted


def _forced(wanted: bool | None, decided: bool, reason: str) -> tuple[bool, str]:
    if wanted is None:
        return decided, reason
    return wanted, f"forced {'on' if wanted else 'off'}; otherwise: {reason}"


def _compliance(scene: Scene, design: Design, mass: MassProperties) -> Effect:
    model, wanted = scene.legs.model, scene.effects.leg_compliance
    if design.braced and (model in ("relaxed", "compliant") or wanted):
        raise InputError(
            f"{design.name}: braced legs are rigid; model {model} and leg_compliance are for "
            "flexible legs: use model 'auto' or 'rigid', or --legs flexible"
        )
    if model != "auto" and wanted is not None and wanted != (model == "compliant"):
        raise InputError(f"effects.leg_compliance = {wanted} contradicts legs.model = {model!r}")
    if design.braced:
        return Effect("leg compliance", False, 0.0, "legs are braced", "no free leg", "")
    ratio = leg_frequency(design, mass) / scene.drive.frequency
    accepted = scene.run.accepted_error
    reason = f"accepted error {accepted:g} against about {RELAXED_ERROR:g} of the relaxed model"
    if model != "auto":
        reason = f"legs.model = {model!r}"
    decided = model == "compliant" or (model == "auto" and accepted < RELAXED_ERROR)
    on, reason = _forced(wanted, decided, reason)
    meaning = "frequency of a free leg over the drive's"
    return Effect("leg compliance", on, ratio, meaning, reason, "effects.leg_compliance")


def leg_frequency(design: Design, mass: MassProperties) -> float:
    """Natural frequency of a free flexible leg on a held body, Hz (k_t = 3 E I / l)."""
    second_moment = design.body.depth_mm * design.leg_thickness**3 / 12.0
    modulus = 1e9 * design.material.youngs_modulus_gpa
    stiffness = 3.0 * modulus * second_moment / design.legs.length_mm
    inertia = float(mass.j + mass.m * mass.c_A @ mass.c_A)
    return math.sqrt(stiffness / inertia) / (2.0 * math.pi)


def _tensor(scene: Scene, design: Design, mass: MassProperties, compliant: bool) -> Effect:
    wanted, model = scene.effects.flexible_tensor, scene.legs.model
    name, switch = "flexible foot tensor", "effects.flexible_tensor"
    if design.braced:
        if wanted:
            raise InputError(f"{design.name}: effects.flexible_tensor needs flexible legs")
        return Effect(name, False, 0.0, "legs are braced", "the rigid tensor is exact", "")
    if model in ("relaxed", "compliant") and wanted is False:
        raise InputError(f"effects.flexible_tensor = false contradicts legs.model = {model!r}")
    if model == "rigid" and wanted:
        raise InputError("effects.flexible_tensor = true contradicts legs.model = 'rigid'")
    ratio = float(mass.m / mass.M)
    meaning = "mass of a leg over the body's"
    if compliant and wanted is False:
        raise InputError("effects.flexible_tensor = false: compliant legs cannot do without it")
    if compliant:
        return Effect(name, True, ratio, meaning, "part of the chain of body and legs", "")
    reason = "legs are flexible" if model != "rigid" else "legs.model = 'rigid'"
    on, reason = _forced(wanted, model != "rigid", reason)
    return Effect(name, on, ratio, meaning, reason, switch)


def _sticking(scene: Scene, mass: MassProperties) -> Effect:
    friction = scene.contact.friction
    ratios = [
        friction * float(H.xx) / abs(float(H.xy)) if H.xy != 0.0 else math.inf for H in feet(mass)
    ]
    on = max(ratios) >= 1.0
    reason = "friction can hold a foot" if on else "feet always slide on in single impacts"
    meaning = "friction over |H_xy|/H_xx, the larger of both feet"
    number = min(max(ratios), 1e9)  # infinite for an upright leg: written as a large number
    return Effect("sticking in impacts", on, number, meaning, reason, "")


def _sustained(scene: Scene) -> Effect:
    gamma = scene.drive.peak_gamma
    reason = "bounces die out and feet rest on the plate" if gamma < 50 else "rare at this drive"
    return Effect("sustained contact", True, gamma, "peak acceleration over g", reason, "")


def _pitch(design: Design) -> Effect:
    number = design.legs.contact_spacing_mm / design.body.length_mm
    return Effect("pitch", True, number, "contact spacing over body length", "two feet", "")


def _harmonic(scene: Scene) -> Effect:
    ratio, wanted = scene.drive.second_harmonic_ratio, scene.effects.second_harmonic
    reason = "drive.second_harmonic_ratio" + (" > 0" if ratio > 0 else " = 0")
    on, reason = _forced(wanted, ratio > 0, reason)
    meaning = "amplitude over the fundamental's"
    return Effect("second harmonic", on, ratio, meaning, reason, "effects.second_harmonic")


def _slope(scene: Scene) -> Effect:
    slope, wanted = math.radians(scene.plate.slope_deg), scene.effects.plate_slope
    friction = scene.contact.friction
    number = math.tan(slope) / friction if friction > 0 else math.tan(slope)
    reason = "plate.slope_deg" + (" is not 0" if slope != 0 else " = 0")
    on, reason = _forced(wanted, slope != 0, reason)
    return Effect("plate slope", on, number, "slope over friction", reason, "effects.plate_slope")


def _absent(scene: Scene, design: Design, mass: MassProperties) -> tuple[Effect, ...]:
    speed = 3.0 * scene.drive.peak_speed
    front = design.body.depth_mm * (design.body.thickness_mm + design.legs.length_mm)
    friction = max(scene.contact.friction, 1e-3) * float(mass.M) * GRAVITY
    drag = 0.5 * AIR_DENSITY * speed**2 * front / friction
    lane = "the scene is a lane: the walker stays in its plane"
    depth = design.body.depth_mm / design.legs.contact_spacing_mm
    return (
        Effect("yaw and roll", False, depth, "depth over contact spacing", lane, ""),
        Effect("lane walls", False, 0.0, "needs yaw", lane, ""),
        Effect("neighbours", False, 0.0, "other walkers", "one walker alone", ""),
        Effect("air drag", False, drag, "drag over friction", "never at this size", ""),
    )
