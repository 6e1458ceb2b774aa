"""Movies: one walker bouncing in slow motion, or several running side by side."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from walkergen.errors import InputError
from walkergen.files import output
from walkergen.files.progress import Progress
from walkergen.jobs.movie.footage import Footage, Impact, Shape, pace
from walkergen.scene import Scene
from walkergen.simulation.drive import height
from walkergen.simulation.model import Plan
from walkergen.simulation.plan import prepare
from walkergen.simulation.run import Outcome, RunResult, impacts_of, with_impacts
from walkergen.theory.impact import Kind
from walkergen.walker import names, solids
from walkergen.walker.design import Design
from walkergen.walker.mass import MassProperties, as_rigid

FPS = (1, 2, 4, 5, 10, 20, 25, 50)
"""Frames per second that a GIF can have: it counts in hundredths of a second."""

PERIODS, PLAYING_S = 6.0, 10.0
"""Slow motion by default: periods of the drive that are shown, and seconds to watch."""

RACE_S = 3.0
"""Length of a race by default, s, in real time."""

FEWEST_FRAMES, MOST_FRAMES, MOST_LANES = 2, 1000, 8

FINE = 8
"""Poses for each frame in slow motion: the curves show what happens between frames."""

HOLD_S = 1.5
"""Time for which the last frame stays before the GIF starts again, s."""


class Job(NamedTuple):
    """Choice of what to film: one member in slow motion, or several side by side."""

    members: Sequence[Design]
    scene: Scene
    seconds: float
    """Simulated time to show, s."""
    slow: float
    """Seconds of the movie for each second of the run."""
    fps: int

    @property
    def frames(self) -> int:
        """Number of frames, the first at time 0."""
        return 1 + int(self.seconds * self.slow * self.fps + 1e-9)


def file_name(job: Job) -> str:
    """Default name of the GIF: the walker's name or the number of lanes, and the scene's name."""
    single = len(job.members) == 1
    what = names.part(job.members[0]) if single else f"race_of_{len(job.members)}"
    return f"{what}_{job.scene.name}.gif"


class Made(NamedTuple):
    """Files that were written, and the runs that they show."""

    gif: Path
    mp4: Path | None
    without_mp4: str
    """Reason why there is no MP4; '' when there is an MP4."""
    frames: int
    footage: Sequence[Footage]


def plan(
    members: Sequence[Design],
    scene: Scene,
    *,
    seconds: float | None = None,
    periods: float | None = None,
    slow: float | None = None,
    fps: int = 25,
) -> Job:
    """Make a job, with defaults for all that is None. Raises InputError."""
    if fps not in FPS:
        known = ", ".join(str(one) for one in FPS)
        raise InputError(f"--fps {fps}: must be one of {known} (a GIF counts in 1/100 s)")
    for flag, value in (("--seconds", seconds), ("--periods", periods), ("--slow", slow)):
        if value is not None and not 0.0 < value <= 1e9:
            raise InputError(f"{flag} {value:g}: must be > 0 and <= 1e9")
    if len(members) > MOST_LANES:
        raise InputError(f"{len(members)} walkers in one movie; at most {MOST_LANES}")
    if seconds is not None and periods is not None:
        raise InputError("--seconds and --periods: both say how long; leave one of them out")
    single = len(members) == 1
    if periods is not None:
        seconds = periods / scene.drive.frequency
    elif seconds is None:
        seconds = PERIODS / scene.drive.frequency if single else RACE_S
    if slow is None:
        slow = max(1.0, float(f"{PLAYING_S / seconds:.2g}")) if single else 1.0
    job = Job(members, scene, seconds, slow, fps)
    if not FEWEST_FRAMES <= job.frames <= MOST_FRAMES:
        raise InputError(
            f"{job.frames:.6g} frames ({seconds:g} s of the run, {pace(slow)}, {fps} a second): "
            f"must lie in {FEWEST_FRAMES}..{MOST_FRAMES}; change --seconds, --slow or --fps"
        )
    return job


def make(job: Job, path: Path, progress: Progress) -> Made:
    """Simulate and film; writes `path` (a GIF) and, with ffmpeg, an MP4 beside it.

    Both files are written whole at the end. Raises InputError when a run ends before two frames.
    """
    from walkergen.jobs.movie import animation, bounce, impacts, race

    single = len(job.members) == 1
    every = FINE if single else 1
    footage = []
    for number, design in enumerate(job.members):
        progress(f"simulating {title(design)}", number, len(job.members))
        footage.append(film(job, design, every))
    frames = 1 + max(len(one.times) - 1 for one in footage) // every
    settings = _settings(job.scene, footage)
    if single:
        draw = bounce.draw_bounce(footage[0], every, job.slow, settings)
    else:
        draw = race.draw_race(footage, job.slow, settings)
    encoded = animation.encode(draw, frames, job.fps, HOLD_S, impacts.COLOURS, progress)
    output.write(path, encoded.gif)
    mp4 = path.with_suffix(".mp4") if encoded.mp4 is not None else None
    if mp4 is not None and encoded.mp4 is not None:
        output.write(mp4, encoded.mp4)
    return Made(path, mp4, encoded.without_mp4, frames, footage)


def film(job: Job, design: Design, every: int) -> Footage:
    """Simulate the ensemble's first run, with `every` poses for a frame, and its impacts."""
    interval = 1.0 / (job.fps * job.slow * every)
    # Half an interval more, so that rounding cannot lose the last pose.
    seconds = ((job.frames - 1) * every + 0.5) * interval
    run = job.scene.run.model_copy(update={"seconds": seconds})
    scene = job.scene.model_copy(update={"run": run})
    mass = solids.mass_of(design)
    prepared = prepare(scene, design, mass)
    result = with_impacts(prepared, 0, sample_interval=interval)
    footage = footage_of(design, mass, prepared, result)
    if len(footage.times) <= every:
        raise InputError(
            f"{title(design)}: the run ended before the second frame ({result.outcome.value})"
        )
    return footage


def title(design: Design) -> str:
    """Name of a walker as the picture shows it."""
    return f"{design.name}, {design.legs.tilt_deg:g}°, {design.legs.kind}"


def footage_of(design: Design, mass: MassProperties, plan: Plan, result: RunResult) -> Footage:
    """What a recorded run shows, in the terms of the picture."""
    samples = result.tally.samples
    assert samples is not None
    rows = samples.rows[: samples.cursor[0]]
    column = dict(zip(plan.model.columns, rows[:, 1:].T, strict=False))
    none = np.zeros(len(rows))
    drive = plan.world.drive
    places = np.column_stack([column["x_mm"] - column["x_mm"][:1], column["y_mm"]])
    return Footage(
        name=title(design),
        model=plan.resolved.model,
        shape=_shape(design, as_rigid(mass) if plan.resolved.model == "rigid" else mass),
        times=rows[:, 0],
        places=places,
        pitch=column["pitch_rad"],
        angles=np.column_stack(
            [column.get(f"alpha_{side}_rad", none) for side in ("back", "front")]
        ),
        plate=np.array([height(drive, phase) for phase in column["phase_rad"]]),
        phase=column["phase_rad"],
        impacts=tuple(
            Impact(row[0], int(row[1]), row[2:4], Kind(int(row[6]))) for row in impacts_of(result)
        ),
        ended="" if result.outcome is Outcome.OK else result.outcome.value,
    )


def _shape(design: Design, mass: MassProperties) -> Shape:
    """Outline about the centre of mass that the simulated state follows."""
    outline = solids.outline(design)
    O = np.array(design.anchors[0]) - mass.a  # noqa: E741  (the paper's name)
    anchors = np.array(design.anchors) - O
    return Shape(outline.body - O, outline.limb, anchors, np.array(design.anchor_to_foot))


def _settings(scene: Scene, footage: Sequence[Footage]) -> str:
    drive, contact = scene.drive, scene.contact
    models = ", ".join(dict.fromkeys(one.model for one in footage))
    slope = f", plate's slope {scene.plate.slope_deg:g}° (drawn level)"
    return (
        f"{scene.name}: {drive.frequency:g} Hz, {drive.peak_gamma:.3g} g, plate ± "
        f"{1e3 * drive.amplitude:.3g} µm; simulated: {models}, restitution "
        f"{contact.restitution:g} ({contact.law}), friction {contact.friction:g}"
        + (slope if scene.plate.slope_deg else "")
    )
