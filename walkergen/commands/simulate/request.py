"""Request of the command `simulate`."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from pydantic import Field

from walkergen import request
from walkergen.core.files.progress import Progress
from walkergen.request import Flag

if TYPE_CHECKING:
    from walkergen.commands.simulate.report import SimulationReport
    from walkergen.core.scene import Scene
    from walkergen.core.walker.design import Design
    from walkergen.files.report import Report

DEFAULT_UNCERTAIN_S = 4.0
"""Default measured time of a run of --uncertain, s."""

ERROR_CHOSEN_KEYS = ("scene.run.step_us", "scene.run.seconds", "scene.run.runs")
"""Keys whose values --error chooses itself."""


class SimulateRequest(request.Request):
    """Bounce a walker on the plate and measure its speed; on a plane also how it turns.

    Several tilts, or both kinds of legs, make a table. The first simulation compiles the simulator. With --error, the
    number of runs and the time step are chosen for this error of the mean speed at 95 % confidence. A share refers to
    the speed, or to a fifth of the plate's peak speed if the walker is slower. With --effects, effects that hardly
    change the speed of this walker are found by measurement and left out.

    Notes
    -----
    The walker moves in space on elastic feet with the scene's restitution and friction (docs/physics.md section 7).
    The bounds of a speed contain the scatter of the runs and the error of the time step.

    Examples
    --------
    >>> import walkergen as wg
    >>> runs = wg.simulate(tilt=10, seconds=0.1, runs=4)
    >>> runs.speed.low_95 < runs.speed.value < runs.speed.high_95
    True
    """

    design: request.Walker = request.PAPER_WALKER
    scene: request.Home = None
    tilt: request.Tilts = None
    legs: request.Kinds = None
    seconds: request.Seconds = None
    runs: request.Runs = None
    restitution: request.Restitution = None
    friction: request.Friction = None
    gamma: request.Gamma = None
    frequency: request.Frequency = None
    step: request.Step = None
    effects: request.Effects = None
    seed: request.Seed = None
    text: request.Text = None
    mirror: request.Mirror = None
    set: request.Settings = {}
    trajectory: Annotated[
        Path | None,
        request.Target,
        Flag(
            "File for the tracks of all runs: .csv, .npz, .nc for xarray and movement, or .xyz for OVITO.",
            "FILE",
            takes="Name | None",
        ),
    ] = None
    rate_hz: Annotated[float, Field(ge=1e-3, le=1e7), Flag("Samples per second in the file.", "HZ")] = 1000.0
    error: Annotated[str | None, Flag("Error to meet: 5% or 3mm/s.", "ERROR")] = None
    uncertain: request.Uncertain = False
    draws: Annotated[int, Flag("Number of simulated prints for --uncertain, best a power of two.", "N")] = 64
    out: Annotated[Path | None, request.Target, Flag("Folder for --uncertain.", "FOLDER", takes="Name | None")] = None
    of: Annotated[str, Flag("Quantity that --error refers to, by its JSON name.", "NAME")] = "speed_mm_s"
    all: Annotated[bool, Flag("Print all measured quantities.")] = False

    def run(self, progress: Progress) -> "SimulationReport":
        """Simulate the walker. For several walkers, or with `uncertain`, the result is a Report without more fields."""
        from walkergen.commands.simulate import trajectories

        if self.trajectory is not None:
            trajectories.check(self.trajectory)
        given = self.inputs()
        if self.uncertain:
            self.check_unset("cannot be combined with ‹uncertain›", "error", "trajectory", "effects")
            given.check_unset(("scene.run.runs",), "cannot be combined with ‹uncertain›. Remove one of them.")
        else:
            self.check_unset("has an effect only with ‹uncertain›", "out")
        if self.error is not None:
            why = "cannot be combined with ‹error›, which chooses it. Remove one of them."
            given.check_unset(ERROR_CHOSEN_KEYS, why)
        else:
            self.check_unset("has an effect only with ‹error›", "of")
        design = given.design(self.design)
        defaults = {"scene.run.seconds": DEFAULT_UNCERTAIN_S} if self.uncertain else {}
        scene = given.scene(request.choose_scene(self.scene, [design]), defaults)
        members = given.members(design, self.tilt, self.legs, whole=False)
        if len(members) > 1:
            why = f"works for one walker, but ‹tilt› and ‹legs› give {len(members)}"
            self.check_unset(why, "trajectory", "error", "uncertain")
            return self._simulate_several(scene, members, progress)  # type: ignore[return-value]
        if self.uncertain:
            return self._simulate_uncertain(scene, members[0], progress)  # type: ignore[return-value]
        return self._simulate_one(scene, members[0], progress)

    def _simulate_one(self, scene: "Scene", design: "Design", progress: Progress) -> "SimulationReport":
        """Simulate one walker, and write its tracks if a file is given."""
        from walkergen.commands.simulate import make, report, trajectories
        from walkergen.core.tolerance import parse_tolerance
        from walkergen.core.walker import solids
        from walkergen.points import run_time
        from walkergen.points.effect_selection import find_simplest
        from walkergen.points.experiments import Walker

        interval = None if self.trajectory is None else 1.0 / self.rate_hz
        found = find_simplest(Walker(scene, design, solids.mass_of(design)), progress)
        walker = make.make_walker(found.walker.scene, design, found.walker.mass, interval)
        wanted = None if self.error is None else parse_tolerance(self.error)
        if wanted is None:
            self._expect(lambda: run_time.total_time([walker]))
        simulated = make.measure(walker, progress, wanted, self.of, self._expect).include_omissions(found)
        result = report.make_report(simulated, self.all)
        done, wished = simulated.results.summary.runs, simulated.scene.run.runs
        if done < wished:
            lost = [] if self.trajectory is None else [f"{self.trajectory}: not written"]
            warnings = [f"interrupted after {done} of {wished} runs", *lost, *result.warnings]
            return replace(result, warnings=warnings, code=130)
        if self.trajectory is not None:
            trajectories.write(self.trajectory, walker._replace(scene=simulated.scene), simulated.results, progress)
            result = replace(result, files=[self.trajectory])
        return result

    def _simulate_several(self, scene: "Scene", members: "Sequence[Design]", progress: Progress) -> "Report":
        """Simulate walkers one after the other, and return a row for each; after Ctrl-C only for finished ones.

        Raises InputError, before the first simulation, for a walker that cannot be simulated.
        """
        from walkergen.commands.simulate import several_walkers
        from walkergen.points import run_time

        found, rows = several_walkers.prepare_walkers(scene, members, progress), list[several_walkers.Row]()
        self._expect(lambda: run_time.total_time([simple.walker for simple in found]))
        try:
            rows.extend(several_walkers.simulate_each(found, progress))
        except KeyboardInterrupt:
            missing = ", ".join(f"{member.tilt_deg:g} deg {member.kind}" for member in members[len(rows) :])
            result = several_walkers.make_report(rows, scene, found)
            message = f"interrupted after {len(rows)} of {len(found)} walkers; missing: {missing}"
            return replace(result, warnings=[message, *result.warnings], code=130)
        return several_walkers.make_report(rows, scene, found)

    def _simulate_uncertain(self, scene: "Scene", design: "Design", progress: Progress) -> "Report":
        """Simulate prints with random uncertain inputs. Report their speeds, and which input to measure next."""
        from walkergen.commands.simulate import uncertain_prints
        from walkergen.core.walker import solids
        from walkergen.points import effect_selection, run_time
        from walkergen.points import print_ensemble as draws
        from walkergen.points.experiments import Walker

        effect_selection.check_no_accepted_error(
            scene, "applies to a mean speed, but ‹uncertain› reports the scatter of prints"
        )
        walker = Walker(scene, design, solids.mass_of(design)).with_run_settings(runs=self.draws)
        self._expect(lambda: run_time.total_time([walker]))
        measured = draws.measure(scene, design, self.draws, progress)
        result = uncertain_prints.make_report(measured, design, scene.name, self.out)
        if self.out is not None:
            uncertain_prints.write(result, self.out)
        return result
