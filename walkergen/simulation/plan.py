"""Plans, made of a scene, a design and its masses: the kernels that a run needs, and no others."""

from typing import Any

from walkergen.scene import Scene
from walkergen.simulation.compliant import model as compliant
from walkergen.simulation.drive import Drive
from walkergen.simulation.effects import compliance, harmonic, tensor
from walkergen.simulation.effects.effect import Case, Effect
from walkergen.simulation.effects.resolve import Resolved, resolve
from walkergen.simulation.model import Plan
from walkergen.simulation.relaxed import model as relaxed
from walkergen.simulation.space import model as space
from walkergen.simulation.world import Contact, World
from walkergen.theory.impact import Law
from walkergen.walker.design import Design
from walkergen.walker.mass import MassProperties, as_rigid


def prepare(scene: Scene, design: Design, mass: MassProperties) -> Plan:
    """Plan of a scene: its effects resolved, the walker put into its world.

    Raises InputError where the scene's choices contradict each other or the design.
    """
    resolved = resolve(scene, design, mass)
    if resolved.model == "rigid":
        mass = as_rigid(mass)
    case = Case(scene, design, mass, resolved.model)
    harmonics = harmonic.parameters(case) if resolved.on(harmonic.NAME) else None
    drive = Drive(scene.drive.amplitude, scene.drive.omega, harmonics)
    given = scene.contact
    contact = Contact(given.restitution, given.friction, Law[given.law.upper()])
    model, walker, options = _room(resolved).of(case, resolved, drive)
    return Plan(case, resolved, model, World(walker, drive, contact, resolved.acting, options))


def _room(resolved: Resolved) -> Any:
    """Package that moves the walker of a resolved scene."""
    if resolved.model == "space":
        return space
    return compliant if resolved.model == "compliant" or resolved.method == "step" else relaxed


def without(scene: Scene, effect: Effect) -> Scene:
    """Scene with `effect` off; where that changes the model, the method becomes 'auto'."""
    simpler = {compliance.NAME: "relaxed", tensor.NAME: "rigid"}.get(effect.name)
    if simpler is None:
        off = {effect.switch.removeprefix("effects."): False}
        return scene.model_copy(update={"effects": scene.effects.model_copy(update=off)})
    return scene.model_copy(
        update={
            "legs": scene.legs.model_copy(update={"model": simpler}),
            "run": scene.run.model_copy(update={"method": "auto"}),
        }
    )
