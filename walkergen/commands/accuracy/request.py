"""What `accuracy` is asked for."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import BeforeValidator

from walkergen import field_values, request
from walkergen.core.errors import InputError
from walkergen.core.files.progress import Expected, Progress
from walkergen.request import Flag

if TYPE_CHECKING:
    from walkergen.files.report import Report

Ladder = Literal["steps", "statistics", "shape"]
LADDERS: tuple[Ladder, ...] = ("steps", "statistics", "shape")

REMOVED_LADDERS = {"models": "one model of the walker is left; steps has its cost, predict what formulas give"}
"""Ladders that are gone, and what takes their place."""

DEFAULT_BUDGET_S = 60.0
"""Time in which ladders are measured that are asked for without a budget, s."""


def _check_not_removed(name: Any) -> Any:
    """Return the name of a ladder as it is. Raises ValueError for one that is gone."""
    if isinstance(name, str) and name in REMOVED_LADDERS:
        raise ValueError(f"this ladder is gone: {REMOVED_LADDERS[name]}")
    return name


class AccuracyRequest(request.Request):
    """Say what accuracy costs in time, at once; with a budget measure it: steps, statistics, shape."""

    design: request.Walker = request.PAPER_WALKER
    scene: request.Home = None
    tilt: request.Tilt = None
    legs: request.Legs = None
    restitution: request.Restitution = None
    friction: request.Friction = None
    set: request.Settings = {}
    only: Annotated[
        list[Annotated[Ladder, BeforeValidator(_check_not_removed)]] | None,
        request.Words,
        Flag("Comma-separated ladders to measure; all by default.", "LADDERS", takes="str | Iterable[str] | None"),
    ] = None
    budget: Annotated[
        float | None,
        BeforeValidator(field_values.parse_time),
        Flag(
            "Time in which to measure ladders: 30s, 5min, 1h; without, and without --only, none is.",
            "TIME",
            takes="str | float | None",
        ),
    ] = None
    out: request.Out = None

    @property
    def _measures(self) -> bool:
        """Whether ladders are measured."""
        return self.budget is not None or self.only is not None

    @property
    def _budget_s(self) -> float:
        return DEFAULT_BUDGET_S if self.budget is None else self.budget

    def run(self, progress: Progress) -> "Report":
        """Answer, and measure the ladders that are asked for."""
        from walkergen.commands.accuracy import make
        from walkergen.core.files import formatting
        from walkergen.core.walker import names

        given = self.inputs()
        design = given.single_member(self.design, self.tilt, self.legs)
        scene = given.scene(request.choose_scene(self.scene, [design]))
        name = f"{design.name}_{names.tilt_name(design)}_{design.kind}_{scene.name}"
        folder = self.out or Path("out") / "accuracy" / name
        if not self._measures:
            return make.study(design, scene, (), 0.0, folder, progress)
        if scene.drive.kind == "motor":
            raise InputError(
                f"{scene.name}: ladders are measured on a plate, and this walker has a motor: without ‹budget› and "
                "‹only› the answer is scaled"
            )
        only = list(dict.fromkeys(self.only or LADDERS))
        self._expect(lambda: Expected(self._budget_s))
        report = make.study(design, scene, only, self._budget_s, folder, progress)
        least_s = report.facts["least_budget_s"]
        if least_s is None:
            return report
        warning = (
            f"‹budget=›{formatting.format_budget(self._budget_s)}: too short for {','.join(only)}, which took "
            f"{formatting.format_budget(least_s)}, the least that gives error bars here; ‹only› takes fewer"
        )
        return replace(report, warnings=[warning, *report.warnings])
