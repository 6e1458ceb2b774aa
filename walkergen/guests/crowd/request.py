"""Request of the command `crowd`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from walkergen import film_fields, request
from walkergen.core import Progress
from walkergen.request import Flag

if TYPE_CHECKING:
    from walkergen.files.report import Report


def _parse_count(value: Any) -> Any:
    """Parse a number of walkers, or numbers by design: 30, "30", "polar-disc:20,rotator:10", {"polar-disc": 20}."""
    from walkergen.guests.crowd import walker_counts

    return value if value is None else walker_counts.parse_walker_count(value)


class CrowdRequest(request.Request):
    """Simulate many walkers that meet in a dish: order, clusters and packing with errors.

    Writes a folder with a page, tables, figures and the tracks of every run. The same seed gives the same bytes on any
    number of threads. Every run starts from other positions, and the scatter of the runs gives the errors. A card
    holds the measured properties of one walker. In place of a design it makes a crowd of thousands in a plane. Measure
    a card with --card, from simulated runs or from the tracks of a film.

    Notes
    -----
    Cards were tested against walkers in space, in a square without walls, up to a packing of 0.3 (docs/physics.md
    section 9). In Python no files are written without a folder in `out`.

    Examples
    --------
    The properties of one walker that a crowd in a plane needs. For a crowd in space give its number, as
    ``wg.crowd("koumakis2016", count=6, arena="disc:90", seconds=0.5, runs=2)``.

    >>> import walkergen as wg
    >>> measured = wg.crowd("koumakis2016", card=True, seconds=1, runs=4, pictures=False)
    >>> measured.table["quantity"][:3].tolist()
    ['speed_mm_s', 'sideways_mm_s', 'velocity_relaxation_s']
    """

    design: Annotated[
        Any,
        Flag(
            "Walker: a template, a TOML file or a card; koumakis2016 by default.",
            "DESIGN",
            takes="Walker | Card | None",
            templates=("walkers",),
            argument=True,
        ),
    ] = None
    scene: Annotated[
        Any,
        request.file_flag(
            "scenes",
            f"Scene: a template or a TOML file. Default: {request.PLANE_SCENE}, or {request.TABLE_SCENE} with a motor.",
            optional=True,
        ),
    ] = None
    count: Annotated[
        int | dict[str, int] | None,
        BeforeValidator(_parse_count),
        Flag(
            "Number of walkers: 30, or for each design: polar-disc:20,rotator:10.",
            "N",
            takes="int | Mapping[str, int] | str | None",
        ),
    ] = None
    packing: Annotated[
        float | None,
        Flag("Area of all bodies over that of the dish, in place of --count.", "SHARE", sets="scene.crowd.packing"),
    ] = None
    arena: Annotated[
        str | None,
        Flag(
            "Dish, mm: disc:120, ring:160,60, rectangle:200x100 or periodic:150.", "DISH", sets="scene.crowd.arena_mm"
        ),
    ] = None
    tilt: request.Tilt = None
    legs: request.Legs = None
    seconds: request.Seconds = None
    runs: Annotated[
        int | None, Flag("Independent runs, whose scatter gives the errors. Default: 4.", "N", sets="scene.run.runs")
    ] = None
    restitution: request.Restitution = None
    friction: request.Friction = None
    gamma: request.Gamma = None
    frequency: request.Frequency = None
    step: request.Step = None
    seed: request.Seed = None
    model: Annotated[
        Literal["space", "flat"] | None,
        Flag("space for designs, or flat for thousands of cards (.json) with LAMMPS.", "MODEL"),
    ] = None
    rate_hz: Annotated[float, Field(ge=1e-3, le=1e5), Flag("Frames per second of the tracks.", "HZ")] = 25.0
    threads: Annotated[int | None, Field(ge=1, le=1024), Flag("Runs in parallel. Default: every core.", "N")] = None
    write_only: Annotated[bool, Flag("Only write the input of LAMMPS for a flat crowd.")] = False
    card: Annotated[bool, Flag("Measure a single walker and write its card.")] = False
    tracks: Annotated[
        Path | None, request.File, Flag("Tracks of a filmed walker, for --card.", "TRACKS.csv", takes="Name | None")
    ] = None
    fps: film_fields.Fps = None
    mm_per_px: film_fields.MmPerPx = None
    unit: film_fields.Unit = None
    y_down: film_fields.YDown = False
    set: request.Settings = {}
    movie: Annotated[
        Path | None,
        request.Target,
        Flag("Film of the first run (.mp4, .gif), or its last frame (.png).", "FILE", takes="Name | None"),
    ] = None
    pictures: request.Pictures = True
    out: request.Out = None

    def run(self, progress: Progress) -> "Report":
        """Simulate the crowd, write its input for LAMMPS, or measure a walker's card. Return the report."""
        report: Report = self.do_work(progress, self._expect)
        return report
