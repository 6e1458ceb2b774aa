"""Request of the command `accuracy`."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from pydantic import BeforeValidator

from walkergen import field_values, request
from walkergen.core.errors import InputError
from walkergen.core.files.progress import Expected, Progress
from walkergen.request import Flag

if TYPE_CHECKING:
    from walkergen.files.report import Report


class AccuracyRequest(request.Request):
    """Show what accuracy costs in time; with a budget, measure it: steps, statistics, shape.

    Notes
    -----
    An error is the half-width of a 95 % interval, as a share of the speed. Bias and scatter are added in squares.

    Examples
    --------
    >>> import walkergen as wg
    >>> wg.accuracy(tilt=10)["accuracy"]["error"][-3:].tolist()
    ['5 %', '2 %', '1 %']
    """

    design: request.Walker = request.PAPER_WALKER
    scene: request.Home = None
    tilt: request.Tilt = None
    legs: request.Legs = None
    restitution: request.Restitution = None
    friction: request.Friction = None
    set: request.Settings = {}
    budget: Annotated[
        float | None,
        BeforeValidator(field_values.parse_time),
        Flag(
            "Measure errors and costs of several time steps within this time: 30s, 5min, 1h.",
            "TIME",
            takes="str | float | None",
        ),
    ] = None
    out: request.Out = None

    def run(self, progress: Progress) -> "Report":
        """Answer, and measure within the budget, if any."""
        from walkergen.commands.accuracy import make
        from walkergen.core.files import formatting
        from walkergen.core.walker import names

        given = self.inputs()
        design = given.single_member(self.design, self.tilt, self.legs)
        scene = given.scene(request.choose_scene(self.scene, [design]))
        name = f"{design.name}_{names.tilt_name(design)}_{design.kind}_{scene.name}"
        folder, budget_s = self.out or Path("out") / "accuracy" / name, self.budget
        if budget_s is not None:
            if scene.drive.kind == "motor":
                raise InputError(
                    f"‹budget›: needs a shaken plate, but the scene {scene.name} has a motor. "
                    "Remove it: the times are then estimated from other walkers."
                )
            self._expect(lambda: Expected(budget_s))
        report = make.study(design, scene, budget_s, folder, progress)
        least_s = report.facts["least_budget_s"]
        if least_s is None or budget_s is None:
            return report
        warning = (
            f"‹budget=›{formatting.format_budget(budget_s)}: too short. The measurement took "
            f"{formatting.format_budget(least_s)}, the shortest time that gives error bars here."
        )
        return replace(report, warnings=[warning, *report.warnings])
