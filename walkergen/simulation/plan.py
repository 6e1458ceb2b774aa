"""Plans, made of a scene, a design and its masses: the kernels that a run needs, and no others."""

from typing import Any

from walkergen.scene import Scene
from walkergen.simulation.drive import Drive
from walkergen.simulation.effects import harmonic
from walkergen.simulation.effects.effect import Case
from walkergen.simulation.effects.resolve import Resolved, resolve
from walkergen.simulation.model import Plan
from walkergen.simulation.world import Contact, World
from walkergen.theory.impact import Law
from walkergen.walker.design import Design
from walkergen.walker.limbs import Limb
from walkergen.walker.mass import MassProperties, as_rigid
from walkergen.walker.planar import in_plane


def prepare(scene: Scene, design: Design, mass: MassProperties) -> Plan:
    """Plan of a scene: its effects resolved, the walker put into its world.

    Raises InputError where the scene's choices contradict each other or the design.
    """
    resolved = resolve(scene, design, mass)
    if resolved.model == "rigid":
        mass = as_rigid(mass)
    case = Case(scene, design, mass, resolved.model)
    harmonics = harmonic.parameters(case) if resolved.on(harmonic.NAME) else harmonic.OFF
    motor = scene.drive.kind == "motor"  # an effect on the walker, over a plate that is still
    drive = Drive(0.0 if motor else scene.drive.amplitude, scene.drive.omega, harmonics)
    contacts = () if resolved.model == "space" else _contacts(scene, in_plane(design, mass).limbs)
    model, walker, options = _room(resolved).of(case, resolved, drive)
    return Plan(case, resolved, model, World(walker, drive, contacts, resolved.acting, options))


def _contacts(scene: Scene, limbs: tuple[Limb, ...]) -> tuple[Contact, ...]:
    """Contact of each foot of the plane: its own restitution and friction, or the scene's."""
    contact = scene.contact
    return tuple(
        Contact(
            contact.restitution if limb.restitution is None else limb.restitution,
            contact.friction if limb.friction is None else limb.friction,
            Law[contact.law.upper()].value,
        )
        for limb in limbs
    )


def _room(resolved: Resolved) -> Any:
    """Module that moves the walker of a resolved scene, imported with the first such walker."""
    if resolved.model == "space":
        from walkergen.simulation.space import model as space

        return space
    if resolved.model == "compliant":
        from walkergen.simulation.compliant import model as compliant

        return compliant
    from walkergen.simulation.relaxed import model as relaxed

    return relaxed
