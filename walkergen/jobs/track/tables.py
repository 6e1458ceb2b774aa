"""Tables of what was tracked: console, JSON, and warnings with their numbers."""

import math
from typing import Any

import numpy as np
from rich import box
from rich.markup import escape
from rich.table import Table

from walkergen.files import words
from walkergen.jobs.track.make import Tracked

READ, LEAST_S = 0.95, 0.5
"""Share of its duration, less this time (s) for its last frames, below which a film breaks off."""

LOST = 0.05
"""Share of frames in which a walker is lost that is worth a warning."""


def to_table(made: Tracked) -> Table:
    """Table of the walkers: in how many frames each was seen, and what its heading rests on."""
    table = Table(
        title=escape(made.film.path.name), box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False
    )
    for heading in ("walker", "frames", "lost", "way (mm)"):
        table.add_column(heading, justify="right")
    table.add_column("heading by")
    for number, one in enumerate(made.walkers):
        frames = one.seen.frames
        way = float(np.hypot(*(one.position[-1] - one.position[0])))
        table.add_row(
            str(number), f"{frames[0]}..{frames[-1]}", str(_lost(frames)), words.number(way),
            one.headed.how,
        )  # fmt: skip
    return table


def notes(made: Tracked) -> list[str]:
    """What was looked for, in words, and the scale with its error."""
    look, linked = made.look, made.linked
    side = "darker" if look.dark else "lighter"
    error = " (its error is not known: give it as 0.05+-0.001)"
    if made.mm_per_px_se is not None:
        error = f" ± {100 * made.mm_per_px_se / made.mm_per_px:.1f} %"
    rate = f"{words.number(made.clock.fps, 4)} frames a second"
    if not made.clock.regular:
        steps = 1e3 * np.diff(made.clock.times)
        rate += f" in the mean, {steps.min():.3g} to {steps.max():.3g} ms apart by the film's times"
    found = [
        f"Walkers {side} than the ground by more than {words.number(look.threshold)} of 255 steps, "
        f"{linked.length:.1f} pixels long and {look.width:.0f} wide, area {linked.area:.0f}; "
        f"{words.number(made.mm_per_px, 4)} mm a pixel{error}; {rate}."
    ]
    if not math.isnan(made.noise_mm):
        found.append(
            f"Places are off by at most {words.number(made.noise_mm, 2)} mm, by how three in a row "
            "bend; lens and perspective are not undone."
        )
    return found


def warnings(made: Tracked) -> list[str]:
    """What went wrong, each with the number of frames."""
    linked, count = made.linked, made.looked
    told = []
    end, announced = made.clock.played_s, made.film.seconds
    if made.options.frames[1] is None and end < READ * announced - LEAST_S:
        told.append(f"the film breaks off: {end:.3g} s of {announced:.3g} s could be read")
    if linked.empty:
        told.append(f"nothing was found in {linked.empty} of {count} frames")
    if linked.merged:
        told.append(
            f"walkers touch, and are left out, in {linked.merged} of {count} frames; afterwards "
            "they may have changed their numbers: look at check.png"
        )
    for number, one in enumerate(made.walkers):
        if (lost := _lost(one.seen.frames)) > LOST * (lost + len(one.seen.frames)):
            told.append(f"walker {number} is lost in {lost} frames between its first and last")
    if linked.short:
        told.append(f"{linked.short} tracks were too short and are left out")
    unknown = [
        str(number) for number, one in enumerate(made.walkers) if np.isnan(one.headed.theta).all()
    ]
    if unknown:
        told.append(f"no heading of walker {', '.join(unknown[:10])}: see the table")
    if made.still:
        told.append(
            f"nothing moves in {made.still} of {count} frames: if the film holds its last picture, "
            "leave it out with --frames"
        )
    return told


def facts(made: Tracked) -> dict[str, Any]:
    """Everything for JSON and the manifest, with units in the names."""
    linked, look = made.linked, made.look
    noise = made.noise_mm
    return {
        "film": made.film.path.name, **made.options._asdict(),
        "fps": made.clock.fps, "regular_rate": made.clock.regular,
        "mm_per_px": made.mm_per_px, "mm_per_px_se": made.mm_per_px_se,
        "frames_looked_at": made.looked, "frames_without_walkers": linked.empty,
        "frames_with_touching_walkers": linked.merged, "frames_without_motion": made.still,
        "short_tracks": linked.short,
        "walkers_are": "dark" if look.dark else "light", "threshold": look.threshold,
        "width_px": look.width, "length_px": linked.length, "area_px": linked.area,
        "position_error_at_most_mm": None if math.isnan(noise) else noise,
        "tracks": [
            {"particle": number, "first": int(one.seen.frames[0]), "last": int(one.seen.frames[-1]),
             "lost": _lost(one.seen.frames), "heading_by": one.headed.how,
             "headings": int((~np.isnan(one.headed.theta)).sum())}
            for number, one in enumerate(made.walkers)
        ],
        "warnings": warnings(made),
    }  # fmt: skip


def _lost(frames: "np.ndarray[Any, np.dtype[np.int64]]") -> int:
    """Frames between a track's first and last in which it was not seen."""
    return int(frames[-1] - frames[0] + 1 - len(frames))
