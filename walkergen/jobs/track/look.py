"""Look of a film: how bright ground and walkers are, which of them is darker, how wide walkers are.

The ground may be lit unevenly: its brightness is a parabola over the frame, fitted to all but what
stands out. A walker is what differs from it by half of the walkers' own contrast.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from walkergen.errors import InputError
from walkergen.jobs.track.film import Grey

Array = npt.NDArray[np.float32]
Mask = npt.NDArray[np.bool_]

FITTED = 40_000
"""Number of pixels, about, to which the ground is fitted."""

ROUNDS, BEYOND = 6, 3.0
"""Rounds of the fit, after each of which pixels so many deviations away are left out."""

NOISY, FAINTEST, STRONGEST = 5.0, 16.0, 100.0
"""Smallest contrast of a walker: so many deviations of the noise, but within these steps of 255."""

THINNEST = 3.0
"""Smallest width of a walker, pixels."""

EIGHT = np.ones((3, 3), dtype=bool)
"""Neighbours of a pixel, those at its corners included."""


class Look(NamedTuple):
    """What tells walkers from the ground in one film."""

    ground: Array
    """Brightness of the ground, shape (height, width)."""
    noise: float
    """Standard deviation of the ground's brightness."""
    dark: bool
    """True when walkers are darker than the ground."""
    threshold: float
    """Contrast beyond which a pixel is a walker's, steps of brightness."""
    contrast: float
    """Contrast of the walkers themselves."""
    width: float
    """Width of the walkers, pixels: twice the largest distance from their edge."""

    def contrasts(self, frame: Grey) -> Array:
        """Contrasts of pixels with the ground, positive on walkers; lamps that flicker undone."""
        return contrasts(frame, self.ground, self.dark)


def contrasts(frame: Grey, ground: Array, dark: bool) -> Array:
    """Contrasts of pixels with the ground, positive where they are dark, or light."""
    found = frame - ground
    found -= np.median(found[:: _stride(found), :: _stride(found)])
    return -found if dark else found


def learn(
    samples: Sequence[Grey], dark: bool | None, threshold: float | None, width: float | None
) -> Look:
    """Look of a film from some of its frames; None: what the film tells.

    Raises InputError when nothing stands out, with what was seen.
    """
    ground, noise = _ground(np.median(np.stack(samples), axis=0))
    least = threshold if threshold is not None else min(max(NOISY * noise, FAINTEST), STRONGEST)
    sides = (True, False) if dark is None else (dark,)
    half, side = max((_thickest(samples, ground, one, least), one) for one in sides)
    if 2.0 * half < (THINNEST if width is None else min(width, THINNEST)):
        what = "light or dark" if dark is None else "dark" if dark else "light"
        raise InputError(
            f"no walker found: nothing {what} differs from the ground by {least:.3g} of 255 steps "
            f"and is {THINNEST:g} pixels wide (widest: {2 * half:.3g}): try --threshold, "
            "--walkers or --region"
        )
    size = 2.0 * half if width is None else width
    found = Look(ground, noise, side, least, least, size)
    level = _level(samples, found)
    if threshold is None and 0.5 * level > least:
        least = 0.5 * level
        if width is None:
            size = 2.0 * _thickest(samples, ground, side, least)
    return found._replace(threshold=least, contrast=level, width=size)


def pieces(mask: Mask, width: float) -> Iterator[tuple[tuple[slice, slice], Mask]]:
    """Connected pieces of a mask, each alone in its own box, with the box's place.

    Only those that may hold something `width` pixels wide, and none that touches the mask's border,
    as a table around the plate does.
    """
    labels, _ = ndimage.label(mask, EIGHT)
    for number, box in enumerate(ndimage.find_objects(labels), start=1):
        sizes = [one.stop - one.start for one in box]
        inside = all(
            one.start > 0 and one.stop < whole for one, whole in zip(box, mask.shape, strict=True)
        )
        if inside and min(sizes) >= width:
            yield box, np.pad(labels[box] == number, 1)


def _thickest(samples: Sequence[Grey], ground: Array, dark: bool, least: float) -> float:
    """Largest distance from the edge, pixels, in all pieces of that contrast; 0 without any."""
    found = 0.0
    for one in samples:
        for _, piece in pieces(contrasts(one, ground, dark) > least, max(THINNEST, 2.0 * found)):
            found = max(found, float(ndimage.distance_transform_edt(piece).max()))
    return found


def _level(samples: Sequence[Grey], look: Look) -> float:
    """Median contrast in the middle of pieces that are as wide as a walker; 0 without any."""
    values = []
    for one in samples:
        field = look.contrasts(one)
        for box, piece in pieces(field > look.threshold, 0.5 * look.width):
            deep = ndimage.distance_transform_edt(piece)[1:-1, 1:-1] > 0.25 * look.width
            values.append(field[box][deep])
    return float(np.median(np.concatenate(values))) if sum(map(len, values)) else 0.0


def _ground(picture: Array) -> tuple[Array, float]:
    """Brightness of the ground as a parabola, shape (height, width), and its noise."""
    step = _stride(picture)
    y, x = np.mgrid[: picture.shape[0], : picture.shape[1]] / max(picture.shape)
    terms = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=-1)
    few, seen = terms[::step, ::step].reshape(-1, 6), picture[::step, ::step].ravel()
    kept = np.abs(seen - np.median(seen)) <= np.quantile(np.abs(seen - np.median(seen)), 0.75)
    noise = 0.0
    for _ in range(ROUNDS):
        fit, *_ = np.linalg.lstsq(few[kept], seen[kept])
        rest = seen - few @ fit
        noise = 1.4826 * float(np.median(np.abs(rest[kept])))
        kept = np.abs(rest) <= max(BEYOND * noise, 1.0)
    return (terms @ fit).astype(np.float32), noise


def _stride(picture: Array) -> int:
    """Step between the rows, and columns, of a picture that are looked at."""
    return max(1, int(np.sqrt(picture.size / FITTED)))
