"""Report of a film: its walkers' motion, and its file."""

from walkergen.files.report import Report
from walkergen.guests.movie.make import Job, Made
from walkergen.guests.movie.shot import format_pace


def make_report(job: Job, film: Made) -> Report:
    """Report of a film that was made: a line a walker, then its files."""
    lines = []
    for shot in film.shots:
        seconds, distance = shot.times[-1], shot.distance
        ended = f"; {shot.ended}" if shot.ended else ""
        lines.append(
            f"{shot.name}: {distance:.2f} mm in {seconds:.3g} s, {distance / seconds:.1f} mm/s, "
            f"{len(shot.impacts)} impacts{ended}"
        )
    lines.append(f"{film.frames} frames, {job.fps} a second, {format_pace(job.slow)}")
    if film.mp4 is None:
        lines.append(f"no MP4: {film.without_mp4}")
    walkers = [
        {
            "name": shot.name,
            "seconds": shot.times[-1],
            "distance_mm": shot.distance,
            "impacts": len(shot.impacts),
            "ended": shot.ended,
        }
        for shot in film.shots
    ]
    facts = {
        "gif": str(film.gif),
        "mp4": None if film.mp4 is None else str(film.mp4),
        "without_mp4": film.without_mp4,
        "frames": film.frames,
        "fps": job.fps,
        "slow": job.slow,
        "view": job.view,
        "walkers": walkers,
    }
    files = [film.gif] if film.mp4 is None else [film.gif, film.mp4]
    return Report(name="movie", title="Film", tables=[], facts=facts, lines=lines, files=files)
