"""Request of the command `sweep`."""

from collections.abc import Iterable, Mapping
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from pydantic import BeforeValidator, Field

from walkergen import field_values, inputs, request
from walkergen.core import Expected, InputError, Progress
from walkergen.request import Flag

if TYPE_CHECKING:
    from walkergen.guests.sweep.axes import Axis, Span
    from walkergen.guests.sweep.cost import Cost
    from walkergen.guests.sweep.report import SweepReport
    from walkergen.guests.sweep.sweep_points import SweepPoints

MAX_LOCAL_POINTS = 512
"""Number of predicted points that take less time here than processes take to start."""


class SweepRequest(request.Request):
    """Map speeds over any keys of design and scene: a table and pictures, resumed when stopped.

    All combinations of the values are evaluated, the last key fastest; every one of them has every sample. Keys that
    begin with scene.crowd. map what crowds do. Points that were evaluated before are not evaluated again.
    """

    by_position: ClassVar = ("design", "scene", "set")

    design: Annotated[
        Any,
        request.file_flag("walkers", "Walker: a template, TOML file, drawing or mesh.", optional=True, argument=True),
    ] = None
    set: Annotated[
        Any,
        BeforeValidator(lambda value: value if isinstance(value, Mapping) else field_values.parse_texts(value)),
        Flag(
            "Values of any key: KEY=5, KEY=5,10,15, KEY=FIRST:LAST:STEP, or, with --sample, "
            "KEY=LOW:HIGH. Keys of the scene begin with scene.",
            "KEY=VALUES",
            takes="Mapping[str, Any]",
            repeats=True,
        ),
    ] = {}
    scene: Annotated[Any, request.file_flag("scenes", "Scene: a template or a TOML file.", optional=True)] = None
    model: Annotated[
        str | None, Flag("prediction (default), space to simulate, or crowd for keys of crowds.", "MODEL")
    ] = None
    error: Annotated[str | None, Flag("Error of each simulated speed: 5% or 3mm/s.", "ERROR")] = None
    sample: Annotated[str | None, Flag("Samples of LOW:HIGH: sobol:256, latin:99.", "METHOD:N")] = None
    seed: Annotated[int, Field(ge=0), Flag("Seed of the samples.", "N")] = 1
    keep: Annotated[
        list[str] | None,
        request.Words,
        Flag(
            "Numbers to keep: speed,spread,persistence,impacts,masses,printability. For crowds: "
            "polar_order,largest_cluster and other statistics.",
            "GROUPS",
            takes="str | Iterable[str] | None",
        ),
    ] = None
    printer: Annotated[Any, request.file_flag("printers", "Printer of --keep printability.", optional=True)] = None
    file: Annotated[
        Path | None, request.File, Flag("Read all of this from a sweep.toml.", "FILE", takes="Name | None")
    ] = None
    wish: Annotated[
        float | None, Field(ge=-1e6, le=1e6), Flag("Desired speed: list the points nearest to it first.", "MM/S")
    ] = None
    workers: request.Workers = None
    dask: Annotated[str | None, Flag("Use a dask cluster: tcp://scheduler:8786.", "ADDRESS")] = None
    yes: Annotated[bool, Flag("Start without confirmation, however long it takes.")] = False
    out: request.Out = None
    pictures: request.Pictures = True

    def run(self, progress: Progress) -> "SweepReport":
        """Evaluate all points, in this process or in several; Python functions use several if `workers` is given."""
        from walkergen.guests.sweep import cost, make
        from walkergen.points.point import PREDICTION
        from walkergen.points.store import Store

        sweep = self._make_points()
        folder = self.output_folder(Path("out") / "sweeps" / sweep.folder_name)
        few = not self._shell or (sweep.model == PREDICTION and sweep.space.points <= MAX_LOCAL_POINTS)
        with closing(Store()) as store, inputs.open_pool(few, self.workers, self.dask) as pool:
            workers = 1 if pool is None else pool.workers

            def estimate() -> cost.Cost | None:
                """Estimate the cost of this sweep."""
                return cost.estimate(sweep, store, workers)

            if not self.yes and sweep.space.points > cost.MAX_UNCONFIRMED_POINTS:
                raise InputError(
                    f"{cost.format_cost(estimate(), sweep.space.points)}. Give ‹yes› to start, or use fewer points.",
                    "yes",
                )
            self._expect(lambda: _to_expected(estimate()))
            if folder is None:
                return make.evaluate_all(self, sweep, store, pool, progress)
            return make.make_sweep(self, sweep, folder, store, pool, progress)

    @property
    def keeps_rows(self) -> bool:
        """Whether the report holds every row, as Python functions return it and a desired speed needs it."""
        return not self._shell or self.wish is not None

    def _make_points(self) -> "SweepPoints":
        """Return the points of the sweep that is given here, or in a file. Raises InputError."""
        from walkergen.core import parse_tolerance
        from walkergen.guests.sweep import axes, sweep_setup

        with_speed = self.wish is not None

        if self.file is not None:
            self.check_unset("is set by ‹file›", "design", "set", "scene", "printer", "error", "sample")
            return sweep_setup.from_file(self.file, with_speed)
        pairs = self.set.items() if isinstance(self.set, Mapping) else ()
        entries = [_parse_entry(key, values) for key, values in pairs] or [axes.parse(text) for text in self.set]
        space, constants = sweep_setup.make_space(entries, self.sample, self.seed)
        wanted = None if self.error is None else parse_tolerance(self.error)
        sources = self.design, self.scene, self.printer
        return sweep_setup.make_points(
            sources, Path(), space, constants, self.model, wanted, self.keep, "‹set›", with_speed
        )


def _to_expected(cost: "Cost | None") -> Expected | None:
    """Return the expected time of a known cost."""
    return None if cost is None else Expected(cost.seconds)


def _parse_entry(key: str, values: Any) -> "Axis | Span":
    """Parse the axis or span of a key from a text, one value, several, or an array. Raises InputError."""
    from walkergen.guests.sweep import axes

    if isinstance(values, str):
        return axes.from_text(key, values, f"‹set› {key}={values[:60]!r}")
    if isinstance(values, Mapping):
        raise InputError(f"{key}: is a table. Give a list of values.", key)
    listed = list(values) if isinstance(values, Iterable) else [values]
    return axes.make_axis(key, [value.item() if hasattr(value, "item") else value for value in listed], key)
