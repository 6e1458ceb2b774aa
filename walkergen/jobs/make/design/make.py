"""The job `design`: search, verify, write."""

from pathlib import Path
from typing import Any

from walkergen.errors import InputError
from walkergen.files import output, templates
from walkergen.files.output import Folder
from walkergen.files.progress import Expected
from walkergen.jobs.make.design import lab, limits, report, search, verify
from walkergen.jobs.make.design.lab import FRICTION, Bench, Job
from walkergen.jobs.make.design.report import DesignReport
from walkergen.jobs.make.design.verify import Verified
from walkergen.points import alone, expected
from walkergen.points.kinds import MODELS
from walkergen.points.measure import FIRST_RUNS
from walkergen.points.point import PREDICTION, Point
from walkergen.scene import Scene
from walkergen.simulation.effects.resolve import resolve
from walkergen.walker import solids
from walkergen.walker.design import Design

SLOPE = "scene.plate.slope_deg"
"""Key of what turns headings."""

PROPOSING_S = 1.1
"""CPU time in which the designs of a round are proposed, s."""


def model_of(design: Design, scene: Scene, name: str | None, turns: bool) -> str:
    """Model of a search: the one asked for, else the one that `simulate` takes in the scene.

    `turns` is true for a wish about turning, which needs the model in space on a plane. Raises
    InputError for unknown models, and those that cannot answer the wish.
    """
    if name is not None and name not in MODELS:
        raise InputError(f"--model {name[:30]!r}: must be one of {', '.join(MODELS)}")
    model = name or "auto"
    if name in (None, "auto"):
        if name == "auto":
            scene = _with_model(scene, "auto")
        model = resolve(scene, design, solids.mass_of(design)).model
    elif name != PREDICTION:
        resolve(_with_model(scene, model), design, solids.mass_of(design))
    if turns and (model != "space" or scene.arena.kind != "plane"):
        raise InputError(
            "--persistence, --turning-radius, --turn: walkers turn in the model space on a plane; seen "
            f"model {model}, a {scene.arena.kind}: --model space --scene plane-90hz"
        )
    return model


def _with_model(scene: Scene, model: str) -> Scene:
    return scene.model_copy(update={"legs": scene.legs.model_copy(update={"model": model})})


def check(job: Job) -> None:
    """Refuse wishes that the job cannot answer. Raises InputError."""
    if job.wish.calm and not job.scene.contact.friction and FRICTION not in job.box.keys:
        raise InputError("--least-sensitive: contact.friction is 0: there is none to vary")
    if job.wish.way is not None and not job.scene.plate.slope_deg and SLOPE not in job.box.keys:
        raise InputError(f"--turn {job.wish.way}: {SLOPE} = 0: a level plate turns no heading: --set {SLOPE}=2")
    for key in ("scene.run.", "scene.legs.model", "name", "description", "family."):
        if wrong := [varied for varied in job.box.keys if varied.startswith(key)]:
            raise InputError(f"--vary {wrong[0]}: is no property of a walker or a plate")


def make(job: Job, bench: Bench, folder: Path, pictures: bool = True) -> DesignReport:
    """Search for designs, verify them and write them into a folder, last of all.

    Raises InputError when nothing can be made within the ranges.
    """
    check(job)
    result = search.search(job, bench, search.survey(job, bench))
    designs = verify.verify(job, bench, result)
    stopped = "" if any(design.met for design in designs) else limits.stopped(job, result, designs)
    written = report.of(job, result, designs, stopped, folder)
    with Folder(folder) as target:
        written.write(target, pictures)
        for number, design in enumerate(designs, start=1):
            target.write(f"design-{number}.toml", design.text.encode())
            target.write(f"scene-{number}.toml", _scene(job, design, number).encode())
        target.finish(_facts(job))
    return written


def time_of(job: Job, workers: int) -> Expected:
    """Time of a search, by the cost of the design that it begins with."""
    count = lab.parts(job, job.efforts.spread)
    surveyed = search.sample_size(job)
    work = [(Point(job.design, job.scene, False, ("speed", "printability"), None, job.printer), surveyed)]
    if job.simulated:
        spread, close, verified = job.efforts
        few = verified._replace(runs=FIRST_RUNS)  # which mostly have the error
        counts = search.FIRST + search.NEAR, search.WANTED * search.USUAL_ROUNDS, search.WANTED
        efforts = zip((spread, close, few), counts, strict=True)
        work += [
            (lab.points(job, job.design, job.scene, effort, None, job.seed)[0], count * trials)
            for effort, trials in efforts
        ]
    tried_s = sum(expected.by_clock(alone.cost(point), trials, workers) for point, trials in work)
    return Expected(tried_s + search.USUAL_ROUNDS * PROPOSING_S)


def _scene(job: Job, design: Verified, number: int) -> str:
    """Scene of a design, with the model that it was verified with."""
    scene = _with_model(design.scene, job.model) if job.simulated else design.scene
    data = scene.model_dump(exclude_unset=True)
    data["description"] = f"As {scene.name}, of a design for {job.wish.words}"[:2000]
    return templates.dump(Scene.model_validate(data), f"Scene of design-{number}.toml", every=False)


def _facts(job: Job) -> dict[str, Any]:
    """What was asked, for the manifest."""
    return {
        **output.versions(),
        "wish": job.wish.words,
        "error": str(job.wish.error),
        "model": job.model,
        "seed": job.seed,
        "vary": {span.key: [span.low, span.high] for span in job.box.spans},
        "design": job.design.model_dump(mode="json"),
        "scene": job.scene.model_dump(mode="json"),
        "printer": job.printer.model_dump(mode="json"),
    }
