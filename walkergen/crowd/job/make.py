"""A crowd by its model: walkers in space, or cards in a plane."""

from walkergen.crowd import in_space as crowd_space
from walkergen.crowd.job import plane
from walkergen.crowd.runs import Job, Simulated
from walkergen.files.progress import Progress


def simulate(job: Job, threads: int | None, progress: Progress) -> Simulated:
    """Place, simulate and measure the runs of a crowd. Raises as its model does."""
    simulate_by = plane.simulate if job.model == "flat" else crowd_space.simulate
    return simulate_by(job, threads, progress)
