"""Requested film: its view, duration and pace, and the files that show it."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, NamedTuple

from walkergen.core import Design, InputError, Scene
from walkergen.core.walker import names
from walkergen.guests.movie.request import MovieRequest
from walkergen.guests.movie.shot import Shot, format_pace

View = Literal["above", "perspective"]
"""Ways to see a walker."""

GIF_FPS = (1, 2, 4, 5, 10, 20, 25, 50)
"""Frames per second that a GIF can have: it counts in hundredths of a second."""

DEFAULT_PERIODS, DEFAULT_PLAY_S = 6.0, 10.0
"""Default number of the drive's periods that a film in slow motion shows, and its playing time, s."""

DEFAULT_RACE_S = 3.0
"""Default simulated time, s, of a film from above, which plays in real time."""

MIN_FRAMES, MAX_FRAMES, MAX_LANES = 2, 1000, 8  # of a film; MAX_LANES: largest number of its walkers

MIN_VALUE, MAX_VALUE = 1e-3, 1e6
"""Limits of `seconds` (s), `periods` and `slow`."""


class Film(NamedTuple):
    """Requested film, with the walkers and the scene that were read from files."""

    request: MovieRequest
    members: Sequence[Design]
    scene: Scene

    @property
    def view(self) -> View:
        """Requested view. By default "above" on a plane or for several walkers, otherwise "perspective"."""
        default: View = "above" if self.scene.arena.kind == "plane" or len(self.members) > 1 else "perspective"
        return self.request.view or default

    @property
    def seconds(self) -> float:
        """Simulated time to show, s."""
        if self.request.seconds is not None:
            return self.request.seconds
        if self.request.periods is None and self.view == "above":
            return DEFAULT_RACE_S
        return (self.request.periods or DEFAULT_PERIODS) / self.scene.drive.frequency

    @property
    def slow(self) -> float:
        """Seconds of the film for each second of the run."""
        if self.request.slow is not None:
            return self.request.slow
        return 1.0 if self.view == "above" else max(1.0, float(f"{DEFAULT_PLAY_S / self.seconds:.2g}"))

    @property
    def frames(self) -> int:
        """Number of frames, the first at time 0."""
        return 1 + int(self.seconds * self.slow * self.request.fps + 1e-9)


def file_name(film: Film, values: Mapping[str, Any]) -> str:
    """Return the default file name of the GIF: walker, or tilts and kinds of legs, scene, then `values`.

    `values`: values that were set, by dotted key. In the name they are shortened and have only safe letters.
    """
    what = names.part_name(film.members[0]) if len(film.members) == 1 else names.race_name(film.members)
    view = "_perspective" if film.view == "perspective" else ""
    settings = "".join(f"_{key.rpartition('.')[2]}-{value}" for key, value in values.items())
    return f"{what}_{film.scene.name}{view}{re.sub(r'[^A-Za-z0-9_.-]+', '-', settings)[:80]}.gif"


class MovieFiles(NamedTuple):
    """Files that were written, and the runs that they show."""

    gif: Path
    mp4: Path | None
    without_mp4: str
    """Reason why there is no MP4; '' when there is an MP4."""
    frames: int
    shots: Sequence[Shot]


def plan_film(request: MovieRequest, members: Sequence[Design], scene: Scene) -> Film:
    """Return the film that a request describes. Raises InputError for invalid or contradictory options."""
    film, fps = Film(request, members, scene), request.fps
    if fps not in GIF_FPS:
        rates = ", ".join(str(rate) for rate in GIF_FPS)
        raise InputError(f"‹fps=›{fps}: must be one of {rates}. A GIF counts in 1/100 s.")
    for name in ("seconds", "periods", "slow"):
        value = getattr(request, name)
        if value is not None and not MIN_VALUE <= value <= MAX_VALUE:
            raise InputError(f"‹{name}=›{value:g}: must lie in {MIN_VALUE:g}..{MAX_VALUE:g}")
    if len(members) > MAX_LANES:
        raise InputError(f"{len(members)} walkers: a film shows at most {MAX_LANES}. Give fewer with ‹tilt› or ‹legs›.")
    if request.seconds is not None and request.periods is not None:
        raise InputError("‹seconds› and ‹periods›: both set the duration. Leave one of them out.")
    if request.view == "perspective" and len(members) > 1:
        raise InputError(f"‹view=›perspective: shows one walker, not {len(members)}. Use ‹view=›above.")
    if not MIN_FRAMES <= film.frames <= MAX_FRAMES:
        time = "seconds" if request.periods is None else "periods"
        given = [name for name in (time, "slow") if getattr(request, name) is not None] or ["fps"]
        options, plural = " ".join(f"‹{name}=›{getattr(request, name):g}" for name in given), "s" * (film.frames > 1)
        raise InputError(
            f"{options}: the film would have {film.frames:.6g} frame{plural} ({film.seconds:g} s of the run, "
            f"{format_pace(film.slow)}, {fps} a second). It must have {MIN_FRAMES}..{MAX_FRAMES}. "
            f"Change ‹{time}›, ‹slow› or ‹fps›."
        )
    return film
