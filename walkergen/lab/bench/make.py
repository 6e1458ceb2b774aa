"""Bench tests: each simulated, inverted where a number was measured, and written to a folder."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from walkergen.analysis.inverse import Measured
from walkergen.errors import InputError
from walkergen.files.output import Folder
from walkergen.files.progress import Progress
from walkergen.lab.bench import drop, pluck, slide, tables
from walkergen.lab.bench.report import BenchReport
from walkergen.scene import Scene
from walkergen.walker import names
from walkergen.walker.design import Design

if TYPE_CHECKING:
    from matplotlib.figure import Figure

HIGHEST_MM, STEEPEST_DEG, MOST_DROPS = 1000.0, 20.0, 1000
"""Largest height of a drop, deviation of its first turn, and number of drops from the hand."""


MOST = {"drop": 1.0, "slide": 89.0, "pluck": 1e6}
"""Largest number that each test may measure: rebound, slope (deg), frequency (Hz)."""

MOST_DECREMENT = 100.0


class Test(NamedTuple):
    """What every bench test needs: walker, feet, a number measured on a real bench, pictures."""

    design: Design
    scene: Scene
    measured: Measured | None
    pictures: bool


class Drop(NamedTuple):
    """Choices of a drop: height (mm), deviation of pitch and roll from the hand (deg), drops."""

    height: float = 10.0
    turn_deg: float = 1.0
    drops: int = 24


def folder_of(bench: str, design: Design) -> Path:
    """Folder of a test by default: below out/ and the walker's name."""
    return Path("out") / design.name / f"bench_{bench}_{names.part(design)}"


def dropped(test: Test, how: Drop, folder: Path, progress: Progress) -> BenchReport:
    """Drop a walker; writes drop.csv and a table for all else that counts, figure and page.

    Raises InputError before anything is simulated.
    """
    _check("--height-mm", how.height, 0.01, HIGHEST_MM)
    _check("--roll-deg", how.turn_deg, 0.0, STEEPEST_DEG)
    _check("--drops", how.drops, 2, MOST_DROPS)
    result = drop.drop(test.scene, test.design, *how, progress)
    report = tables.of_drop(result, test.scene, test.design, how.height, how.turn_deg, test.measured)

    def draw() -> "Figure":
        from walkergen.lab.bench import figures

        return figures.of_drop(result, report.title, how.turn_deg, test.measured)

    return _written(report, test, how._asdict(), draw, folder)


def slid(test: Test, folder: Path, progress: Progress) -> BenchReport:
    """Tilt the plate under a walker; writes slide.csv, figure and page."""
    result = slide.slide(test.scene, test.design, progress)
    report = tables.of_slide(result, test.scene, test.design, test.measured)

    def draw() -> "Figure":
        from walkergen.lab.bench import figures

        return figures.of_slide(result, report.title, test.measured)

    return _written(report, test, {}, draw, folder)


def plucked(test: Test, decrement: Measured | None, folder: Path, progress: Progress) -> BenchReport:
    """Pluck a leg; writes pluck.csv, moduli.csv, damping.csv, figure and page.

    Raises InputError for legs that do not swing.
    """
    progress("plucking", 0, 1)
    result = pluck.pluck(test.scene, test.design)
    report = tables.of_pluck(result, test.scene, test.design, test.measured, decrement)

    def draw() -> "Figure":
        from walkergen.lab.bench import figures

        curve = pluck.by_modulus(test.design, result.leg_mass)
        return figures.of_pluck(result, report.title, test.measured, curve)

    decrement_facts = None if decrement is None else decrement._asdict()
    return _written(report, test, {"decrement": decrement_facts}, draw, folder)


def _check(flag: str, value: float, low: float, high: float) -> None:
    if not low <= value <= high:
        raise InputError(f"{flag} {value:g}: must lie in {low:g}..{high:g}")


def _written(
    report: BenchReport, test: Test, choices: dict[str, Any], draw: "Callable[[], Figure]", folder: Path
) -> BenchReport:
    """Report with its figure and folder, once it is written there with what was asked."""
    report = replace(report, figures={report.name: draw}, folder=folder)
    with Folder(folder) as target:
        report.write(target, test.pictures)
        target.finish(
            {
                "bench": report.name,
                "design": test.design.model_dump(mode="json"),
                "scene": test.scene.model_dump(mode="json"),
                "measured": None if test.measured is None else test.measured._asdict(),
                **choices,
            }
        )
    return report
