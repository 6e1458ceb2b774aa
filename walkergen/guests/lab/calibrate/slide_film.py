"""Friction from the film of a slide: how fast a part gains speed on an incline of known angle.

A part that slides straight down an incline at theta gains a = g (sin(theta) - mu cos(theta)), with
Coulomb's friction mu: mu = tan(theta) - a / (g cos(theta)). The film looks at the incline from
right above it, so that its lengths are those along the incline.
"""

import math
from pathlib import Path

import numpy as np

from walkergen.analysis import track_files
from walkergen.core import Quantity
from walkergen.core.errors import InputError
from walkergen.core.files import safe_text
from walkergen.core.numerics import Array
from walkergen.core.scene import GRAVITY

MIN_FRAMES = 10
"""Smallest number of frames of a slide."""

CORRELATED_FRAMES = 10
"""Approximate number of neighbouring frames with equal errors."""

MAX_STILL_SHARE = 0.1
"""Largest displacement of a part at rest over that of the sliding part, due to reading errors and a shaking camera."""

MAX_FRICTION_CHANGE, MIN_SIGNIFICANCE = 0.1, 4.0
"""Change of the friction along the path that indicates several slides in a film, and its minimum significance in
standard errors."""


def friction(path: Path, angle_deg: float, error_deg: float) -> Quantity:
    """Compute the friction of the one part that slides in the file of tracks `path`, on an incline of this angle.

    `error_deg`: standard error of the angle. Still parts, such as caps that show the camera's tilt, are left out.
    Raises InputError for tracks of several sliding parts, of more than one slide, and without friction.
    """
    read = track_files.read_tracks(path, track_files.Units())
    name = safe_text.shorten_line(path.name)
    seen = [_visible_positions(track.position, read.interval) for track in read.tracks]
    distances = np.array([np.linalg.norm(places[-1] - places[0]) for _, places in seen])
    moving = int((distances > MAX_STILL_SHARE * distances.max()).sum())
    if moving > 1:
        raise InputError(
            f"{name}: {moving} tracks move, but only one part may slide. Cut the film with track ‹frames› and ‹region›"
        )
    times, places = seen[int(distances.argmax())]
    if len(times) < MIN_FRAMES:
        raise InputError(f"{name}: {len(times)} frames: must be at least {MIN_FRAMES} of a slide")
    acceleration, error, change, change_error = _acceleration(times, places)
    angle, angle_error = math.radians(angle_deg), math.radians(error_deg)
    normal = GRAVITY * math.cos(angle)
    if abs(change) > max(MAX_FRICTION_CHANGE * normal, MIN_SIGNIFICANCE * change_error):
        raise InputError(
            f"{name}: the friction seems to change by {abs(change) / normal:.2g} along the path: "
            "does the film begin before the slide, or continue after it? Cut it with track ‹frames›"
        )
    value = math.tan(angle) - acceleration / normal
    angle_part = (1.0 - acceleration / GRAVITY * math.sin(angle)) / math.cos(angle) ** 2 * angle_error
    total = math.hypot(angle_part, error / normal, acceleration / normal * (read.scale_se or 0.0))
    if value <= 0.0:
        raise InputError(
            f"{name}: gains {acceleration:.3g} mm/s2. Without friction it would gain {GRAVITY * math.sin(angle):.3g}. "
            "Are angle, millimetres and frames a second right?"
        )
    return Quantity("friction", "", value, total)


def _visible_positions(position: Array, frame_seconds: float) -> tuple[Array, Array]:
    """Return times (s, mean 0) and positions (mm, shape (n, 2)) of the frames in which `position` is not NaN."""
    seen = ~np.isnan(position).any(axis=1)
    times = frame_seconds * np.flatnonzero(seen)
    return times - times.mean(), position[seen]


def _acceleration(times: Array, places: Array) -> tuple[float, float, float, float]:
    """Return the acceleration (mm/s^2) along the path, its error, its change from start to end, and the change's error.

    `times`: s, mean 0, shape (n,). `places`: positions, mm, shape (n, 2).
    """
    way = places[-1] - places[0]
    ahead = places @ way / (np.linalg.norm(way) or 1.0)

    def fit_polynomial(degree: int) -> tuple[Array, Array]:
        """Return the coefficients of a polynomial of distance against time, lowest first, and their errors."""
        terms = np.vander(times, degree + 1, increasing=True)
        solution, _, _, _ = np.linalg.lstsq(terms, ahead)
        rest = ahead - terms @ solution
        noise = CORRELATED_FRAMES * float(rest @ rest) / max(len(times) - degree - 1, 1)
        return solution, np.sqrt(noise * np.diag(np.linalg.pinv(terms.T @ terms)))

    (_, _, bend), (_, _, error) = fit_polynomial(2)
    (*_, third), (*_, third_error) = fit_polynomial(3)
    span = 6.0 * float(np.ptp(times))
    return 2.0 * float(bend), 2.0 * float(error), span * float(third), span * float(third_error)
