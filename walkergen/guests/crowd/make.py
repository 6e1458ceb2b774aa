"""A crowd by its model: walkers in space, or cards in a plane."""

from walkergen.core import Progress, Runs
from walkergen.core.measure import measure
from walkergen.guests.crowd import statistics
from walkergen.guests.crowd.in_plane import InPlane
from walkergen.guests.crowd.in_space import InSpace
from walkergen.guests.crowd.job import Job, Simulated


def simulate(job: Job, threads: int | None, progress: Progress) -> Simulated:
    """Place and simulate every run, on `threads` threads (None: every core), and measure them.

    Any number of threads gives equal bits. Ctrl-C gives the runs that were done, without any it is
    raised again. Raises as the experiment of its model does.
    """
    crowd: InSpace | InPlane = InPlane(job) if job.model == "flat" else InSpace(job)
    measured = measure(crowd, Runs(job.scene.run.runs), progress, threads)
    progress("measuring", 99, 100)
    films = tuple(map(crowd.film, measured.records))
    runs = () if job.model == "flat" else tuple(measured.records)
    return Simulated(job, films, runs, statistics.measure(films), measured.wall_s)
