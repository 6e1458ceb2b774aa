"""Still plates: a scene's feet and surface without its drive, for tests that a person can make."""

import math

from walkergen.core.errors import InputError
from walkergen.core.scene import Scene, still_plate_drive
from walkergen.core.simulation.effects.resolve import without_plate_effects
from walkergen.core.simulation.plan import Plan, prepare
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design

STEP_RATIO = 0.25
"""Time step over that of long runs. A single rebound depends on where within a step a foot lands:
by 0.02 of it with steps of that length, by 0.004 with a quarter (10 deg, drops of 8 to 12 mm)."""


def still_scene(scene: Scene) -> Scene:
    """Scene on an endless level plate at rest, with the contact and feet of `scene`."""
    return without_plate_effects(scene).model_copy(update={"drive": still_plate_drive(scene.drive.frequency)})


def film_scene(scene: Scene) -> Scene:
    """Return the scene of a film on a plate at rest; it begins at the walker's release."""
    run = scene.run.model_copy(update={"discard_seconds": 0.0})
    return still_scene(scene).model_copy(update={"run": run})


def make_plan(scene: Scene, design: Design, finer: float = STEP_RATIO) -> Plan:
    """Plan a walker on the scene's plate at rest; `finer`: its steps over usual ones.

    A step stated by the scene is kept. Raises InputError.
    """
    plan = prepare(still_scene(scene), design, solids.mass_of(design))
    if scene.run.step_us is not None:
        return plan
    return plan.coarser(finer)


def with_contact(scene: Scene, **contact: float) -> Scene:
    """Scene with other values in its [contact]."""
    return scene.model_copy(update={"contact": scene.contact.model_copy(update=contact)})


def check_one_material(design: Design) -> None:
    """Raise InputError where a foot has a restitution of its own."""
    exceptions = [number for number, limb in enumerate(design.limbs, start=1) if limb.restitution is not None]
    if exceptions:
        raise InputError(
            f"{design.name}: legs[{exceptions[0]}].restitution is that foot's own, and a drop finds "
            "one restitution for all feet: drop a walker of one material, without that key"
        )


def describe_test(scene: Scene, design: Design) -> str:
    """Walker and feet of a test, as pages and tables name them."""
    contact = scene.contact
    return (
        f"{design.name}, {design.kind} legs, tilt {design.tilt_deg:g} deg; "
        f"restitution {contact.restitution:g}, friction "
        f"{contact.friction:g}; plate at rest"
    )


def fall_time(height: float, gravity: float) -> float:
    """Compute the time (s) of a fall by `height` (mm) under `gravity` (mm/s^2)."""
    return math.sqrt(2.0 * max(height, 0.0) / gravity)
