"""The walker of all engines: the paper's at 10 deg on an open plate, as `walkergen export --format mjcf` writes it."""

import functools
import math
from typing import NamedTuple

import numpy as np

from walkergen.commands.export import mjcf
from walkergen.core.numerics import Array
from walkergen.core.scene import Scene
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.points.experiments import Walker

TILT_DEG = 10.0

PERIODS_PER_POSE = 4
"""Periods of the plate between two recorded poses."""

DISCARD_S = 0.5
"""Start of every run that is not measured, s."""


class Case(NamedTuple):
    """Walker in its scene, without twist of its legs, and its MJCF file."""

    walker: Walker
    mjcf: str
    springs: Array
    """Stiffness (g/s^2) of each point of contact in the file, shape (k,)."""

    @property
    def period(self) -> float:
        """Period of the plate, s."""
        return 1.0 / self.walker.scene.drive.frequency


class Start(NamedTuple):
    """Start of a run: small angles of the body (rad) and the phase of the plate (rad)."""

    pitch: float
    roll: float
    phase: float

    @property
    def quaternion(self) -> Array:
        """Orientation of the body, shape (4,): w, x, y, z."""
        turned = np.array([1.0, 0.5 * self.roll, 0.5 * self.pitch, 0.0])
        return np.asarray(turned / np.linalg.norm(turned))


@functools.cache
def load_case() -> Case:
    """Return the case."""
    design = templates.load("koumakis2016", "walkers", Design).variant(tilt_deg=TILT_DEG)
    scene = templates.load("plane-90hz", "scenes", Scene)
    scene = scene.model_copy(update={"effects": scene.effects.force("leg_twist", state=False)})
    walker = Walker(scene, design, solids.mass_of(design))
    files = dict(mjcf.files(design, scene))
    (text,) = (data.decode() for name, data in files.items() if name.endswith(".xml"))
    return Case(walker, text, mjcf.linear_springs(walker.plan()))


def draw_start(seed: int) -> Start:
    """Draw the start of a run."""
    return Start(*np.random.default_rng(seed).uniform((-1e-3, -1e-3, 0.0), (1e-3, 1e-3, 2.0 * math.pi)))


def count_poses(seconds: float, period: float) -> int:
    """Return the number of intervals between recorded poses in a run, its discarded start included."""
    return round((seconds + DISCARD_S) / (PERIODS_PER_POSE * period))


def speed_along_heading(poses: Array, interval: float) -> float:
    """Return the mean speed along the heading, without the discarded start.

    Parameters
    ----------
    poses : ndarray, shape (n, 4)
        Position x, y and unit vector of the heading, after every `interval` (s).
    """
    settled = poses[round(DISCARD_S / interval) :]
    heading = 0.5 * (settled[1:, 2:] + settled[:-1, 2:])
    along = np.sum(np.diff(settled[:, :2], axis=0) * heading)
    return float(along / ((len(settled) - 1) * interval))
