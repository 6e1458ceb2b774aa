"""Choice of how a speed is predicted: statics, the surrogate inside its domain, or a short simulation."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal

from walkergen.core.files.progress import Expected, Progress, silent
from walkergen.core.scene import MIN_RESTITUTION, Scene
from walkergen.core.simulation.effects import walls
from walkergen.core.simulation.effects.effect import Case
from walkergen.core.theory import prediction, surrogate
from walkergen.core.theory.prediction import Prediction
from walkergen.core.theory.speed import Mode
from walkergen.core.theory.surrogate import UnknownError
from walkergen.core.walker.design import Design
from walkergen.core.walker.mass import MassProperties

if TYPE_CHECKING:
    from walkergen.points.point import Record

Model = Literal["best", "known", "theory"]

MIN_TESTED_PUSH = 3.0
"""Push of a motor, in weights, at which MuJoCo ran a walker as fast as the model in space, within 10 %."""


def predict(
    design: Design,
    mass: MassProperties,
    scene: Scene,
    mode: Mode = "coulomb",
    model: Model = "best",
    progress: Progress = silent,
) -> Prediction:
    """Predict the mean speed of one walker from the surrogate or, outside its domain, from a short simulation.

    With model "known" nothing is simulated: a row outside the domain has a stored speed or none. With "theory" it has
    the theory's speed only. Raises InputError if walker and scene contradict each other, as a simulation does, or if a
    simulation would take minutes, and TheoryError for an unknown mode.
    """
    if model == "theory":
        return prediction.make_row(design, mass, scene, mode, None)
    _check_consistency(design, mass, scene)
    try:
        return prediction.predict(design, mass, scene, mode)
    except UnknownError as reason:
        from walkergen.points import short_simulation
        from walkergen.points.experiments import Walker

        walker = Walker(scene, design, mass)
        record = short_simulation.load_stored(walker) or (
            None if model == "known" else short_simulation.simulate_short(walker, reason.near, progress)
        )
        if record is None:
            return prediction.make_row(
                design, mass, scene, mode, None, f"not simulated yet, use predict or ‹simulate›: {reason}"
            )
        left_out = f"; left out: {record['left_out']}" if record["left_out"] else ""
        falls, note = float(record["falls"] or 0.0), f"{_describe_source(record)}, since {reason}{left_out}"
        if scene.drive.kind == "motor":
            note += _push_warning(scene.drive.push_ratio(float(mass.total)))
        speed = short_simulation.speed_from_record(record, scene)
        return prediction.make_row(design, mass, scene, mode, speed, note, falls)


def _check_consistency(design: Design, mass: MassProperties, scene: Scene) -> None:
    """Raise InputError where a simulation does. The compiler loads only outside what the surrogate was trained for."""
    walls.check_arena(Case(scene, design, mass))
    given = scene.run.step_us is not None or scene.contact.restitution < MIN_RESTITUTION
    if given or any(surrogate.domain_violations(scene, design)):
        from walkergen.core.simulation.plan import prepare

        prepare(scene, design, mass)


def expected_time(cases: Sequence[tuple[Design, MassProperties]], scene: Scene) -> Expected:
    """Estimate the clock time to predict walkers outside the surrogate's domain, one after the other."""
    from walkergen.points import short_simulation
    from walkergen.points.experiments import Walker

    seconds = short_simulation.expected_wall_s([Walker(scene, design, mass) for design, mass in cases])
    return Expected(seconds, "‹model=›known leaves these speeds out" if len(cases) > 1 else "")


def _describe_source(record: "Record") -> str:
    """Return words on how the speed in a record was computed: from runs alone, or from the surrogate and runs."""
    return "simulated" if record["by"] == "runs" else "by the surrogate, corrected by a few runs"


def _push_warning(weights: float) -> str:
    """Return a warning on a weak motor; "" for a tested one. `weights`: its peak force over the walker's weight."""
    if weights >= MIN_TESTED_PUSH:
        return ""
    return (
        f"; its motor pushes with {weights:.2g} weights: below {MIN_TESTED_PUSH:g} the law of friction decides, and "
        "MuJoCo's, without a spring along the plate, gave 1.5 to 5 times such speeds"
    )
