"""Simulation of a crowd: walkers in space, or cards in a plane."""

from typing import TYPE_CHECKING

from walkergen.core import Progress, Runs
from walkergen.core.measure import measure
from walkergen.guests.crowd import statistics
from walkergen.guests.crowd.in_plane import InPlane
from walkergen.guests.crowd.in_space import InSpace
from walkergen.guests.crowd.population import Population, Simulated

if TYPE_CHECKING:
    from walkergen.guests.crowd.request import CrowdRequest


def simulate(request: "CrowdRequest", population: Population, progress: Progress) -> Simulated:
    """Place and simulate every run on the requested threads, and measure them.

    Any number of threads gives equal bits. After Ctrl-C, the runs that were done are returned; without any,
    KeyboardInterrupt is raised again. Raises as the experiment of its model does.
    """
    flat = population.model == "flat"
    crowd: InSpace | InPlane = (InPlane if flat else InSpace)(request, population)
    measured = measure(crowd, Runs(population.scene.run.runs), progress, request.threads)
    progress("measuring", 99, 100)
    films = tuple(map(crowd.film, measured.records))
    runs = () if flat else tuple(measured.records)
    return Simulated(request, population, films, runs, statistics.measure(films), measured.wall_s)
