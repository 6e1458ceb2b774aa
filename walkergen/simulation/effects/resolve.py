"""Model and effects that a scene calls for, decided from dimensionless numbers."""

from collections.abc import Mapping
from typing import Any, NamedTuple

from walkergen.errors import InputError
from walkergen.scene import Scene
from walkergen.simulation.effects import compliance
from walkergen.simulation.effects.acting import RULES, Acting, acting
from walkergen.simulation.effects.effect import Case, Effect, ModelName
from walkergen.walker.design import Design
from walkergen.walker.mass import MassProperties
from walkergen.walker.planar import in_plane


class Resolved(NamedTuple):
    """Model and effects that will be simulated."""

    model: ModelName
    effects: tuple[Effect, ...]
    acting: Acting

    def on(self, name: str) -> bool:
        """True when the effect `name` is simulated. Raises KeyError for an unknown name."""
        return {effect.name: effect.on for effect in self.effects}[name]


def resolve(scene: Scene, design: Design, mass: MassProperties) -> Resolved:
    """Decide the model and every effect.

    Raises InputError where the scene's choices contradict each other or the design.
    """
    _check_room(scene, design)
    case = Case(scene, design, mass, _model(scene, design, mass))
    _check_elastic(scene, design, case.model)
    effects = tuple(rule.judge(case) for rule in RULES)
    on = {effect.name: effect.on for effect in effects}
    acts = acting(case, on.__getitem__)
    return Resolved(case.model, effects, acts)


def without_space(scene: Scene) -> Scene:
    """Scene without the effects that planar models refuse, as far as a switch leaves them out."""
    off = {rule.switch: False for rule in RULES if rule.switch and not rule.planar}
    return _with(scene, off)


def on_still_plate(scene: Scene) -> Scene:
    """Scene without the effects that are no part of a still plate."""
    for rule in RULES:
        if rule.away:
            scene = _with(scene, {**rule.away, rule.switch: None})
    return scene


def _with(scene: Scene, values: Mapping[str, Any]) -> Scene:
    """Scene with values of tables, or of their keys, that were validated before."""
    for key, value in values.items():
        table, _, own = key.partition(".")
        changed = getattr(scene, table).model_copy(update={own: value}) if own else value
        scene = scene.model_copy(update={table: changed})
    return scene


def _check_room(scene: Scene, design: Design) -> None:
    """Raise InputError for a plane that is smaller than the walker."""
    arena, body = scene.arena, design.body
    for key, size, needed, extent in (
        ("length_mm", arena.length_mm, body.length_mm, "long"),
        ("width_mm", arena.width_mm, body.depth_mm, "deep"),
    ):
        if arena.kind == "plane" and size is not None and size < needed:
            raise InputError(
                f"arena.{key} = {size:g}: must be at least {needed:g}, since the walker is "
                f"{needed:g} mm {extent}; take a larger plane, or leave the key out (endless)"
            )


def _model(scene: Scene, design: Design, mass: MassProperties) -> ModelName:
    wanted = scene.legs.model
    if design.rigid and wanted in ("relaxed", "compliant"):
        raise InputError(
            f"{design.name}: {design.kind} legs are rigid; model {wanted} is for flexible legs: "
            "use model 'auto', 'rigid' or 'space', or --legs flexible"
        )
    plane, accepted = scene.arena.kind == "plane", scene.run.accepted_error
    if plane and wanted not in ("auto", "space"):
        raise InputError(
            f"arena.kind = 'plane': the model {wanted} cannot turn on a plane; use legs.model "
            "'auto' or 'space', or arena.kind = 'lane'"
        )
    problem = _out_of_plane(design, mass, wanted)
    if problem and wanted not in ("auto", "space"):
        raise InputError(f"model {wanted}: {problem}: use legs.model 'space'")
    if wanted != "auto":
        return wanted
    motor = scene.drive.kind == "motor"
    if plane or problem or motor or accepted < compliance.PLANAR_ERROR:
        return "space"
    if design.rigid:  # flights from event to event are exact without drag only
        return "space" if scene.effects.air_drag else "rigid"
    return "compliant" if accepted < compliance.RELAXED_ERROR else "relaxed"


def _out_of_plane(design: Design, mass: MassProperties, model: str) -> str:
    """Reason for which a planar model does not know a walker; "" where it does."""
    limbs = in_plane(design, mass).limbs
    if len(limbs) != 2 or limbs[0].along == limbs[1].along:
        places = ", ".join(f"{limb.along:g}" for limb in limbs)
        return f"knows two feet in the plane, one behind the other; those of this walker stand at {places} mm along"
    if model != "rigid" and limbs[0].rigid != limbs[1].rigid:
        rigid, free = sorted(limbs, key=lambda limb: not limb.rigid)
        return f"knows two legs of one kind; of this walker's one is {rigid.kind}, one {free.kind}"
    return ""


def _check_elastic(scene: Scene, design: Design, model: ModelName) -> None:
    """Refuse laws of impact of elastic feet, which have none. Raises InputError."""
    planar = "rigid" if design.rigid else "compliant"
    if model == "space" and scene.contact.law != "poisson":
        raise InputError(
            f"contact.law = {scene.contact.law!r}: elastic feet have a damping in place of a law "
            f"of impact (feet.damping); use legs.model {planar!r} for this law, or leave the law "
            "at 'poisson'"
        )
