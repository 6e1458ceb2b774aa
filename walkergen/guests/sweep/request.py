"""Request of the command `sweep`."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from pydantic import BeforeValidator, Field

from walkergen import field_values, request
from walkergen.core import Progress
from walkergen.request import Flag

if TYPE_CHECKING:
    from walkergen.guests.sweep.report import SweepReport


class SweepRequest(request.Request):
    """Map speeds over any keys of design and scene: a table and pictures, resumed when stopped.

    All combinations of the values are evaluated, the last key fastest. With --sample, each of them is combined with
    every sample. Keys that begin with scene.crowd. map crowds. Points that were evaluated before are not evaluated
    again.

    Notes
    -----
    In Python no files are written without a folder in `out`.

    Examples
    --------
    >>> import walkergen as wg
    >>> wg.sweep(set={"legs.tilt_deg": [5, 10]}).table["speed_mm_s"].round()
    array([31., 51.])
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
            "Numbers to keep: speed, spread, persistence, impacts, masses, printability. For crowds: "
            "polar_order,largest_cluster and other statistics.",
            "GROUPS",
            takes="str | Iterable[str] | None",
        ),
    ] = None
    printer: Annotated[Any, request.file_flag("printers", "Printer of --keep printability.", optional=True)] = None
    file: Annotated[
        Path | None,
        request.File,
        Flag("Read keys, samples and settings from a sweep.toml.", "FILE", takes="Name | None"),
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
        """Evaluate all points. A call from Python uses only this process, unless `workers` or `dask` is given."""
        report: SweepReport = self.do_work(progress, self._expect)
        return report

    @property
    def from_shell(self) -> bool:
        """Whether the request comes from the command line."""
        return self._shell

    @property
    def keeps_rows(self) -> bool:
        """Whether the report contains every row. Python functions return all rows, and `wish` needs them."""
        return not self._shell or self.wish is not None
