"""Extended XYZ: bodies in space, frame by frame, as OVITO reads them.

A body has its place (x, to the left, height, mm), its orientation (a quaternion in OVITO's order
x, y, z, w) and the half axes of its box (mm); its axes are forward, left, up
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
    """Rows of bodies at times; rows of one frame have one time."""

    frames: Array
    """Number of the frame of each row, shape (rows,)."""
    times: Array
    """Its time, s."""
    numbers: Array
    """Number of the body."""
    kinds: Sequence[str]
    """Names of the kinds of bodies, without blanks."""
    kind: Whole
    """Index of the body's kind in `kinds`, shape (rows,)."""
    places: Array
    """Shape (rows, 3), mm."""
    turns: Array
    """Unit quaternions x, y, z, w, shape (rows, 4)."""
    halves: Array
    """Half axes of the bodies of each kind, shape (kinds, 3), mm."""


def format_frames(bodies: Bodies, box: str) -> str:
    """Format bodies as the text of a file, frame by frame, in each frame by number. `box` is a text of `format_box`."""
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
    """Format the box around the bodies from its lowest corner and its sides, mm. It may be periodic along x and y."""
    sides = " ".join(f"{value:.9g}" for value in np.diag(span).ravel())
    corner = " ".join(f"{value:.9g}" for value in low)
    repeats = "T T F" if periodic else "F F F"
    return f'Lattice="{sides}" Origin="{corner}" pbc="{repeats}"'


def to_quaternions(heading: Array, pitch: Array, roll: Array) -> Array:
    """Compute unit quaternions x, y, z, w of bodies whose axes are forward, left and up, shape (n, 4).

    Heading is counted from x to the left, pitch upward, roll to the right, rad, shape (n,) each: a turn by the roll
    about the body's length, then by the pitch, then by the heading about up.
    """
    (a, b, c), (i, j, k) = ([trig(0.5 * angle) for angle in (heading, -pitch, roll)] for trig in (np.cos, np.sin))
    return np.column_stack([a * b * k - i * j * c, a * j * c + i * b * k, i * b * c - a * j * k, a * b * c + i * j * k])
