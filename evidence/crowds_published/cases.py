"""Crowds that are compared with published ones: walkers, dishes, drives and varied settings."""

import math
from typing import Any, NamedTuple

from walkergen.core.scene import Scene
from walkergen.core.walker.design import Design
from walkergen.files import templates

FREQUENCIES = (60.0, 90.0, 150.0)
"""Frequencies of the plate at one peak acceleration, Hz."""

GAMMAS = (1.5, 1.8, 2.4)
"""Peak accelerations over g at one frequency."""

PACKINGS = (0.06, 0.12, 0.25, 0.4)
"""Packings in the periodic square: about the stated 0.12, to what is placed without force."""

RIGHT_TILTS_DEG = (10.0, 0.0, -5.0)
"""Tilts of the right legs, deg, where the left ones lean by 10: the walker spins more and more."""

DISC, SQUARE = "disc:150", "periodic:150"

DRIVE_PACKING = 0.12
"""Packing of the crowds whose drive varies: at 0.25 nine in ten touch at any frequency."""

WALLED_PACKING = 0.35
"""Packing of those that walk or spin between walls."""


SINGLE_RUNS = 16
"""Runs of each walker alone: as many prints."""


class Size(NamedTuple):
    """How much is simulated: runs of each crowd, and their seconds."""

    runs: int
    seconds: float
    discard_seconds: float
    seed: int


FULL = Size(6, 5.0, 3.0, 1)
QUICK = Size(3, 1.5, 1.0, 1)


class Case(NamedTuple):
    """One crowd, or one walker alone, and what varies in its series."""

    series: str
    """frequency, gamma, packing, tapered or lean: a crowd; the same with "alone": one walker."""
    setting: float
    design: Design
    scene: Scene
    """Its dish, packing, drive and runs, in space."""


def crowd_cases(size: Size) -> list[Case]:
    """All crowds: of the paper's walker, of one with a tapered body, and of oblong ones."""
    paper = paper_walker()
    return [
        *(_make_case("frequency", hz, paper, size, DISC, DRIVE_PACKING, hz) for hz in FREQUENCIES),
        *(_make_case("gamma", gamma, paper, size, SQUARE, DRIVE_PACKING, gamma=gamma) for gamma in GAMMAS),
        *(_make_case("packing", share, paper, size, SQUARE, share) for share in PACKINGS),
        *(_make_case("tapered", share, tapered_walker(), size, SQUARE, share) for share in PACKINGS[1:3]),
        *(_make_case("lean", lean, oblong_walker(lean), size, DISC, WALLED_PACKING) for lean in RIGHT_TILTS_DEG),
    ]


def single_cases(size: Size) -> list[Case]:
    """One walker alone for each that a crowd is compared with."""
    paper, many = paper_walker(), size._replace(runs=SINGLE_RUNS)
    return [
        *(_make_case("frequency alone", hz, paper, many, frequency_hz=hz) for hz in FREQUENCIES),
        *(_make_case("lean alone", lean, oblong_walker(lean), many) for lean in RIGHT_TILTS_DEG),
    ]


def _make_case(
    series: str,
    setting: float,
    design: Design,
    size: Size,
    dish: str = "",
    packing: float = 0.0,
    frequency_hz: float = 90.0,
    gamma: float = 1.8,
) -> Case:
    """Case on the template plane-90hz, with the crowd that a dish and a packing ask for."""
    keys: dict[str, Any] = {f"run.{key}": value for key, value in size._asdict().items()}
    keys |= {"drive.frequency_hz": frequency_hz, "drive.gamma": gamma}
    if dish:
        keys |= {"crowd.arena_mm": dish, "crowd.packing": packing}
    scene = templates.load("plane-90hz", "scenes", Scene)
    return Case(series, setting, design, scene.variant(**keys))


def paper_walker() -> Design:
    """Load the paper's walker at its fastest tilt."""
    walker = templates.load("koumakis2016", "walkers", Design)
    return walker.variant(tilt_deg=10.0, kind="flexible")


def tapered_walker() -> Design:
    """Build the paper's walker with a body that narrows in two steps ahead of its front leg."""
    data = paper_walker().model_dump(exclude_unset=True)
    half = [(-14.0, 4.0), (9.0, 4.0), (9.0, 2.75), (11.5, 2.75), (11.5, 1.5), (14.0, 1.5)]
    points = [(x, -y) for x, y in half] + half[::-1]
    body = {"outline": "polygon", "points_mm": [list(point) for point in points], "thickness_mm": 3.0}
    return Design.model_validate(data | {"name": "tapered", "body": body})


def oblong_walker(lean_deg: float) -> Design:
    """Oblong body on the legs of the template rotator, those on its right at another tilt.

    10 deg: it walks; -10 deg: it spins on the spot, as the rotator; all stand level.
    """
    rotator = templates.load("rotator", "walkers", Design)
    data = rotator.model_dump(exclude_unset=True)
    legs: list[dict[str, Any]] = [dict(leg) for leg in data["legs"]]
    tilt = math.radians(rotator.leg_tilt_deg or 0.0)
    for leg in legs:
        if leg.pop("mirrored", False):
            leg["tilt_deg"] = lean_deg
            leg["length_mm"] *= math.cos(tilt) / math.cos(math.radians(lean_deg))
    body = {"length_mm": 28.0, "depth_mm": 16.0, "thickness_mm": 3.0}
    name = f"oblong-{'p' if lean_deg >= 0 else 'm'}{abs(lean_deg):g}"
    return Design.model_validate(data | {"name": name, "body": body, "legs": legs})
