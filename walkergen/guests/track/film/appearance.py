"""Appearance of a film: brightness of ground and walkers, the darker of both, and the walkers' width.

The light may be uneven, with edges and gradients. The ground's brightness is what remains after removing everything
narrower than a few walkers (a grey closing for dark walkers, an opening for light ones). Light multiplies, so contrasts
are shares of the ground's own brightness, in steps of 255 in bright places. A walker differs from the ground by at
least half of the walkers' own contrast.
"""

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from walkergen.core.errors import InputError
from walkergen.core.numerics import Mask
from walkergen.guests.track.film.films import Grey

Floats = npt.NDArray[np.float32]

MEDIAN_PIXELS = 40_000
"""Approximate number of pixels for medians."""

BRIGHT_QUANTILE = 0.9
"""Quantile of the ground's brightness from which it counts as bright."""

NOISE_FACTOR, MIN_CONTRAST, MAX_CONTRAST = 5.0, 16.0, 100.0
"""Smallest contrast of a walker: NOISE_FACTOR standard deviations of the noise, clipped to these steps of 255."""

THRESHOLD_STEPS = 4
"""Number of thresholds that are tried, each double the one before."""

MIN_WIDTH_PX = 3.0
"""Smallest width of a walker, pixels."""

MAX_WINDOW_SHARE, WINDOW_WIDTHS = 0.7, 4.0
"""Widest window over the shorter side of the frame, and over a walker's width. Objects wider than the window count as
ground. A few walkers may touch."""

WINDOW_SHARES, MIN_WINDOW_WIDTHS, WIDTH_TOLERANCE = (1.0, 0.85, 0.5), 1.6, 0.25
"""Sizes of tested windows over the widest; smallest window over a walker's width; largest relative change of the
measured width between windows."""

MIN_GROUND_SHARE = 0.2
"""Brightness of the ground, over its bright part, below which contrasts are no longer scaled up."""

FIRST_BLUR_PX = 1.5
"""Standard deviation of the blur in the first search for walkers, pixels."""

BLURS, MAX_BLUR_SHARE = (0.0, 1.0, 1.5, 2.0, 3.0), 0.2
"""Tested blurs (sd, pixels) against noise, the first sufficient one is used; largest blur over the width."""

MIN_EDGE_SLOPE, MAX_SOFT_SHARE = 0.06, 0.2
"""Smallest slope of the brightness at a walker's edge over its contrast, 1/pixel (shades of the light have less), and
largest share of the edge with a smaller slope."""

EIGHT_NEIGHBOURS = np.ones((3, 3), dtype=bool)
"""Neighbours of a pixel, including those at its corners, for functions of `ndimage`."""


class Appearance(NamedTuple):
    """Differences between walkers and ground in one film."""

    picture: Floats
    """Median brightness of the sampled frames, which shows all objects at rest, shape (height, width)."""
    ground: Floats
    """Brightness of the ground, shape (height, width)."""
    dark: bool
    """Whether walkers are darker than the ground."""
    blur: float = FIRST_BLUR_PX
    """Standard deviation of the blur that removes noise, pixels; 0 for little noise."""
    noise: float = 0.0
    """Standard deviation of a pixel's contrast in the film."""
    threshold: float = 0.0
    """Contrast above which a pixel belongs to a walker, steps of brightness."""
    contrast: float = 0.0
    """Typical contrast of the walkers, steps of brightness."""
    width: float = 0.0
    """Width of the walkers, pixels: twice the largest distance of an inner pixel from the edge."""

    def contrasts(self, frame: Grey) -> Floats:
        """Return the contrasts of pixels with the ground, shape (height, width), > 0 on walkers, free of flicker."""
        lamp, gain = self._light_and_gain(frame)
        sharp = (frame - lamp * self.ground) * (-gain if self.dark else gain)
        return np.asarray(ndimage.gaussian_filter(sharp, self.blur), np.float32)

    def slopes(self, frame: Grey) -> Floats:
        """Return the slope of the brightness at each pixel, shape (height, width), contrast steps per pixel."""
        _, gain = self._light_and_gain(frame)
        slope = ndimage.gaussian_gradient_magnitude(frame, math.hypot(self.blur, 1.0), output=float)
        return np.asarray(slope * gain, np.float32)

    def _light_and_gain(self, frame: Grey) -> tuple[float, Floats]:
        """Return the lamp's brightness in a frame over that in `picture`, and factors from brightness to contrast."""
        step = max(1, int(np.sqrt(frame.size / MEDIAN_PIXELS)))
        few = np.s_[::step, ::step]
        lamp = float(np.median(frame[few] / np.maximum(self.picture[few], 1.0)))
        bright = np.quantile(self.ground[few], BRIGHT_QUANTILE)
        gain = bright / (lamp * np.maximum(self.ground, MIN_GROUND_SHARE * bright))
        return lamp, np.asarray(gain, np.float32)


def learn_appearance(
    samples: Sequence[Grey], dark: bool | None, threshold: float | None, width: float | None
) -> Appearance:
    """Return the appearance of a film, measured in some of its frames.

    `dark` (are walkers darker than the ground?), `threshold` (contrast) and `width` (pixels) are measured if None.
    Raises InputError, with the findings, if nothing stands out.
    """
    picture = ndimage.gaussian_filter(np.median(np.stack(samples), axis=0).astype(np.float32), 1.0)
    widest = MAX_WINDOW_SHARE * min(picture.shape)
    sides = (True, False) if dark is None else (dark,)
    few = samples[:: max(1, len(samples) // 2)]
    tries = [_try_side(few, picture, side, threshold) for side in sides]
    look = max(tries, key=lambda tried: tried.width)
    if look.width < (MIN_WIDTH_PX if width is None else min(width, MIN_WIDTH_PX)):
        what = "light or dark" if dark is None else "dark" if dark else "light"
        raise InputError(
            f"no walker found: nothing {what} differs from the ground by {look.threshold:.3g} of "
            f"255 grey levels and is {MIN_WIDTH_PX:g} pixels wide (widest: {look.width:.3g}). Try "
            "‹threshold›, ‹walkers› or ‹region›"
        )
    local = estimate_ground(picture, look.dark, min(WINDOW_WIDTHS * (width or look.width), widest))
    look = _measure_contrast(few, look._replace(ground=local), threshold)
    look = look._replace(threshold=0.5 * look.contrast if threshold is None else threshold)
    blurs = [blur for blur in BLURS if blur <= MAX_BLUR_SHARE * look.width]
    fields = [[look._replace(blur=blur).contrasts(sample) for sample in samples] for blur in blurs]
    noises = [_frame_noise(field) for field in fields]
    enough = [index for index, noise in enumerate(noises) if NOISE_FACTOR * noise <= 0.5 * look.contrast]
    chosen = enough[0] if enough else -1
    look = look._replace(blur=blurs[chosen], noise=noises[0])
    slopes = [look.slopes(sample) for sample in samples]
    return look._replace(width=width or next(_widest_spots(fields[chosen], slopes, (look.threshold,)))[0])


def _try_side(samples: Sequence[Grey], picture: Floats, dark: bool, threshold: float | None) -> Appearance:
    """Return the appearance of `dark` (else light) walkers in the widest window. Width 0 unless other windows agree.

    With the wrong `dark`, gaps between walkers look like walkers. But gaps are as wide as the window allows.
    """
    widest = MAX_WINDOW_SHARE * min(picture.shape)
    looks = [
        _measure_contrast(samples, Appearance(picture, estimate_ground(picture, dark, share * widest), dark), threshold)
        for share in WINDOW_SHARES
    ]
    whole = looks[0]
    differences = [
        abs(look.width - whole.width)
        for look, share in zip(looks, WINDOW_SHARES, strict=True)
        if share * widest > MIN_WINDOW_WIDTHS * whole.width
    ]
    agree = len(differences) > 1 and max(differences) <= WIDTH_TOLERANCE * whole.width
    return whole if agree else whole._replace(width=0.0)


def estimate_ground(picture: Floats, dark: bool, widest: float) -> Floats:
    """Return the brightness of the ground, without dark (else light) things narrower than `widest` (pixels)."""
    side, window = 1.0 if dark else -1.0, round(widest) | 1
    # A grey closing that ignores everything beyond the frame
    high = ndimage.maximum_filter(side * picture, window, mode="constant", cval=-np.inf)
    closed = ndimage.minimum_filter(high, window, mode="constant", cval=np.inf)
    off = closed - side * picture
    bias = np.median(off[off < MIN_CONTRAST])  # a maximum of noise is above its mean
    return np.asarray(np.maximum(side * (closed - bias), 1.0))


def _measure_contrast(samples: Sequence[Grey], look: Appearance, threshold: float | None) -> Appearance:
    """Return the appearance with contrast and width of sharp-edged objects. The width is 0 without any.

    If the ground is uncertain, shades of the light fainter than walkers merge with them. Unless `threshold` is given,
    several are tried, and the one with the widest object counts.
    """
    fields = [look.contrasts(sample) for sample in samples]
    slopes = [look.slopes(sample) for sample in samples]
    noise = _frame_noise(fields)
    least = min(max(NOISE_FACTOR * noise, MIN_CONTRAST), MAX_CONTRAST) if threshold is None else threshold
    steps = [least * 2**n for n in range(THRESHOLD_STEPS) if threshold is None or n == 0]
    width, level = max(_widest_spots(fields, slopes, steps), key=lambda spot: spot[0])
    return look._replace(noise=noise, threshold=least, contrast=max(level, least), width=width)


def _frame_noise(fields: Sequence[Floats]) -> float:
    """Estimate the noise (sd) of contrasts in frames, an array each, from the median change: most pixels are still."""
    steps = [np.median(np.abs(now - before)) for before, now in pairwise(fields)]
    return 1.4826 / math.sqrt(2.0) * float(np.median(steps)) if steps else 0.0


def _widest_spots(
    fields: Sequence[Floats], slopes: Sequence[Floats], thresholds: Sequence[float]
) -> Iterator[tuple[float, float]]:
    """Yield, for each threshold, median width (pixels) and contrast of the widest sharp-edged objects in all frames."""
    for threshold in thresholds:
        spots = [
            spot for field, slope in zip(fields, slopes, strict=True) for spot in _sharp_spots(field, slope, threshold)
        ]
        widest = max((width for width, _ in spots), default=0.0)
        wide = [spot for spot in spots if spot[0] > 0.5 * widest]  # leaves out marks and letters
        width, level = np.median(wide, axis=0) if wide else (0.0, 0.0)
        yield float(width), float(level)


def _sharp_spots(field: Floats, slope: Floats, threshold: float) -> Iterator[tuple[float, float]]:
    """Yield width (pixels) and contrast in the middle of each object with a sharp edge all around."""
    for box, piece in connected_pieces(field > threshold, MIN_WIDTH_PX):
        inside = piece[1:-1, 1:-1]
        edge = inside & ~ndimage.binary_erosion(piece, EIGHT_NEIGHBOURS)[1:-1, 1:-1]
        level = float(np.median(field[box][inside]))
        if np.quantile(slope[box][edge], MAX_SOFT_SHARE) > MIN_EDGE_SLOPE * level:
            depth = ndimage.distance_transform_edt(piece)[1:-1, 1:-1]
            middle = np.median(field[box][depth > 0.5 * depth.max()])
            yield 2.0 * float(depth.max()), float(middle)


def connected_pieces(mask: Mask, width: float) -> Iterator[tuple[tuple[slice, slice], Mask]]:
    """Yield the connected pieces of a mask: the box of each, and the piece alone in this box, padded by one pixel.

    Pieces narrower than `width` (pixels) are left out, as are those at the mask's border, such as a table around it.
    """
    labels, _ = ndimage.label(mask, EIGHT_NEIGHBOURS)
    for number, box in enumerate(ndimage.find_objects(labels), start=1):
        sizes = [side.stop - side.start for side in box]
        inside = all(side.start > 0 and side.stop < whole for side, whole in zip(box, mask.shape, strict=True))
        if inside and min(sizes) >= width:
            yield box, np.pad(labels[box] == number, 1)
