"""Files of a crowd's run: CSV with the columns that `walkergen analyse` reads, and extended XYZ for OVITO."""

from collections.abc import Callable

import numpy as np

from walkergen.core import Array, csv_text
from walkergen.files import extended_xyz
from walkergen.files.extended_xyz import Bodies
from walkergen.guests.crowd.statistics import dish_geometry
from walkergen.guests.crowd.statistics.film import CrowdFilm

CSV_COLUMNS = ("t_s", "particle", "x_mm", "y_mm", "theta_rad")

HEIGHT_RATIO = 0.5
"""Height of bodies in extended XYZ over their width: a film from above shows no height."""


def to_csv(film: CrowdFilm) -> bytes:
    """Return a film as CSV with a header line and all digits: a row for each walker seen at each time."""
    frame, walker = np.nonzero(np.isfinite(film.x))
    rows = zip(
        film.times[frame].tolist(),
        walker.tolist(),
        *(part[frame, walker].tolist() for part in (film.x, film.y, film.theta)),
        strict=True,
    )
    return csv_text(CSV_COLUMNS, rows).encode()


def to_xyz(film: CrowdFilm) -> bytes:
    """Return a film as extended XYZ: a frame for each time. Positions are wrapped into a periodic square."""
    frame, walker = np.nonzero(np.isfinite(film.x))
    x, y = dish_geometry.wrap_places(film.x[frame, walker], film.y[frame, walker], film.dish)
    theta = np.nan_to_num(film.theta[frame, walker])
    kinds = list(dict.fromkeys(film.kinds))
    halves = np.array([_half_axes(film, kind) for kind in kinds])
    kind = np.array([kinds.index(name) for name in film.kinds])[walker]
    bodies = Bodies(
        frame.astype(float),
        film.times[frame],
        walker.astype(float),
        [name.replace(" ", "_") for name in kinds],
        kind,
        np.column_stack([x, y, 0.0 * x]),
        extended_xyz.to_quaternions(theta, 0.0 * x, 0.0 * x),
        halves,
    )
    span = np.array([*film.dish.box, 2.0 * float(halves[:, 2].max())])
    box = extended_xyz.format_box(-0.5 * span, span, bool(film.dish.period))
    return extended_xyz.format_frames(bodies, box).encode()


FORMATS: dict[str, Callable[[CrowdFilm], bytes]] = {".csv": to_csv, ".xyz": to_xyz}
"""Writers of the formats, by the suffixes of their files."""


def _half_axes(film: CrowdFilm, kind: str) -> Array:
    """Return half the length, width and height (mm) of the box around a kind of walker: 1 if its outline is unknown."""
    if kind not in film.outlines:
        return np.ones(3)
    corners = np.concatenate(list(film.outlines[kind]))
    length, width = 0.5 * np.ptp(corners, axis=0)
    return np.array([length, width, HEIGHT_RATIO * width])
