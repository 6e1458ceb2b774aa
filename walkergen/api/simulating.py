"""Simulated runs, as the command `simulate` makes them."""

from walkergen.api.loading import Ground, Walker, one_of, scene_of
from walkergen.api.predicting import SCENE
from walkergen.errors import InputError
from walkergen.files.progress import Progress, silent
from walkergen.jobs.run.simulate import make, report
from walkergen.jobs.run.simulate.report import SimulationReport
from walkergen.points.tolerance import parse
from walkergen.walker import solids
from walkergen.walker.limbs import Kind


def simulate(
    design: Walker,
    scene: Ground = SCENE,
    *,
    tilt: float | None = None,
    legs: Kind | None = None,
    seconds: float | None = None,
    runs: int | None = None,
    model: str | None = None,
    seed: int | None = None,
    error: str | None = None,
    progress: Progress | None = None,
) -> SimulationReport:
    """Bounce a walker on the plate and measure its speed; in space also how it turns.

    Measured `seconds` of each of `runs` runs, `model` and `seed` are by default the scene's, tilt
    (deg) and legs the design's. The first call of a model compiles it.

    With an `error` of the mean speed, "5%" or "3mm/s" with 95 % confidence, as many runs are made
    as it needs, by a step that is fine enough; seconds and runs are then left out, and
    `.simulated.chosen` says what was taken. A share counts of the speed, or of a fifth of the
    plate's peak speed where the walker is slower. Raises InputError.
    """
    for name, value in {"seconds": seconds, "runs": runs}.items():
        if error is not None and value is not None:
            raise InputError(f"{name}={value!r}: error={error!r} chooses it; leave one of them out")
    values = {"run.seconds": seconds, "run.runs": runs, "legs.model": model, "run.seed": seed}
    keys = {key: value for key, value in values.items() if value is not None}
    ground, member = scene_of(scene).variant(**keys), one_of(design, tilt, legs)
    walker = make.asked(ground, member, solids.mass_of(member))
    wanted = None if error is None else parse(error)
    return report.of(make.measure(walker, progress or silent, wanted))
