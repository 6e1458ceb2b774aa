"""What is run for the checks of crowds in a plane: the walker, its plate, the dish, how much."""

from typing import Any, NamedTuple

from walkergen.core.scene import Scene
from walkergen.core.walker.design import Design
from walkergen.files import templates

WALKER, PLATE = "koumakis2016", "plane-90hz"

PACKINGS, DISH = (0.1, 0.3, 0.5), "periodic:212"
"""Packings of the collective check, 20, 60 and 100 walkers, and their dish. It has no walls: within ten seconds
of a dish that has nearly everybody stands nose to wall, and there is no speed to compare."""

RATE_HZ = 90.0
"""Frames a second of pairs: one in a period of the plate, so that the bouncing is not seen."""

CROWD_RATE_HZ = 30.0
"""Frames a second of crowds: one in three periods of the plate."""


PLANE_RUNS_PER_RUN = 2
"""Runs of pairs and crowds in the plane, which cost little, for each in space."""


class Size(NamedTuple):
    """How much is simulated."""

    alone_runs: int
    """Runs of a walker alone in space, whose card is the plane's input."""
    alone_seconds: float
    pair_runs: int
    """Runs of every meeting in space, each of `pairs`."""
    pairs: int
    crowd_runs: int
    """Runs of each crowd in space."""
    crowd_seconds: float
    crowd_discard_seconds: float
    changed_runs: int
    """Runs in space of the densest crowd, changed in one thing."""
    seed: int


FULL = Size(16, 10.0, 8, 8, 6, 5.0, 3.0, 3, 1)
QUICK = Size(16, 4.0, 4, 5, 3, 3.0, 3.0, 2, 1)


def load_walker() -> Design:
    """Load the paper's walker."""
    return templates.load(WALKER, "walkers", Design)


def make_scene(size: Size, seconds: float, discard_seconds: float, runs: int) -> Scene:
    """Scene of so many runs in space."""
    keys: dict[str, Any] = {
        "run.seconds": seconds,
        "run.discard_seconds": discard_seconds,
        "run.runs": runs,
        "run.seed": size.seed,
        "crowd.arena_mm": DISH,
    }
    return templates.load(PLATE, "scenes", Scene).variant(**keys)
