"""Work of the command `crowd`: walkers in space (3D), cards in a plane (2D), or the card of one walker."""

from dataclasses import replace
from pathlib import Path

from walkergen.core import Expect, Expected, Progress, Runs
from walkergen.core.files.progress import range_progress
from walkergen.core.measure import measure
from walkergen.files.report import Report
from walkergen.guests.crowd import in_space, read_population, statistics
from walkergen.guests.crowd.in_plane import InPlane
from walkergen.guests.crowd.in_space import InSpace
from walkergen.guests.crowd.population import Population, Simulated
from walkergen.guests.crowd.request import CrowdRequest
from walkergen.points import run_time

MAX_FPS = 50
"""Largest number of frames per second of a movie; tracks may have more."""

PICTURES_S, RUNS_SHARE = 3.0, 0.8
"""CPU time of the pictures, s: 2.8 to 3.0 were measured for 12 and for 40 walkers, most of it for matplotlib. Share of
the runs in the progress of a crowd whose time is unknown."""


def run(request: CrowdRequest, progress: Progress, expect: Expect) -> Report:
    """Simulate the crowd, write its input for LAMMPS, or measure the card of a walker. Return the report."""
    if request.card:
        from walkergen.guests.crowd.cards import make

        crowds = "count", "packing", "arena", "model", "rate_hz", "threads", "write_only", "movie"
        request.check_unset("is for a crowd, not for ‹card›", *crowds)
        return make.run(request, progress)
    request.check_unset("is only for ‹card›", "tracks", "fps", "mm_per_px", "unit", "y_down")
    return _run_crowd(request, progress, expect)


def _run_crowd(request: CrowdRequest, progress: Progress, expect: Expect) -> Report:
    """Simulate the crowd, or write its input for LAMMPS, and return the report."""
    from walkergen.guests.crowd import movie, report

    if request.movie is not None:
        movie.check_format(request.movie)
    population = read_population.read_population(request)
    default = Path("out") / report.folder_name(population)
    folder = request.output_folder(default)
    if request.write_only:
        return report.write_inputs(request, population, folder or default)
    pictures_s, runs_s = PICTURES_S if folder is not None and request.pictures else 0.0, 0.0

    def find_time() -> Expected:
        """Estimate the time of runs and pictures."""
        nonlocal runs_s
        runs_s = _runs_time(request, population)
        return Expected(runs_s + pictures_s)

    if population.model == "space":
        expect(find_time)
    share = runs_s / (runs_s + pictures_s) if runs_s else RUNS_SHARE
    simulated = simulate(request, population, range_progress(progress, 0.0, share))
    result = report.make_report(simulated, folder)
    if folder is not None:
        result = report.write(result, folder, request.pictures, range_progress(progress, share, 1.0))
    if request.movie is not None:
        fps = min(max(round(request.rate_hz), 1), MAX_FPS)
        movie.write(request.movie, simulated.films[0], result.title, fps, progress)
        result = replace(result, files=[request.movie])
    done, requested = len(simulated.films), population.scene.run.runs
    if done < requested:
        warnings = [f"interrupted after {done} of {requested} runs", *result.warnings]
        result = replace(result, warnings=warnings, code=130)
    return result


def _runs_time(request: CrowdRequest, population: Population) -> float:
    """Estimate the clock time of the runs of a crowd in space, s, from a short piece of a run."""
    cpu_seconds = in_space.cpu_seconds(request, population)
    return run_time.wall_time(cpu_seconds, population.scene.run.runs, request.threads)


def simulate(request: CrowdRequest, population: Population, progress: Progress) -> Simulated:
    """Place and simulate the walkers of every run, on the requested threads, and compute the crowd's statistics.

    `Simulated.runs` is empty for the model in the plane, which keeps only its films. Any number of threads gives equal
    bits. After Ctrl-C, the finished runs are returned. If no run is finished, KeyboardInterrupt is raised again. Raises
    InputError as `InSpace.prepare` or `InPlane.prepare` does.
    """
    flat = population.model == "flat"
    crowd: InSpace | InPlane = (InPlane if flat else InSpace)(request, population)
    measured = measure(crowd, Runs(population.scene.run.runs), progress, request.threads)
    progress("measuring", 100, 100)
    films = tuple(map(crowd.film, measured.records))
    runs = () if flat else tuple(measured.records)
    return Simulated(request, population, films, runs, statistics.measure(films), measured.wall_s)
