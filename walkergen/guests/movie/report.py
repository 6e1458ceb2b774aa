"""Report of a film: its walkers' motion, and its file."""

from walkergen.files.report import Report
from walkergen.guests.movie.film import Film, MovieFiles
from walkergen.guests.movie.shot import format_pace


def make_report(film: Film, made: MovieFiles) -> Report:
    """Return the report of a written film: a line for each walker, then the files."""
    lines = []
    for shot in made.shots:
        seconds, distance = shot.times[-1], shot.distance
        ended = f"; {shot.end_reason}" if shot.end_reason else ""
        lines.append(
            f"{shot.name}: {distance:.2f} mm in {seconds:.3g} s, {distance / seconds:.1f} mm/s, "
            f"{len(shot.impacts)} impacts{ended}"
        )
    lines.append(f"{made.frames} frames, {film.request.fps} a second, {format_pace(film.slow)}")
    if made.mp4 is None:
        lines.append(f"no MP4: {made.without_mp4}")
    walkers = [
        {
            "name": shot.name,
            "seconds": shot.times[-1],
            "distance_mm": shot.distance,
            "impacts": len(shot.impacts),
            "ended": shot.end_reason,
        }
        for shot in made.shots
    ]
    facts = {
        "gif": str(made.gif),
        "mp4": None if made.mp4 is None else str(made.mp4),
        "without_mp4": made.without_mp4,
        "frames": made.frames,
        "fps": film.request.fps,
        "slow": film.slow,
        "view": film.view,
        "walkers": walkers,
    }
    files = [made.gif] if made.mp4 is None else [made.gif, made.mp4]
    return Report(name="movie", title="Film", tables=[], facts=facts, lines=lines, files=files)
