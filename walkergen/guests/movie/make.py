"""Movies: one walker in slow motion, or several running; from above, in perspective."""

import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from walkergen.core import Design, Expect, Expected, InputError, Progress, Scene, ignore_estimate, mass_of, prepare
from walkergen.core.files import output
from walkergen.core.simulation.effects import walls
from walkergen.core.simulation.effects.effect import Case
from walkergen.files.report import Report
from walkergen.guests.movie import report
from walkergen.guests.movie.film import Film, MovieFiles, file_name, plan_film
from walkergen.guests.movie.request import MovieRequest
from walkergen.guests.movie.shot import Shot, Title, make_shot
from walkergen.points import effect_selection, poses, run_time
from walkergen.request import choose_scene

if TYPE_CHECKING:
    from walkergen.files.animation import Draw

AT_REST_UM = 1e-6
"""Amplitude below which a plate is reported to be at rest, um."""

SLOW_POSES_PER_FRAME, ABOVE_POSES_PER_FRAME = 8, 4
"""Simulated poses for each frame: in slow motion, for its curves of heights, and from above, for smooth trails."""

WRITE_TIME_RATIO = 1.5
"""Time to draw and write a frame, over the time to draw it."""

MIN_FORECAST_S, MAX_SIMULATION_S = 3.0, 600.0
"""CPU time of a film's simulation, s, from which it is forecast, and its maximum, estimated from steps and periods."""

HOLD_S = 1.5
"""Duration of the last frame before the GIF starts again, s."""


def run(request: MovieRequest, progress: Progress, expect: Expect) -> Report:
    """Film the walkers of a request, and return a report with the files. `expect`: receives a time estimate."""
    if request.out is not None and request.out.suffix.lower() != ".gif":
        raise InputError(f"‹out=›{str(request.out)[:80]!r}: must end in .gif. The MP4 is written next to it.", "out")
    inputs = request.inputs()
    design = inputs.design(request.design)
    scene = inputs.scene(choose_scene(request.scene, [design]))
    effect_selection.check_no_accepted_error(scene, "applies only to speeds. A film shows every effect of its scene")
    members = inputs.members(design, request.tilt, request.legs, whole=False)
    film = plan_film(request, members, scene)
    path = request.out or Path("out") / design.name / file_name(film, inputs.values)
    return report.make_report(film, make_movie(film, path, progress, request.out is not None, expect))


def make_movie(
    film: Film, path: Path, progress: Progress, named: bool = True, expect: Expect = ignore_estimate
) -> MovieFiles:
    """Simulate and draw a film. Write `path` (a GIF) and, with ffmpeg, an MP4 next to it.

    `named`: True if the user named `path`: the GIF then may overwrite a file that walkergen did not write. Raises
    InputError when a run ends before two frames.
    """
    from walkergen.files import animation
    from walkergen.guests.movie import impacts

    cpu_s = _check_simulation_time(film)
    if cpu_s >= MIN_FORECAST_S:
        expect(lambda: Expected(cpu_s))
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
    return MovieFiles(path, mp4, encoded.without_mp4, frames, shots)


def _check_simulation_time(film: Film) -> float:
    """Return the CPU time (s) of a film's simulation. Raises InputError if it is longer than MAX_SIMULATION_S."""
    scene = film.scene
    rates = (run_time.rate_from_steps(prepare(scene, design, mass_of(design))) for design in film.members)
    cpu_s = sum(rates) * (scene.run.discard_seconds + film.seconds)
    if cpu_s > MAX_SIMULATION_S:
        raise InputError(
            f"drive.frequency_hz = {scene.drive.frequency:g}: the simulation of this film would take about "
            f"{cpu_s / 60.0:.3g} minutes, and may take {MAX_SIMULATION_S / 60.0:g}. Lower the frequency or ‹seconds›."
        )
    return cpu_s


def _expected_time(draw: "Draw", frames: int) -> Expected:
    """Estimate the time to draw and write all frames from one frame. The first, which takes longer, is not counted."""
    draw(0)
    started = time.thread_time()
    draw(frames // 2)
    return Expected((time.thread_time() - started) * WRITE_TIME_RATIO * frames)


def _prepare_drawing(film: Film, progress: Progress) -> tuple["Draw", int, Sequence[Shot]]:
    """Simulate all walkers. Return the function that draws a frame, the number of frames, and the runs to draw."""
    from walkergen.guests.movie import top_view

    poses_per_frame = ABOVE_POSES_PER_FRAME if film.view == "above" else SLOW_POSES_PER_FRAME
    shots = [simulate_shot(film, design, poses_per_frame) for design in _with_progress(film, progress)]
    frames = 1 + max(len(shot.times) - 1 for shot in shots) // poses_per_frame
    words, lane = format_settings(film.scene), film.scene.arena.kind == "lane"
    words += _friction_note(film.members)
    if film.view == "perspective":
        from walkergen.guests.movie import perspective

        return perspective.make_draw_function(shots[0], poses_per_frame, film.slow, words), frames, shots
    case = Case(film.scene, film.members[0], mass_of(film.members[0]))
    gap, period = walls.gap(case) if lane else None, 1.0 / film.scene.drive.frequency
    return top_view.make_draw_function(shots, poses_per_frame, film.slow, words, period, gap), frames, shots


def _with_progress(film: Film, progress: Progress) -> Iterator[Design]:
    """Yield the walkers of a film, and report the progress before each one."""
    for number, design in enumerate(film.members):
        progress(f"simulating {make_title(design)}", number, len(film.members))
        yield design


def simulate_shot(film: Film, design: Design, poses_per_frame: int) -> Shot:
    """Simulate one run of a walker for a film. Raises InputError if it ends before the second frame."""
    interval = 1.0 / (film.request.fps * film.slow * poses_per_frame)
    # Half an interval more, so that rounding cannot lose the last pose.
    seconds = ((film.frames - 1) * poses_per_frame + 0.5) * interval
    run = film.scene.run.model_copy(update={"seconds": seconds})
    scene = film.scene.model_copy(update={"run": run})
    mass = mass_of(design)
    prepared = prepare(scene, design, mass)
    shot = make_shot(make_title(design), design, mass, poses.sample(prepared, interval))
    if len(shot.times) <= poses_per_frame:
        raise InputError(f"{make_title(design)}: the run ended before the second frame ({shot.poses.outcome.value})")
    return shot


def make_title(design: Design) -> Title:
    """Return the title of a walker in a film."""
    return Title(design.name, f"{design.tilt_deg:g}°", design.kind)


def _friction_note(members: Sequence[Design]) -> str:
    """Return a note on the friction of legs for which the design sets it, instead of the scene; "" without any."""
    frictions = {leg.friction for design in members for leg in design.limbs if leg.friction is not None}
    return f" (some feet: {', '.join(f'{friction:g}' for friction in sorted(frictions))})" if frictions else ""


def format_settings(scene: Scene) -> str:
    """Describe drive, contact and slope of a scene in a line."""
    drive, contact = scene.drive, scene.contact
    motion = drive.motor_in_words or (
        f"{drive.frequency:g} Hz, {drive.peak_gamma:.3g} g, plate ± {1e3 * drive.amplitude:.3g} µm"
        if 1e3 * drive.amplitude > AT_REST_UM
        else "plate at rest"
    )
    slope = f", plate's slope {scene.plate.slope_deg:g}° (drawn level)"
    return (
        f"{scene.name}: {motion}; elastic feet, restitution {contact.restitution:g}, friction {contact.friction:g}"
        + (slope if scene.plate.slope_deg else "")
    )
