"""From a scene, a design and its masses to an engine: the kernels a run needs, and no others."""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.scene import GRAVITY, Scene
from walkergen.simulation.drive import Contact, Harmonic, Plate
from walkergen.simulation.effects import Effect, Resolved, resolve
from walkergen.simulation.run import Engine, Outcome
from walkergen.theory.impact import Law
from walkergen.walker.design import Design
from walkergen.walker.mass import MassProperties, as_rigid

Array = npt.NDArray[np.float64]

RIGID_COLUMNS = (
    "x_mm", "y_mm", "pitch_rad", "v_x_mm_s", "v_y_mm_s", "pitch_rate_rad_s", "phase_rad",
    "mode_back", "mode_front",
)  # fmt: skip
LEG_COLUMNS = ("alpha_back_rad", "alpha_front_rad", "rate_back_rad_s", "rate_front_rad_s")


class Plan(NamedTuple):
    """What will be simulated, and the engine that does it."""

    resolved: Resolved
    engine: Engine


def prepare(scene: Scene, design: Design, mass: MassProperties) -> Plan:
    """Resolve the scene's effects and build the engine.

    Raises InputError where the scene's choices contradict each other or the design.
    """
    resolved = resolve(scene, design, mass)
    plate = _plate(scene, resolved)
    slope = math.radians(scene.plate.slope_deg) if resolved.on("plate slope") else None
    if resolved.model == "rigid":
        mass = as_rigid(mass)
    build = _compliant if resolved.model == "compliant" or resolved.method == "step" else _relaxed
    return Plan(resolved, build(scene, design, mass, resolved, plate, slope))


def without(scene: Scene, effect: Effect) -> Scene:
    """The same scene with one effect forced off."""
    key = effect.switch.removeprefix("effects.")
    if key not in ("leg_compliance", "flexible_tensor"):
        effects = scene.effects.model_copy(update={key: False})
        return scene.model_copy(update={"effects": effects})
    # The model and its method follow: without their tensor legs are rigid, not compliant.
    off = {"leg_compliance": False} | {key: False}
    return scene.model_copy(
        update={
            "effects": scene.effects.model_copy(update=off),
            "legs": scene.legs.model_copy(update={"model": "auto"}),
            "run": scene.run.model_copy(update={"method": "auto"}),
        }
    )


def _plate(scene: Scene, resolved: Resolved) -> Plate:
    drive, harmonic = scene.drive, None
    if resolved.on("second harmonic"):
        shift = math.radians(drive.second_harmonic_phase_deg)
        harmonic = Harmonic(drive.second_harmonic_ratio, shift)
    return Plate(drive.amplitude, drive.omega, harmonic)


def _contact(scene: Scene) -> Contact:
    contact = scene.contact
    return Contact(contact.restitution, contact.friction, Law[contact.law.upper()])


def _relaxed(
    scene: Scene,
    design: Design,
    mass: MassProperties,
    resolved: Resolved,
    plate: Plate,
    slope: float | None,
) -> Engine:
    """The event-driven engine of three degrees of freedom: relaxed legs, or rigid."""
    from walkergen.simulation.relaxed import event_driven
    from walkergen.simulation.relaxed import walker as bodies

    walker = bodies.walker_of(design, mass)
    options = bodies.options_for(walker, plate, GRAVITY, slope)

    return Engine(
        model=resolved.model,
        method=resolved.method,
        advance=event_driven.advance,
        arguments=(walker, plate, _contact(scene), options),
        start=lambda clearance, pitch, phase: bodies.new_state(
            walker, plate, clearance, pitch, phase
        ),
        energy=lambda state: bodies.energy(walker, options, state),
        failures={event_driven.TOPPLED: Outcome.TOPPLED, event_driven.FAILED: Outcome.FAILED,
                  event_driven.INSIDE: Outcome.FAILED, event_driven.RUNAWAY: Outcome.RUNAWAY},
        columns=RIGID_COLUMNS,
        period=2.0 * math.pi / plate.omega,
        drop=plate.amplitude,
    )  # fmt: skip


def _compliant(
    scene: Scene,
    design: Design,
    mass: MassProperties,
    resolved: Resolved,
    plate: Plate,
    slope: float | None,
) -> Engine:
    """The engines of the hinged chain: five degrees of freedom, or three without its legs."""
    from walkergen.simulation.compliant import chain, event_driven, legs, time_stepping

    walker = legs.walker_of(
        design,
        mass,
        damping_ratio=scene.legs.damping_ratio,
        spring=scene.legs.spring,
        slope=slope,
    )
    step = resolved.method == "step"
    advance = time_stepping.advance if step else event_driven.advance
    options = time_stepping.Options(1e-6 * scene.run.step_us) if step else event_driven.Options()
    columns = RIGID_COLUMNS if walker.legs is None else RIGID_COLUMNS + LEG_COLUMNS
    return Engine(
        model=resolved.model,
        method=resolved.method,
        advance=advance,
        arguments=(walker, plate, _contact(scene), options),
        start=lambda clearance, pitch, phase: legs.new_state(
            walker, plate, clearance, pitch, phase
        ),
        energy=lambda state: float(chain.energy(walker, state)),
        failures={legs.TOPPLED: Outcome.TOPPLED, legs.FAILED: Outcome.FAILED,
                  legs.FOLDED: Outcome.FOLDED},
        columns=columns,
        period=2.0 * math.pi / plate.omega,
        drop=plate.amplitude,
    )  # fmt: skip
