"""Everything that is printed of an ensemble, by its name, with its standard error."""

from walkergen.analysis import motion
from walkergen.analysis.tracks import of_places
from walkergen.scene import Scene
from walkergen.simulation import observables, resolution
from walkergen.simulation.experiments import Results
from walkergen.simulation.run import ENDED_WELL

MOTION = {"motion.rotational_diffusion_rad2_s": "rotational_diffusion", "motion.diffusivity_mm2_s": "diffusivity"}
"""Names of the statistics of motion that are studied: how headings turn, how walkers spread."""

NAMES = (*observables.NAMES, *MOTION)
"""Names of all observables, as `simulate --json` has them."""


def values(point: Results, scene: Scene) -> dict[str, tuple[float | None, float | None]]:
    """Values and standard errors of a point's observables; without those that it refuses."""
    summary = point.summary
    errors = {**summary.errors, observables.SPEED: summary.speed_se_mm_s}
    by_name: dict[str, tuple[float | None, float | None]] = {
        name: (value, errors[name]) for name, value in resolution.values(summary).items()
    }
    return by_name | _motion(point, scene.arena.kind == "lane")


def _motion(point: Results, lane: bool) -> dict[str, tuple[float | None, float | None]]:
    """How the walkers of a point turn and spread, where their runs are long enough to tell."""
    good = [result for result in point.results if result.outcome in ENDED_WELL]
    if not good or len(good[0].places) < 4:
        return {}
    tracks = of_places([result.places for result in good], good[0].block_s, lane)
    estimates = motion.analyse(tracks).estimates
    named = ((name, estimates[key]) for name, key in MOTION.items())
    return {name: (estimate.value, estimate.se) for name, estimate in named if estimate.value is not None}
