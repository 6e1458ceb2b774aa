"""Silhouettes: the outline of what a picture shows, PNG or JPG, against a background of another brightness.

In a picture with transparency, the opaque area is the shape. In others, Otsu's threshold (1979) divides
brightness in two, and the background is the half that most of the picture's edge shows.
"""

import io
from pathlib import Path
from typing import NamedTuple

import numpy as np

from walkergen.core.errors import InputError
from walkergen.core.files import file_reading, formatting
from walkergen.core.numerics import Array
from walkergen.readers.drawings.contours import Drawing, NoUnitError

MAX_BYTES, MAX_PIXELS = 50_000_000, 100_000_000
"""Largest file, and pixels of a picture at most."""

MAX_SIDE_PIXELS = 1000
"""Pixels of a picture's longer side after scaling: 0.03 mm on a body of 28 mm."""

MAX_SPECK_SHARE = 2e-3
"""Area over that of the largest piece below which a piece or a hole is dirt."""

BLUR_PIXELS, SIMPLIFY_PIXELS = 0.7, 0.3
"""Width of the blur, and maximum change of a simplified outline, pixels."""

MIN_CONTRAST = 0.12
"""Least difference between the mean brightness of shape and background, of 0 to 1."""


class Silhouette(NamedTuple):
    """Shape that was found in a picture."""

    image: Array
    """Brightness or opacity of the pixels, 0 to 1, rows from the top, shape (height, width)."""
    contours: list[Array]
    """Contours in pixels, x to the right, y downward."""
    notes: tuple[str, ...]
    """Notes on the choices, a few words each."""


def read_drawing(path: Path, scale_mm: float | None, source: str) -> Drawing:
    """Return the contours of a picture's shape, mm, y up. `scale_mm`: mm per pixel of the reduced picture.

    Pictures with more than MAX_SIDE_PIXELS along a side are reduced to this size. Raises InputError, which begins with
    `source`, for a file that is no picture or shows no shape, and NoUnitError without a scale.
    """
    if scale_mm is None:
        raise NoUnitError(f"{source}: a picture has no size in mm. Set body.length_mm.")
    found = trace(path, source)
    scale = np.array([scale_mm, -scale_mm])
    return Drawing([ring * scale for ring in found.contours], found.notes)


def trace(path: Path, source: str) -> Silhouette:
    """Find the shape that differs from a picture's background. Raises InputError, which begins with `source`."""
    data = file_reading.read_bytes(path, MAX_BYTES)
    with file_reading.translate_library_errors(source, "picture"):
        image, quantity = _brightness(data, source)
    threshold = _otsu_threshold(image)
    border = np.concatenate([image[0], image[-1], image[:, 0], image[:, -1]])
    light = float(np.mean(border > threshold)) < 0.5  # the shape is lighter than its background
    inside = (image > threshold) == light
    if not inside.any() or inside.all() or abs(image[inside].mean() - image[~inside].mean()) < MIN_CONTRAST:
        raise InputError(f"{source}: no shape differs from the background. Use a picture with more contrast.")
    rings, specks = _trace_contours(image if light else 1.0 - image, threshold if light else 1.0 - threshold)
    what = (
        "what is opaque" if quantity == "opacity" else f"what is {'lighter' if light else 'darker'} than its background"
    )
    notes = [f"traced {path.name}: {what}, divided at {100 * threshold:.0f} % of full {quantity}"]
    if specks:
        notes.append(f"left out {formatting.format_count(specks, 'speck', 'specks')}")
    return Silhouette(image, rings, tuple(notes))


def _brightness(data: bytes, source: str) -> tuple[Array, str]:
    """Return the pixels of a picture, 0 to 1, rows from the top, and their quantity: "brightness" or "opacity"."""
    from PIL import Image, ImageOps

    picture: Image.Image = Image.open(io.BytesIO(data))
    if picture.width * picture.height > MAX_PIXELS:
        raise InputError(f"{source}: {picture.width} x {picture.height} pixels, at most {MAX_PIXELS}. Make it smaller.")
    picture = ImageOps.exif_transpose(picture)
    picture.thumbnail((MAX_SIDE_PIXELS, MAX_SIDE_PIXELS))
    if "A" in picture.getbands() or "transparency" in picture.info:
        opacity = np.asarray(picture.convert("RGBA"), np.float64)[:, :, 3] / 255.0
        if np.ptp(opacity) > 0.5:
            return opacity, "opacity"
    return np.asarray(picture.convert("L"), np.float64) / 255.0, "brightness"


def _otsu_threshold(image: Array) -> float:
    """Return the brightness that divides an image into the two most different classes. Source: Otsu (1979)."""
    counts, edges = np.histogram(image, bins=256, range=(0.0, 1.0))
    middles = 0.5 * (edges[1:] + edges[:-1])
    below, above = np.cumsum(counts), len(image.ravel()) - np.cumsum(counts)
    total = np.cumsum(counts * middles)
    with np.errstate(divide="ignore", invalid="ignore"):
        between = below * above * (total / below - (total[-1] - total) / above) ** 2
    between = np.nan_to_num(between[:-1])
    best = np.flatnonzero(between >= between.max() * (1.0 - 1e-12))  # between two flat tones, the middle
    return float(edges[1:-1][best].mean())


def _trace_contours(image: Array, threshold: float) -> tuple[list[Array], int]:
    """Return contours, in pixels, of areas brighter than a threshold, and the number of specks that are left out."""
    import shapely
    from contourpy import contour_generator
    from scipy.ndimage import gaussian_filter

    framed = gaussian_filter(np.pad(image, 2), BLUR_PIXELS)
    framed[[0, -1]] = framed[:, [0, -1]] = 0.0
    lines = contour_generator(z=framed).lines(threshold)
    rings = [shapely.Polygon(line).simplify(SIMPLIFY_PIXELS) for line in lines if len(line) > 3]
    areas = np.array([ring.area for ring in rings])
    kept = areas > MAX_SPECK_SHARE * areas.max(initial=0.0)
    return [np.asarray(ring.exterior.coords)[:-1] - 2.0 for ring, keep in zip(rings, kept, strict=True) if keep], int(
        (~kept).sum()
    )
