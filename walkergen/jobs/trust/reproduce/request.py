"""What `reproduce` is asked for."""

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import BeforeValidator

from walkergen import request
from walkergen.files.key_names import KINDS, TILTS
from walkergen.files.progress import Expected, Progress
from walkergen.request import Flag

if TYPE_CHECKING:
    from walkergen.files.report import Report
    from walkergen.jobs.trust.reproduce.make import Job


class ReproduceRequest(request.Request):
    """Compare the paper's figures and mechanisms with ours (takes minutes)."""

    design: request.Walker = request.PAPER
    scene: request.Ground = request.LANE
    scene_fitted: Annotated[
        Any, Flag("Scene whose contact fits best.", "SCENE", takes="Ground", templates=("scenes",))
    ] = "lane-90hz-fitted"
    tilt: request.Tilts = None
    gamma: Annotated[
        list[float] | None,
        BeforeValidator(partial(request.parse_numbers, low=0.01, high=50.0)),
        Flag("Drives of figure 5: 1.2,1.8,2.4.", "G", takes="str | Iterable[float] | None"),
    ] = None
    seconds: request.Seconds = None
    runs: request.Runs = None
    seed: request.Seed = None
    set: request.Settings = {}
    out: request.Out = None

    def run(self, progress: Progress) -> "Report":
        """Compare."""
        from walkergen.jobs.trust.reproduce import make

        job = self._job()
        self._expect(lambda: Expected(make.expected_s(job)))
        return make.make(job, self.out or Path("out") / "reproduce", progress)

    def _job(self) -> "Job":
        """Job that is asked for. Raises InputError."""
        from walkergen.jobs.trust.reproduce import make

        given = self.inputs()
        given.refuse(
            TILTS + KINDS, "the paper's tilts, or those of --tilt, are compared with both kinds of legs: leave it out"
        )
        own = {"scene.run.seconds": make.SECONDS, "scene.run.runs": make.RUNS}
        return make.Job(
            given.design(self.design),
            given.scene(self.scene, own),
            given.scene(self.scene_fitted, own),
            self.tilt,
            self.gamma,
        )
