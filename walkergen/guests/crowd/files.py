"""Files of a crowd's run for other programs: CSV, extended XYZ for OVITO, and GSD for HOOMD-blue.

CSV has the columns that `walkergen analyse` reads. GSD (extra `crowd`) is HOOMD-blue's schema
(https://gsd.readthedocs.io): a type for each kind, with its outline as a polygon; places are in
single precision there, wrapped with their images in a periodic square, times in `log/time_s`, and
`log/particles/id` numbers the walkers that a frame has.
"""

import importlib.util
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

from walkergen import extras
from walkergen.core import Array, OutputError, csv_text
from walkergen.files import extended_xyz
from walkergen.files.extended_xyz import Bodies
from walkergen.guests.crowd.statistics import dish_geometry
from walkergen.guests.crowd.statistics.film import CrowdFilm

CSV_COLUMNS = ("t_s", "particle", "x_mm", "y_mm", "theta_rad")

HEIGHT_RATIO = 0.5
"""Height of bodies in extended XYZ over their width: a film from above shows none."""


def to_csv(film: CrowdFilm) -> bytes:
    """CSV with a header line, every digit kept, a row for each walker seen at each time."""
    frame, walker = np.nonzero(np.isfinite(film.x))
    rows = zip(
        film.times[frame].tolist(),
        walker.tolist(),
        *(part[frame, walker].tolist() for part in (film.x, film.y, film.theta)),
        strict=True,
    )
    return csv_text(CSV_COLUMNS, rows).encode()


def to_xyz(film: CrowdFilm) -> bytes:
    """Write extended XYZ: a frame for each time, with the walkers seen, wrapped in a periodic square."""
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


def to_gsd(film: CrowdFilm) -> bytes:
    """GSD of HOOMD-blue's schema, in two dimensions. Raises InputError without the package."""
    extras.require("crowd", "GSD")
    import gsd.hoomd

    kinds = list(dict.fromkeys(film.kinds))
    numbers = np.array([kinds.index(name) for name in film.kinds])
    shapes = [_polygon(film, kind) for kind in kinds]
    x, y = dish_geometry.wrap_places(film.x, film.y, film.dish)
    period = film.dish.period or 1.0
    images = [np.rint((far - near) / period) for far, near in ((film.x, x), (film.y, y))]
    with tempfile.TemporaryDirectory(prefix="walkergen-gsd-") as folder:
        path = Path(folder) / "crowd.gsd"
        with gsd.hoomd.open(str(path), "w") as file:
            for at, time in enumerate(film.times):
                seen = np.flatnonzero(np.isfinite(film.x[at]))
                frame = gsd.hoomd.Frame()
                frame.configuration.step = at
                frame.configuration.dimensions = 2
                frame.configuration.box = [*film.dish.box, 0, 0, 0, 0]
                frame.particles.N = len(seen)
                frame.particles.types, frame.particles.type_shapes = kinds, shapes
                frame.particles.typeid = numbers[seen]
                flat = np.zeros(len(seen))
                frame.particles.position = np.column_stack([x[at][seen], y[at][seen], flat])
                frame.particles.image = np.column_stack([*(far[at][seen] for far in images), flat])
                half = 0.5 * np.nan_to_num(film.theta[at][seen])
                turns = [np.cos(half), flat, flat, np.sin(half)]
                frame.particles.orientation = np.column_stack(turns)
                frame.log["time_s"] = np.array([time])
                frame.log["particles/id"] = seen
                file.append(frame)
        return path.read_bytes()


FORMATS: dict[str, Callable[[CrowdFilm], bytes]] = {".csv": to_csv, ".xyz": to_xyz, ".gsd": to_gsd}
"""Writers of the formats, by the suffixes of their files."""


def writable_suffixes() -> tuple[str, ...]:
    """Suffixes of the formats that can be written here: GSD with its package alone."""
    missing = importlib.util.find_spec("gsd") is None
    return tuple(suffix for suffix in FORMATS if not (suffix == ".gsd" and missing))


def encode(film: CrowdFilm, path: Path) -> bytes:
    """Encode a run in the format of a file's suffix.

    Raises OutputError where the library that packs it finds no room for its own file.
    """
    try:
        return FORMATS[path.suffix.lower()](film)
    except OSError as error:
        folder = tempfile.gettempdir()
        raise OutputError(
            f"{str(path)!r}: cannot be made in {folder!r}, where temporary files lie: {error.strerror or error}; "
            "make room there, or name another folder by TMPDIR"
        ) from None


def _half_axes(film: CrowdFilm, kind: str) -> Array:
    """Half length, width and height of the box around a kind's outline, mm; 1 without outlines."""
    if kind not in film.outlines:
        return np.ones(3)
    corners = np.concatenate(list(film.outlines[kind]))
    length, width = 0.5 * np.ptp(corners, axis=0)
    return np.array([length, width, HEIGHT_RATIO * width])


def _polygon(film: CrowdFilm, kind: str) -> dict[str, object]:
    """Outline of a kind as GSD describes shapes: the largest of its contours; nothing without."""
    if kind not in film.outlines:
        return {}
    largest = max(film.outlines[kind], key=lambda contour: float(np.ptp(contour, axis=0).max()))
    return {"type": "Polygon", "vertices": largest.tolist(), "rounding_radius": 0}
