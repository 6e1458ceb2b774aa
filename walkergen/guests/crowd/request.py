"""Request of the command `crowd`."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from walkergen import film_fields, request
from walkergen.core import Expected, InputError, Progress
from walkergen.inputs import Inputs
from walkergen.request import Flag

if TYPE_CHECKING:
    from walkergen.core import Design, Scene
    from walkergen.files.report import Report
    from walkergen.guests.crowd.population import Population

MAX_FPS = 50
"""Largest number of frames per second of a movie; tracks may have more."""


def _parse_count(value: Any) -> Any:
    """Parse a number of walkers, or numbers by design: 30, "30", "polar-disc:20,rotator:10", {"polar-disc": 20}."""
    from walkergen.guests.crowd import walker_counts

    return value if value is None else walker_counts.parse_walker_count(value)


class CrowdRequest(request.Request):
    """Simulate many walkers that meet in a dish: order, clusters and packing with errors.

    Write a folder with a page, tables, figures and the tracks of every run. The same seed gives the same bytes on any
    number of threads. Each run starts from other places, and the scatter of the runs gives the errors. A card in place
    of a design makes a crowd of thousands in a plane. --card measures one walker for such a crowd, from simulated runs
    or from the tracks of a film.
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
            f"Scene: a template or a TOML file. Default: {request.PLANE_SCENE}; for walkers with a motor "
            f"{request.TABLE_SCENE}.",
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
        """Simulate the crowd, write the input of another program for it, or measure a walker's card."""
        if self.card:
            crowds = "count", "packing", "arena", "model", "rate_hz", "threads", "write_only", "movie"
            self.check_unset("is for a crowd, not for ‹card›", *crowds)
            return self._make_card(progress)
        self.check_unset("is only for ‹card›", "tracks", "fps", "mm_per_px", "unit", "y_down")
        return self._simulate_crowd(progress)

    def _simulate_crowd(self, progress: Progress) -> "Report":
        """Simulate the crowd, or write its input for LAMMPS."""
        from walkergen.guests.crowd import in_space, make, report
        from walkergen.guests.crowd import movie as crowd_movie
        from walkergen.guests.crowd import walker_counts as crowd_members

        if self.movie is not None:
            crowd_movie.check_format(self.movie)
        counts = list(self.count.values()) if isinstance(self.count, dict) else None
        if counts is not None and self.design is not None:
            raise InputError(f"‹count=›{self.count}: already names the designs. Leave ‹design› out.", "count")
        total = sum(counts) if counts else self.count
        given = self.inputs({} if total is None else {"scene.crowd.count": ("count", total)})
        sources = list(self.count) if isinstance(self.count, dict) else [self.design or request.PAPER_WALKER]
        designs = [] if self._is_flat(sources) else self._load_designs(given, sources)
        ground = request.choose_scene(self.scene, designs, request.PLANE_SCENE)
        scene = given.scene(ground, {"scene.run.runs": crowd_members.DEFAULT_RUNS})
        if designs:
            population = in_space.make_population(self, scene, designs, counts)
        else:
            population = self._make_flat_population(given, scene, sources, counts)
        default = Path("out") / report.folder_name(population)
        folder = self.output_folder(default)
        if self.write_only:
            return report.write_inputs(self, population, folder or default)
        if designs:
            self._expect(lambda: self._expected_time(population))
        simulated = make.simulate(self, population, progress)
        result = report.make_report(simulated, folder)
        if folder is not None:
            result = report.write(result, folder, self.pictures, progress)
        if self.movie is not None:
            fps = min(max(round(self.rate_hz), 1), MAX_FPS)
            crowd_movie.write(self.movie, simulated.films[0], result.title, fps, progress)
            result = replace(result, files=[self.movie])
        done, requested = len(simulated.films), scene.run.runs
        if done < requested:
            warnings = [f"interrupted after {done} of {requested} runs", *result.warnings]
            result = replace(result, warnings=warnings, code=130)
        return result

    def _expected_time(self, population: "Population") -> Expected:
        """Estimate the time of a crowd in space from a moment of it."""
        from walkergen.guests.crowd import in_space
        from walkergen.points import run_time

        cpu_seconds = in_space.cpu_seconds(self, population)
        return Expected(run_time.wall_time(cpu_seconds, population.scene.run.runs, self.threads))

    def _is_flat(self, sources: list[Any]) -> bool:
        """Whether a crowd moves in a plane, from cards. Raises InputError for cards next to designs."""
        cards = [_is_card(source) for source in sources]
        if all(cards) and self.model != "space":
            return True
        if any(cards):
            name = sources[cards.index(True)]
            raise InputError(f"{name}: is a card, which only ‹model=›flat supports. Give only designs, or only cards.")
        if self.model == "flat" or self.write_only:
            flag = "‹model=›flat" if self.model == "flat" else "‹write_only›"
            raise InputError(
                f"{flag}: needs a card of {sources[0]}. Run `walkergen crowd {sources[0]} --card`, then give the path "
                "of its card.json as ‹design›.",
                "model",
            )
        return False

    def _load_designs(self, given: Inputs, sources: list[Any]) -> "list[Design]":
        """Load the designs of a crowd. A tilt and a kind of legs are only for a single design."""
        if len(sources) > 1:
            self.check_unset(f"is for one design, not for {len(sources)}", "tilt", "legs")
            return [given.design(source) for source in sources]
        return [given.single_member(sources[0], self.tilt, self.legs)]

    def _make_flat_population(
        self, given: Inputs, scene: "Scene", sources: list[Any], counts: list[int] | None
    ) -> "Population":
        """Return a population of cards. Raises InputError for keys that the cards fix."""
        from walkergen.guests.crowd import in_plane
        from walkergen.guests.crowd.cards import card

        why = "is fixed by the card. Measure another card (‹card›)"
        self.check_unset(why, "tilt", "legs")
        settled = [key for key in given.values if not key.startswith(("scene.crowd.", "scene.run."))]
        given.check_unset([*settled, "scene.run.step_us"], f"{why}, or leave it out.")
        known = [card.read_card(Path(source)) if isinstance(source, (str, Path)) else source for source in sources]
        return in_plane.make_population(self, scene, known, counts)

    def _make_card(self, progress: Progress) -> "Report":
        """Measure a walker alone, from runs or from the tracks of a film, and write its card."""
        from walkergen.core import result_folder
        from walkergen.guests.crowd.cards import make

        source = self.design or request.PAPER_WALKER
        given = self.inputs()
        if _is_card(source):
            raise InputError("‹design›: is a card already. Give it with ‹count›, and leave ‹card› out.", "card")
        walker = given.single_member(source, self.tilt, self.legs)
        scene = given.scene(request.choose_scene(self.scene, [walker], request.PLANE_SCENE))
        inputs: dict[str, Any] = {"design": walker.model_dump(mode="json"), "scene": scene.model_dump(mode="json")}
        if self.tracks is None:
            self.check_unset("is only for ‹tracks›", "fps", "mm_per_px", "unit", "y_down")
            result = make.from_design(scene, walker, progress)
            return make.write(result, inputs, self.out or make.default_folder(walker), self.pictures)
        self.check_unset("is for simulated runs, not for ‹tracks›", "seconds", "runs", "seed")
        units = film_fields.units(self.fps, self.mm_per_px, self.y_down, self.unit)
        folder = result_folder(self.tracks, self.out, "card")
        result = make.from_film(self.tracks, units, scene, walker)
        return make.write(result, {"file": self.tracks.name, **units._asdict(), **inputs}, folder, self.pictures)


def _is_card(source: Any) -> bool:
    """Whether a source is a card or the path of one (.json)."""
    from walkergen.guests.crowd.cards.card import Card

    return isinstance(source, Card) or (isinstance(source, (str, Path)) and str(source).lower().endswith(".json"))
