"""Verification: each design, read back from its own TOML, run afresh with another seed."""

import math
import tomllib
from pathlib import Path
from typing import NamedTuple

from walkergen.files import templates
from walkergen.files.config import validate
from walkergen.jobs.make.design import lab, search
from walkergen.jobs.make.design import wish as wishes
from walkergen.jobs.make.design.lab import Bench, Job, Trial
from walkergen.jobs.make.design.search import Search
from walkergen.jobs.make.design.wish import NORMAL_95, Seen
from walkergen.points.point import PREDICTION, Point
from walkergen.points.tolerance import Tolerance
from walkergen.scene import Scene
from walkergen.walker.body import DRAWN
from walkergen.walker.design import Design

SHARPER = 0.5
"""Error of a verification over the one allowed, so that it is not itself what misses."""


class Verified(NamedTuple):
    """A design that was found, and what a run that did not choose it says."""

    values: dict[str, float]
    design: Design
    text: str
    """Its TOML."""
    scene: Scene
    predicted_mm_s: float | None
    chosen: Seen
    """Value of the wish's quantity when it was chosen, as emulated, with the error of its runs."""
    verified: Seen | None
    """The same from the fresh run; None where that tells none."""
    bounds: tuple[float, float] | None
    """Bounds of 95 % of the fresh run, the step's error included; if predicted those of a print.
    """
    slope: Seen | None
    """Change of the speed with friction by the fresh run, mm/s."""
    speed_mm_s: float | None
    alignment: Seen | None
    """Self-alignment by the fresh run, 1/mm; None unless the wish is turning by a slope."""
    runs: int
    """Number of fresh runs; 0 if predicted."""
    warnings: int
    finding: str
    """Worst finding of the printer's checks; "" when there is none."""
    met: bool


def verify(job: Job, bench: Bench, result: Search) -> list[Verified]:
    """Verify the chosen designs."""
    designs = [_written(job, trial, n) for n, trial in enumerate(result.chosen, start=1)]
    texts = [_text(job, design) for design in designs]
    read = [_read(text) for text in texts]
    scenes = [lab.built(job, trial.values)[1] for trial in result.chosen]
    effort = job.efforts.verification if job.simulated else None
    requests: list[Point] = []
    for trial, design, scene in zip(result.chosen, read, scenes, strict=True):
        points = lab.points(job, design, scene, effort, None, lab.fresh_seed(job.seed))
        first = points[0]._replace(wanted=_wanted(job, trial))
        if not job.simulated:
            first = first._replace(keep=(*first.keep, "spread"))
        requests += [first, *points[1:]]
    rows = [trial.values for trial in result.chosen]
    fresh = lab.read(job, bench.at(search.stages(job).rounds, 1.0), rows, requests, effort, "verification")
    return [
        _verified(job, old, expected, new, design, text, scene)
        for old, expected, new, design, text, scene in zip(
            result.chosen, result.expected, fresh, designs, texts, scenes, strict=True
        )
    ]


def _wanted(job: Job, trial: Trial) -> Tolerance | None:
    """Error up to which a verification is run; None where its step alone exceeds what is allowed.

    Of a fast or calm one the error is a share of its own speed.
    """
    if not job.simulated or job.wish.asks_space or trial.seen is None:
        return None
    most = job.wish.allowed(trial.seen.value)
    step = trial.record.get("step_error_mm_s")
    if most <= 0.0 or (isinstance(step, float) and step >= SHARPER * most):
        return None
    return Tolerance(SHARPER * most, False)


def _written(job: Job, trial: Trial, number: int) -> Design:
    """Design as it is written: with a name, and the files that it names found from anywhere."""
    design, _ = lab.built(job, trial.values)
    data = design.model_dump(exclude_unset=True)
    ending = f"-{job.wish.slug}-{number}"
    data["name"] = job.design.name[: 64 - len(ending)] + ending
    data["description"] = f"As {job.design.name}, for a wish: {job.wish.words}"
    for key in ("outline", "mesh"):
        name = data.get("body", {}).get(key)
        if name and name not in DRAWN:
            data["body"] = data["body"] | {key: str(Path(name).resolve())}
    return validate(data, Design, "design")


def _text(job: Job, design: Design) -> str:
    how = "predictions" if job.model == PREDICTION else f"the model {job.model}"
    return templates.dump(design, f"Found by {how} in the scene beside it", every=False)


def _read(text: str) -> Design:
    """Design of a TOML text, as a file with it is read."""
    return validate(Design.located(tomllib.loads(text), Path()), Design, "design", text)


def _verified(job: Job, old: Trial, expected: float, new: Trial, design: Design, text: str, scene: Scene) -> Verified:
    assert old.seen is not None
    record, predicted = new.record, old.record.get("predicted_mm_s", old.record.get("speed_mm_s"))
    speed, runs = record.get("speed_mm_s"), record.get("runs")
    finding, warnings = old.record.get("print_told"), old.record.get("print_warnings")
    verified = Verified(
        old.values,
        design,
        text,
        scene,
        float(predicted) if isinstance(predicted, (int, float)) else None,
        Seen(expected, old.seen.se),
        new.seen,
        wishes.bounds(record, job.wish.of),
        new.slope,
        float(speed) if isinstance(speed, (int, float)) else None,
        wishes.alignment(record),
        runs if isinstance(runs, int) else 0,
        warnings if isinstance(warnings, int) else 0,
        str(finding or ""),
        False,
    )
    return verified._replace(met=new.printable and _met(job, verified, old))


def _met(job: Job, design: Verified, old: Trial) -> bool:
    """True when the fresh value is the one wished within the error.

    Without a target: when it is the one for which the design was chosen, within the error allowed
    or, where that is less, the errors of both runs. Turning by a slope must be the way wished, by
    both of its bounds of 95 %.
    """
    if design.verified is None:
        return False
    value = design.verified.value
    if job.wish.target is not None:
        return abs(value - job.wish.target) <= job.wish.allowed(value)
    before, after = design.chosen, design.verified
    if job.wish.way is not None and not after.above_0:
        return False
    if job.wish.calm:
        if old.slope is None or design.slope is None:
            return False
        before, after = old.slope, design.slope
    apart = abs(after.value - before.value)
    both = NORMAL_95 * math.hypot(before.se, after.se)
    return apart <= max(job.wish.allowed(after.value), both)
