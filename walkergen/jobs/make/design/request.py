"""What `design` is asked for."""

from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from walkergen import inputs, request
from walkergen.files.progress import Progress
from walkergen.request import Flag

if TYPE_CHECKING:
    from walkergen.jobs.make.design.report import DesignReport


class DesignRequest(request.Request):
    """Find designs that meet a wish: predictions first, then simulations, then a fresh run."""

    by_position: ClassVar = ()

    speed: Annotated[float | None, Flag("Speed wished, mm/s.", "MM/S")] = None
    fastest: Annotated[bool, Flag("Wish for the fastest.")] = False
    least_sensitive: Annotated[bool, Flag("Wish for the least change of speed with friction.")] = False
    persistence: Annotated[float | None, Flag("Persistence length wished, mm.", "MM")] = None
    turning_radius: Annotated[float | None, Flag("Radius of turning wished, mm.", "MM")] = None
    turn: Annotated[
        Literal["down", "up"] | None, Flag("Wish that a slope turns headings down it, or up, most.", "WAY")
    ] = None
    design: Annotated[
        Any, Flag("Walker to change; name or TOML file.", "DESIGN", "--from", takes="Walker", templates=("walkers",))
    ] = request.PAPER
    vary: Annotated[
        list[str],
        request.Words,
        Flag("Key of the file to vary; repeats.", "KEY=LOW:HIGH", takes="str | Iterable[str]", repeats=True),
    ] = []
    set: request.Settings = {}
    scene: request.Home = None
    printer: request.Machine = request.PRUSA
    model: Annotated[str | None, Flag("prediction, or a model; by default the one of `simulate`.", "MODEL")] = None
    error: Annotated[str, Flag("Error allowed: 5% or 3mm/s.", "ERROR")] = "5%"
    seed: request.Seed = None
    workers: request.Workers = None
    out: Annotated[
        Path | None, request.Target, Flag("Folder; out/design-WISH by default.", "FOLDER", takes="Name | None")
    ] = None
    pictures: request.Pictures = True

    def run(self, progress: Progress) -> "DesignReport":
        """Search, verify and write."""
        from walkergen.jobs.make.design import box, make
        from walkergen.jobs.make.design import wish as wishes
        from walkergen.jobs.make.design.lab import Bench, Job
        from walkergen.points import tolerance
        from walkergen.points.store import Store

        error = tolerance.parse(self.error)
        wish = wishes.of_options(
            self.speed, self.persistence, self.turning_radius, self.turn, self.fastest, self.least_sensitive, error
        )
        given = self.inputs()
        design = given.design(self.design)
        scene = given.scene(request.ground(self.scene, [design]))
        spans = box.of_options(self.vary, design)
        given.refuse(spans.keys, "--vary varies it: leave one of them out")
        model = make.model_of(design, scene, self.model, wish.asks_space)
        if wish.way is not None and "heading_deg" not in scene.run.model_fields_set:
            scene = scene.variant(**{"run.heading_deg": "uniform"})  # so that the slope acts at every angle
        job = Job(wish, design, scene, spans, given.printer(self.printer), model, scene.run.seed)
        make.check(job)
        folder = self.out or Path("out") / f"design-{wish.slug}"
        with closing(Store()) as store, inputs.pool_of(not job.simulated, self.workers) as pool:
            self._expect(lambda: make.time_of(job, 1 if pool is None else pool.workers))
            report = make.make(job, Bench(store, pool, progress), folder, self.pictures)
        if not report.stopped:
            return report
        return replace(report, warnings=[f"{report.stopped}; the nearest are in {folder}/"], code=1)
