"""Model and effects that a scene calls for, decided from dimensionless numbers."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from walkergen.errors import InputError
from walkergen.scene import Arena, Scene, forcing
from walkergen.simulation.effects import idle, rules, turning
from walkergen.simulation.effects.acting import Acting, acting
from walkergen.simulation.effects.effect import Case, Effect, ModelName
from walkergen.walker.design import Design
from walkergen.walker.mass import MassProperties
from walkergen.walker.planar import in_plane


class Resolved(NamedTuple):
    """Model and effects that will be simulated."""

    model: ModelName
    effects: tuple[Effect, ...]
    acting: Acting
    idle: str = ""
    """Line on keys that the scene gives and that have no part in it; "" where all have."""

    def on(self, name: str) -> bool:
        """True when the effect `name` is simulated. Raises KeyError for an unknown name."""
        return _verdicts(self.effects)[name]


def _verdicts(effects: Sequence[Effect]) -> dict[str, bool]:
    """Whether each effect is on, by name; those that the scene does not call for are off."""
    return dict.fromkeys(rules.RARE, False) | {effect.name: effect.on for effect in effects}


def resolve(scene: Scene, design: Design, mass: MassProperties) -> Resolved:
    """Decide the model and every effect.

    Raises InputError where the scene's choices contradict each other or the design.
    """
    _check_room(scene, design)
    case = Case(scene, design, mass, _model(scene, design, mass))
    _check_elastic(scene, design, case.model)
    effects = tuple(rule.judge(case) for rule in rules.of(case))
    on = _verdicts(effects).__getitem__
    _check_headings(case, on(turning.NAME))
    return Resolved(case.model, effects, acting(case, on), idle.line(case, on))


def without_space(scene: Scene) -> Scene:
    """Scene without the effects that planar models refuse, as far as a switch leaves them out."""
    off = {f"effects.{rule.switch}": False for rule in rules.every() if rule.switch and not rule.planar}
    return changed(scene, off)


def in_a_plane(scene: Scene, model: ModelName) -> Scene:
    """Scene with a planar model, in a lane and by its own step, without what only space has."""
    lane = Arena(length_mm=scene.arena.length_mm)
    return changed(
        without_space(scene), {"legs.model": model, "arena": lane, "run.step_us": None, "run.heading_deg": (0.0,)}
    )


def on_still_plate(scene: Scene) -> Scene:
    """Scene without the effects that are no part of a still plate."""
    for rule in rules.every():
        if rule.away:
            scene = changed(scene, {**rule.away, f"effects.{rule.switch}": None})
    return scene


def changed(scene: Scene, values: Mapping[str, Any]) -> Scene:
    """Return the scene with other values of tables or keys, which were validated before.

    The key effects.NAME forces the effect NAME on (True) or off (False), or leaves it to the scene (None).
    """
    for key, value in values.items():
        table, _, own = key.partition(".")
        if table == "effects":
            changed: Any = scene.effects.force(own, value)
        else:
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


def _check_headings(case: Case, turns: bool) -> None:
    """Raise InputError for headings at the start of a walker that does not turn."""
    wanted = case.scene.run.heading_deg
    words = wanted if wanted == "uniform" else list(wanted)
    if wanted == "uniform" or any(wanted):
        if case.model != "space":
            raise InputError(
                f"run.heading_deg = {words}: a walker of the model {case.model!r} runs along x; "
                "use legs.model = 'space', or leave the key out"
            )
        if not turns:
            raise InputError(
                f"run.heading_deg = {words}: {forcing(turning.SWITCH, False)} holds the walker in its plane along x; "
                "leave one of them out"
            )


def _model(scene: Scene, design: Design, mass: MassProperties) -> ModelName:
    wanted = scene.legs.model
    if design.rigid and wanted in ("relaxed", "compliant"):
        raise InputError(
            f"{design.name}: {design.kind} legs are rigid; model {wanted} is for flexible legs: "
            "use model 'auto', 'rigid' or 'space', or --legs flexible"
        )
    if scene.arena.kind == "plane" and wanted not in ("auto", "space"):
        raise InputError(
            f"arena.kind = 'plane': the model {wanted} cannot turn on a plane; use legs.model "
            "'auto' or 'space', or arena.kind = 'lane'"
        )
    if wanted == "auto":
        return "space"
    problem = "" if wanted == "space" else _out_of_plane(design, mass, wanted)
    if problem:
        raise InputError(f"model {wanted}: {problem}: use legs.model 'space'")
    return wanted


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
            f"contact.law = {scene.contact.law!r}: elastic feet have a damper in place of a law "
            f"of impact; use legs.model {planar!r} for this law, or leave the law "
            "at 'poisson'"
        )
