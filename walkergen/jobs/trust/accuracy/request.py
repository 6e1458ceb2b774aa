"""What `accuracy` is asked for."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import BeforeValidator

from walkergen import request
from walkergen.files.progress import Progress
from walkergen.request import Flag

if TYPE_CHECKING:
    from walkergen.files.report import Report

Ladder = Literal["models", "steps", "statistics", "shape"]


class AccuracyRequest(request.Request):
    """Measure what accuracy costs in time: models, steps, statistics, shape."""

    design: request.Walker = request.PAPER
    scene: request.Ground = request.LANE
    tilt: request.Tilt = None
    legs: request.Legs = None
    restitution: request.Restitution = None
    friction: request.Friction = None
    set: request.Settings = {}
    only: Annotated[
        list[Ladder], request.Words, Flag("Comma-separated ladders to measure.", "LADDERS", takes="str | Iterable[str]")
    ] = ["models", "steps", "statistics", "shape"]
    budget: Annotated[
        float,
        BeforeValidator(request.parse_time),
        Flag("Time of all of it: 30s, 5min, 1h; 60s by default.", "TIME", takes="str | float"),
    ] = 60.0
    out: request.Out = None

    def about_s(self) -> float | None:
        """Time that it takes: the budget."""
        return self.budget

    def run(self, progress: Progress) -> "Report":
        """Measure the ladders."""
        from walkergen.files import words
        from walkergen.jobs.trust.accuracy import make
        from walkergen.walker import names

        given = self.inputs()
        scene, design = given.scene(self.scene), given.one(self.design, self.tilt, self.legs)
        only = list(dict.fromkeys(self.only))
        name = f"{design.name}_{names.tilt(design)}_{design.kind}_{scene.name}"
        folder, least = self.out or Path("out") / "accuracy" / name, list[float]()
        report = make.make(make.Job(design, scene, only, self.budget), folder, progress, least.append)
        warnings = [
            f"--budget {words.budget(self.budget)}: too short for {','.join(only)}, which were given "
            f"{words.budget(seconds)}, the least that gives error bars here; --only takes fewer"
            for seconds in least
        ]
        return replace(report, warnings=[*warnings, *report.warnings])
