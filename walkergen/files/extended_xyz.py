"""Extended XYZ: bodies in space, frame by frame, as OVITO reads them.

A body has a position (x, to the left, height, mm), an orientation (a quaternion in OVITO's order
x, y, z, w) and the half axes of its box (mm). Its axes point forward, left and up
(https://ovito.org/manual/reference/file_formats/input/xyz.html).
"""

import io
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from walkergen.core.numerics import Array, Whole

PROPERTIES = "species:S:1:id:I:1:pos:R:3:orientation:R:4:aspherical_shape:R:3"
"""Properties of a particle, by their names in OVITO."""


class Bodies(NamedTuple):
    """Positions and orientations of bodies over time: a row for each body in each frame."""

    frames: Array
    """Number of each row's frame, shape (rows,)."""
    times: Array
    """Time of each row's frame, shape (rows,), s."""
    numbers: Array
    """Number of each row's body, shape (rows,)."""
    kinds: Sequence[str]
    """Names of the kinds of bodies, without blanks."""
    kind: Whole
    """Index in `kinds` of each row's body, shape (rows,)."""
    places: Array
    """Positions (x, to the left, height), shape (rows, 3), mm."""
    turns: Array
    """Orientations as unit quaternions x, y, z, w, shape (rows, 4)."""
    halves: Array
    """Half axes of the bodies of each kind, shape (kinds, 3), mm."""


def format_frames(bodies: Bodies, box: str) -> str:
    """Return the text of a file with all frames. A frame lists its bodies by number. `box`: text of `format_box`."""
    half_axes = [" ".join(f"{value:.9g}" for value in axes) for axes in bodies.halves]
    lines = [f"{name} %d{' %.9g' * 7} {axes_text}\n" for name, axes_text in zip(bodies.kinds, half_axes, strict=True)]
    table = np.column_stack([bodies.numbers, bodies.places, bodies.turns])
    order = np.lexsort((bodies.numbers, bodies.frames))
    frames, starts = np.unique(bodies.frames[order], return_index=True)
    stream = io.StringIO()
    for rows in np.split(order, starts[1:]) if len(frames) else []:
        stream.write(f"{len(rows)}\n{box} Properties={PROPERTIES} Time={bodies.times[rows[0]]:.9g}\n")
        stream.writelines(
            lines[kind] % tuple(row) for kind, row in zip(bodies.kind[rows].tolist(), table[rows].tolist(), strict=True)
        )
    return stream.getvalue()


def format_box(low: Array, span: Array, periodic: bool = False) -> str:
    """Format the box with lowest corner `low` and sides `span`, mm. `periodic`: whether it is so along x and y."""
    sides = " ".join(f"{value:.9g}" for value in np.diag(span).ravel())
    corner = " ".join(f"{value:.9g}" for value in low)
    repeats = "T T F" if periodic else "F F F"
    return f'Lattice="{sides}" Origin="{corner}" pbc="{repeats}"'


def to_quaternions(heading: Array, pitch: Array, roll: Array) -> Array:
    """Compute the unit quaternions x, y, z, w, shape (n, 4), of bodies from three angles, rad, shape (n,) each.

    The body first rolls to the right about its length, then pitches upward, then turns from x to the left by its
    heading.
    """
    (a, b, c), (i, j, k) = ([trig(0.5 * angle) for angle in (heading, -pitch, roll)] for trig in (np.cos, np.sin))
    return np.column_stack([a * b * k - i * j * c, a * j * c + i * b * k, i * b * c - a * j * k, a * b * c + i * j * k])
