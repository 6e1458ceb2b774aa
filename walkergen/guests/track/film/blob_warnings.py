"""Warnings on a film of walkers without markers, each with its size: shadows, sizes, shake."""

import math
from collections.abc import Iterator, Sequence

import numpy as np

from walkergen.core import Quantity
from walkergen.core.files import formatting
from walkergen.core.numerics import Array, Whole
from walkergen.guests.track.film.blob_tracking import Unmarked
from walkergen.guests.track.film.blobs import Blobs
from walkergen.guests.track.film.linking import Track
from walkergen.guests.track.film.quality import MAX_LOST_SHARE, Remarks
from walkergen.guests.track.film.result import Tracked

CORRELATED_FRAMES = 10
"""Approximate number of neighbouring frames with equal errors."""

MIN_SIGNIFICANCE = 4.0
"""Significance threshold of a shadow, or a change of size, in standard errors."""

MAX_SHAKE_PX, MAX_PULL_PX, MAX_SIZE_CHANGE, MAX_SIZE_SCATTER = 0.2, 0.3, 0.04, 0.02
"""Thresholds of warnings: shake and pull of shadows, pixels; relative change of a walker's size between places, and
from frame to frame."""


def collect_remarks(tracked: Tracked, found: Unmarked) -> Remarks:
    """Return facts, notes and warnings on a film of walkers without markers."""
    look, linked, shake = found.look, found.linked, found.shake
    pull, (change, scatter) = shadow_pull(linked.walkers), size_change(found.straight)
    facts = {
        "frames_without_walkers": linked.empty,
        "frames_with_touching_walkers": linked.merged,
        "frames_without_motion": found.still,
        "short_tracks": linked.short,
        "walkers_are": "dark" if look.dark else "light",
        "threshold": look.threshold,
        "width_px": look.width,
        "length_px": linked.length,
        "area_px": linked.area,
        "contrast": look.contrast,
        "noise": look.noise,
        "shake_px": _finite_or_none(shake.rms),
        "shake_most_px": _finite_or_none(shake.largest),
        "shadow_px": pull,
        "size_change_share": change.value,
        "size_change_se_share": _finite_or_none(change.pair[1]),
        "size_scatter_share": scatter,
    }
    return Remarks(
        facts,
        list(_notes(tracked, found)),
        [*_link_warnings(tracked, found), *_image_warnings(tracked, found, pull, change, scatter)],
    )


def _finite_or_none(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _notes(tracked: Tracked, found: Unmarked) -> Iterator[str]:
    """Yield notes on the appearance of walkers, the scale with its error, and an unknown shake."""
    look, linked = found.look, found.linked
    error = " (error unknown: give it as 0.05+-0.001)"
    scale, scale_se = tracked.mm_per_px.number, tracked.mm_per_px.se
    if scale_se is not None:
        error = f" ± {formatting.format_number(100.0 * scale_se / scale, 2)} %"
    yield (
        f"Walkers {'darker' if look.dark else 'lighter'} than the ground by more than "
        f"{formatting.format_number(look.threshold)} of 255 grey levels, {linked.length:.1f} pixels long and "
        f"{look.width:.0f} wide, "
        f"area {linked.area:.0f}; {formatting.format_number(scale, 4)} mm per pixel{error}; "
        f"{tracked.clock.in_words}."
    )
    if math.isnan(found.shake.rms):
        yield "Shake of the camera is unknown: the ground shows no fixed points."


def _link_warnings(tracked: Tracked, found: Unmarked) -> Iterator[str]:
    """Yield warnings of walkers that are missing, merged, lost or mistaken for others."""
    linked, count, walkers = found.linked, tracked.looked, tracked.walkers
    if linked.empty:
        yield f"nothing was found in {linked.empty} of {count} frames"
    if linked.merged:
        yield (
            f"walkers that touch are left out in {linked.merged} of {count} frames. Their numbers may be exchanged "
            "afterwards: look at check.png"
        )
    for walker in walkers:
        if walker.lost > MAX_LOST_SHARE * (walker.lost + len(walker.frames)):
            yield f"walker {walker.number} is lost in {walker.lost} frames between its first and last"
    if linked.short:
        yield f"{linked.short} tracks were too short and are left out"
    unknown = [str(walker.number) for walker in walkers if np.isnan(walker.theta).all()]
    if unknown:
        yield f"no heading of walker {', '.join(unknown[:10])}: see the table"
    most = int(np.bincount(np.concatenate([walker.frames for walker in walkers])).max())
    if most < len(walkers):
        yield (
            f"{len(walkers)} tracks, but at most {most} walkers in a frame: a lost walker may continue under another "
            "number. Tracks are then not independent samples"
        )


def _image_warnings(tracked: Tracked, found: Unmarked, pull: float, change: Quantity, scatter: float) -> Iterator[str]:
    """Yield warnings on light and camera: `pull` of shadows (pixels), `change` of size by place, `scatter` by frame."""
    look, shake = found.look, found.shake

    def format_length(pixels: float) -> str:
        return (
            f"{formatting.format_number(pixels, 2)} pixels "
            f"({formatting.format_number(pixels * tracked.mm_per_px.number, 2)} mm)"
        )

    if look.blur:
        yield (
            f"low contrast: walkers differ from the ground by {look.contrast:.3g} of 255 grey levels, "
            f"{look.contrast / look.noise:.2g} times the noise of a pixel. Use more light"
        )
    if shake.rms > MAX_SHAKE_PX:
        yield (
            f"the camera shakes: fixed points move by {format_length(shake.rms)} r.m.s., at most "
            f"{format_length(shake.largest)}, and positions with them. Fix the camera"
        )
    if pull > MAX_PULL_PX:
        yield (
            f"shadows shift the centres of walkers by {format_length(pull)}. Light from all sides, or raise ‹threshold›"
        )
    if change.number > max(MAX_SIZE_CHANGE, MIN_SIGNIFICANCE * change.pair[1]):
        yield (
            f"walkers look {100 * change.number:.2g} % larger in one place than in another, and so do all lengths. "
            "The camera does not look straight down, or its lens distorts (‹lens›)"
        )
    if scatter > MAX_SIZE_SCATTER:
        yield (
            f"walkers change their size by {100 * scatter:.2g} % as they run: shadows, light or noise count as parts "
            "of them"
        )
    if found.still:
        yield (
            f"nothing moves in {found.still} of {tracked.looked} frames. If the film repeats its last picture, omit it "
            "with ‹frames›"
        )


def shadow_pull(walkers: Sequence[Track]) -> float:
    """Compute the shift of walkers' centres by shadows, pixels; 0 if none is resolved.

    A shadow lies on one side in the picture. Shades that turn with a walker belong to its body. If walkers never turn,
    the two cannot be distinguished.
    """
    blobs = _join_blobs(walkers)
    c, s = np.cos(blobs.axis), np.sin(blobs.axis)
    ones, none = np.ones_like(c), np.zeros_like(c)
    right = np.column_stack([ones, none, c, s])  # 2 columns for a shadow, 2 for shades on a walker
    down = np.column_stack([none, ones, -s, c])
    terms, pulls = np.concatenate([right, down]), np.concatenate([blobs.pull_x, blobs.pull_y])
    fit, _, rank, _ = np.linalg.lstsq(terms, pulls)
    if rank < terms.shape[1]:
        return 0.0
    variance = float(np.mean((pulls - terms @ fit) ** 2)) * CORRELATED_FRAMES
    error = math.sqrt(variance * float(np.trace(np.linalg.inv(terms.T @ terms)[:2, :2])))
    pull = math.hypot(fit[0], fit[1])
    return pull if pull > MIN_SIGNIFICANCE * error else 0.0


def size_change(walkers: Sequence[Track]) -> tuple[Quantity, float]:
    """Return the relative change of walkers' size with their position, and the relative scatter (sd) that remains.

    A camera that looks at an angle, or a lens, changes sizes with the position. A plane and a bowl are fitted to the
    logarithm of the size, each walker with its own mean.
    """
    blobs = _join_blobs(walkers)
    owner = np.repeat(np.arange(len(walkers)), [len(walker.frames) for walker in walkers])
    position = np.column_stack([blobs.x, blobs.y])
    position -= position.mean(axis=0)
    position /= np.abs(position).max() or 1.0
    terms = np.column_stack([position, (position**2).sum(axis=1)])
    size = 0.5 * np.log(blobs.area)
    slopes = np.array([_subtract_means(term, owner) for term in terms.T])
    changes = _subtract_means(size, owner)
    fit, _, rank, _ = np.linalg.lstsq(slopes.T, changes)
    if rank < 3:
        return Quantity("size_change", "share", 0.0, math.inf), float(changes.std())
    rest = changes - fit @ slopes
    fitted = terms @ fit
    ends = terms[[fitted.argmax(), fitted.argmin()]]
    span = ends[0] - ends[1]
    spread = np.linalg.pinv(slopes @ slopes.T) * float(np.mean(rest**2)) * CORRELATED_FRAMES
    error = math.sqrt(float(span @ spread @ span))
    return Quantity("size_change", "share", math.expm1(float(span @ fit)), error), float(rest.std())


def _subtract_means(values: Array, owner: Whole) -> Array:
    """Subtract from each value the mean of its walker. `owner`: index of the walker of each value. Shapes: (n,)."""
    means = np.bincount(owner, values) / np.bincount(owner)
    return np.asarray(values - means[owner])


def _join_blobs(walkers: Sequence[Track]) -> Blobs:
    """Return the blobs of all walkers in one array per field, one walker after the other."""
    return Blobs(*np.hstack([np.array(walker.blobs) for walker in walkers]))
