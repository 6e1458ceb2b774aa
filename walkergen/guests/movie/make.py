"""Movies: one walker in slow motion, or several running; from above, in perspective."""

import re
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from walkergen.core import (
    Design,
    Expect,
    Expected,
    InputError,
    Progress,
    Release,
    Scene,
    ignore_estimate,
    mass_of,
    prepare,
)
from walkergen.core.files import output
from walkergen.core.simulation.effects import walls
from walkergen.core.simulation.effects.effect import Case
from walkergen.core.walker import names
from walkergen.guests.movie.shot import Shot, Title, format_pace, make_shot
from walkergen.points import poses

if TYPE_CHECKING:
    from walkergen.files.animation import Draw
    from walkergen.guests.movie.request import MovieRequest

View = Literal["above", "perspective"]
"""Ways to see a walker."""

GIF_FPS = (1, 2, 4, 5, 10, 20, 25, 50)
"""Frames per second that a GIF can have: it counts in hundredths of a second."""

DEFAULT_PERIODS, DEFAULT_PLAY_S = 6.0, 10.0
"""Slow motion by default: periods of the drive that are shown, and seconds to watch."""

DEFAULT_RACE_S = 3.0
"""Length of a race by default, s, in real time."""

AT_REST_UM = 1e-6
"""Amplitude below which a plate is reported to be at rest, um."""

MIN_FRAMES, MAX_FRAMES, MAX_LANES = 2, 1000, 8

SLOW_POSES_PER_FRAME = 8
"""Poses for each frame in slow motion: the curves show what happens between frames."""

ABOVE_POSES_PER_FRAME = 4
"""Poses for each frame from above: the trail bends between frames."""

WRITE_TIME_RATIO = 1.5
"""Time of a frame, written, over that of drawing it."""

HOLD_S = 1.5
"""Duration of the last frame before the GIF starts again, s."""

MIN_VALUE, MAX_VALUE = 1e-3, 1e6
"""Limits of times (s), of periods and of slowing down."""


class Film(NamedTuple):
    """Requested film, with the walkers and the scene that were read from files."""

    request: "MovieRequest"
    members: Sequence[Design]
    scene: Scene
    release: Release | None = None
    """Release of the walker; None: as in the ensemble's first run."""

    @property
    def view(self) -> View:
        """View that was requested, or the default of the scene and of the number of walkers."""
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
    """Return the default name of the GIF: the walker, or tilts and kinds of legs, then the scene.

    Then come values of dotted keys that were set, in letters that are safe, as far as a name goes.
    """
    what = names.part_name(film.members[0]) if len(film.members) == 1 else names.race_name(film.members)
    seen = "_perspective" if film.view == "perspective" else ""
    settings = "".join(f"_{key.rpartition('.')[2]}-{value}" for key, value in values.items())
    return f"{what}_{film.scene.name}{seen}{re.sub(r'[^A-Za-z0-9_.-]+', '-', settings)[:80]}.gif"


class Made(NamedTuple):
    """Files that were written, and the runs that they show."""

    gif: Path
    mp4: Path | None
    without_mp4: str
    """Reason why there is no MP4; '' when there is an MP4."""
    frames: int
    shots: Sequence[Shot]


def plan_film(request: "MovieRequest", members: Sequence[Design], scene: Scene, release: Release | None = None) -> Film:
    """Return the film of these walkers in this scene. Raises InputError for what cannot be shown."""
    film, fps = Film(request, members, scene, release), request.fps
    if fps not in GIF_FPS:
        rates = ", ".join(str(rate) for rate in GIF_FPS)
        raise InputError(f"‹fps=›{fps}: must be one of {rates}. A GIF counts in 1/100 s.")
    for name in ("seconds", "periods", "slow"):
        value = getattr(request, name)
        if value is not None and not MIN_VALUE <= value <= MAX_VALUE:
            raise InputError(f"‹{name}=›{value:g}: must lie in {MIN_VALUE:g}..{MAX_VALUE:g}")
    if len(members) > MAX_LANES:
        raise InputError(f"{len(members)} walkers: a film shows at most {MAX_LANES}. Choose fewer tilts or legs.")
    if request.seconds is not None and request.periods is not None:
        raise InputError("‹seconds› and ‹periods›: both set the duration. Leave one of them out.")
    if request.view == "perspective" and len(members) > 1:
        raise InputError(f"‹view=›perspective: shows one walker, not {len(members)}. Use ‹view=›above.")
    if not MIN_FRAMES <= film.frames <= MAX_FRAMES:
        raise InputError(
            f"{film.frames:.6g} frames ({film.seconds:g} s of the run, {format_pace(film.slow)}, {fps} a second): "
            f"must lie in {MIN_FRAMES}..{MAX_FRAMES}. Change ‹seconds›, ‹slow› or ‹fps›."
        )
    return film


def make_movie(
    film: Film, path: Path, progress: Progress, named: bool = True, expect: Expect = ignore_estimate
) -> Made:
    """Simulate and film; write `path` (a GIF) and, with ffmpeg, an MP4 next to it.

    Both files are written in full at the end. A file from another source is overwritten only by the GIF, and only if
    the user `named` it. Raises InputError when a run ends before two frames.
    """
    from walkergen.files import animation
    from walkergen.guests.movie import impacts

    draw, frames, shots = _prepare_drawing(film, progress)
    colours = impacts.movie_colours(max(len(design.limbs) for design in film.members))
    expect(lambda: _expected_time(draw, frames))
    encoded = animation.encode(draw, frames, film.request.fps, HOLD_S, colours, progress)
    mp4 = path.with_suffix(".mp4") if encoded.mp4 is not None else None
    with output.Folder(path.parent, "") as target:
        if named:
            output.write(path, encoded.gif)
        else:
            target.write(path.name, encoded.gif)
        if mp4 is not None and encoded.mp4 is not None:
            target.write(mp4.name, encoded.mp4)
    return Made(path, mp4, encoded.without_mp4, frames, shots)


def _expected_time(draw: "Draw", frames: int) -> Expected:
    """Estimate the time of drawing all frames from that of one, and of writing them."""
    draw(0)
    started = time.thread_time()
    draw(frames // 2)
    return Expected((time.thread_time() - started) * WRITE_TIME_RATIO * frames)


def _prepare_drawing(film: Film, progress: Progress) -> tuple["Draw", int, Sequence[Shot]]:
    """Return a movie's draw function, its number of frames, and their content."""
    from walkergen.guests.movie import top_view

    every = ABOVE_POSES_PER_FRAME if film.view == "above" else SLOW_POSES_PER_FRAME
    shots = [simulate_shot(film, design, every) for design in _with_progress(film, progress)]
    frames = 1 + max(len(shot.times) - 1 for shot in shots) // every
    words, lane = format_settings(film.scene), film.scene.arena.kind == "lane"
    words += _friction_note(film.members)
    if film.view == "perspective":
        from walkergen.guests.movie import perspective

        return perspective.make_draw_function(shots[0], every, film.slow, words), frames, shots
    case = Case(film.scene, film.members[0], mass_of(film.members[0]))
    gap, period = walls.gap(case) if lane else None, 1.0 / film.scene.drive.frequency
    return top_view.make_draw_function(shots, every, film.slow, words, period, gap), frames, shots


def _with_progress(film: Film, progress: Progress) -> Iterator[Design]:
    for number, design in enumerate(film.members):
        progress(f"simulating {make_title(design)}", number, len(film.members))
        yield design


def simulate_shot(film: Film, design: Design, every: int) -> Shot:
    """Simulate the ensemble's first run, with `every` poses for a frame.

    Raises InputError for a run that ended before its second frame.
    """
    interval = 1.0 / (film.request.fps * film.slow * every)
    # Half an interval more, so that rounding cannot lose the last pose.
    seconds = ((film.frames - 1) * every + 0.5) * interval
    run = film.scene.run.model_copy(update={"seconds": seconds})
    scene = film.scene.model_copy(update={"run": run})
    mass = mass_of(design)
    prepared = prepare(scene, design, mass)._replace(release=film.release)
    shot = make_shot(make_title(design), design, mass, poses.sample(prepared, interval))
    if len(shot.times) <= every:
        raise InputError(f"{make_title(design)}: the run ended before the second frame ({shot.poses.outcome.value})")
    return shot


def make_title(design: Design) -> Title:
    """Make the title of a walker's picture."""
    return Title(design.name, f"{design.tilt_deg:g}°", design.kind)


def _friction_note(members: Sequence[Design]) -> str:
    """Return the addition to the settings if feet have their own friction, otherwise ""."""
    limbs = [limb for design in members for limb in design.limbs]
    own = {limb.friction for limb in limbs if limb.friction is not None}
    if not own:
        return ""
    return f" (feet of their own: {', '.join(f'{friction:g}' for friction in sorted(own))})"


def format_settings(scene: Scene) -> str:
    """Describe the simulation in a line."""
    drive, contact = scene.drive, scene.contact
    shaken = drive.motor_in_words or (
        f"{drive.frequency:g} Hz, {drive.peak_gamma:.3g} g, plate ± {1e3 * drive.amplitude:.3g} µm"
        if 1e3 * drive.amplitude > AT_REST_UM
        else "plate at rest"
    )
    slope = f", plate's slope {scene.plate.slope_deg:g}° (drawn level)"
    return (
        f"{scene.name}: {shaken}; elastic feet, restitution {contact.restitution:g}, friction {contact.friction:g}"
        + (slope if scene.plate.slope_deg else "")
    )
