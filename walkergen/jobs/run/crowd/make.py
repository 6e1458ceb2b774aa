"""A crowd by its model: walkers in space, or cards in a plane."""

from walkergen.files.progress import Progress
from walkergen.jobs.run.crowd import plane
from walkergen.points import crowd_space
from walkergen.points.crowd_job import Job, Simulated


def simulate(job: Job, threads: int | None, progress: Progress) -> Simulated:
    """Place, simulate and measure the runs of a crowd. Raises as its model does."""
    simulate_by = plane.simulate if job.model == "flat" else crowd_space.simulate
    return simulate_by(job, threads, progress)
