"""Shot of a movie: one run of the 3D simulation with the walker's mesh, its poses and landings, and a title."""

from typing import NamedTuple

import numpy as np

from walkergen.core import ENDED_WELL, Array, Design, MassProperties, Mesh, build
from walkergen.core.theory.impact import Kind
from walkergen.core.walker.mass import to_centre_frame
from walkergen.points.poses import Poses
from walkergen.readers.walkers import top_outline


class Impact(NamedTuple):
    """Impact of a foot on the plate."""

    time: float
    """Time since the first pose, s."""
    foot: int
    """Number of the corner that hits the plate."""
    impulse: Array
    """Impulse on the foot, shape (2,), g mm/s."""
    kind: Kind


def make_impact(event: Array) -> Impact:
    """Convert a row of the simulation's events (see `record.Events`) to an impact."""
    time, foot, along, upward, _, _, kind = event
    return Impact(time, int(foot), np.array((along, upward)), Kind(int(kind)))


class Title(NamedTuple):
    """Text in a picture that distinguishes its walker from others."""

    design: str
    tilt: str
    """Tilt of the walker's legs with its unit."""
    kind: str

    @property
    def legs(self) -> str:
        """Tilt and kind of the walker's legs."""
        return f"{self.tilt} {self.kind}"

    def __str__(self) -> str:
        return f"{self.design}, {self.tilt}, {self.kind}"


def format_pace(slow: float) -> str:
    """Describe the pace of a movie. `slow`: seconds of the movie for one second of the run."""
    if slow == 1.0:
        return "real time"
    return f"{slow:.3g} times slower" if slow > 1.0 else f"{1.0 / slow:.3g} times faster"


class Shot(NamedTuple):
    """One simulated run in space, with the walker that ran."""

    title: Title
    mesh: Mesh
    """Printed part about O, the body's centre of mass, which the poses follow, mm."""
    base: Array
    """Vector from O to the middle of the body's rectangle, along the body and across, shape (2,), mm."""
    size: Array
    """Length and depth of the body, shape (2,), mm."""
    contours: tuple[Array, ...]
    """Polygons of the body seen from above, from the middle of its rectangle, holes clockwise, mm."""
    poses: Poses
    impacts: tuple[Impact, ...]
    """Landings in the order of their times. Their `foot` is the number of a corner."""

    @property
    def name(self) -> str:
        """Name of the walker, as the picture shows it."""
        return str(self.title)

    @property
    def times(self) -> Array:
        """Times of the poses, shape (n,), s, from 0."""
        return self.poses.times

    @property
    def plate_heights(self) -> Array:
        """Height of the plate over its mean, shape (n,), mm."""
        return self.poses.plate

    @property
    def end_reason(self) -> str:
        """Reason why the run ended early; '' when it did not."""
        outcome = self.poses.outcome
        return "" if outcome in ENDED_WELL else outcome.value

    @property
    def track(self) -> Array:
        """Positions of the body's centre of mass at each pose, from above: along x and to its left, (n, 2), mm."""
        return self.poses.places[:, [0, 2]] * (1.0, -1.0)

    @property
    def distances(self) -> Array:
        """Distance that the walker has run along its heading up to each pose, shape (n,), mm."""
        heading = 0.5 * (self.poses.heading[1:] + self.poses.heading[:-1])
        ahead = np.column_stack([np.cos(heading), np.sin(heading)])
        return np.append(0.0, np.cumsum((np.diff(self.track, axis=0) * ahead).sum(axis=1)))

    @property
    def distance(self) -> float:
        """Distance that the walker ran along its heading in the whole shot, mm."""
        return float(self.distances[-1])


def make_shot(title: Title, design: Design, mass: MassProperties, poses: Poses) -> Shot:
    """Return the shot of a run: its poses with mesh, outline and impacts of the walker."""
    mesh, O = build(design).walker_with_cap, point_in_mesh(design, mass)  # noqa: E741  (the paper's name)
    return Shot(
        title=title,
        mesh=mesh.shift(-O),
        base=np.array([-O[0], 0.0]),
        size=np.array([design.size.length, design.size.depth]),
        contours=top_outline.body_contours(design),
        poses=poses,
        impacts=tuple(map(make_impact, poses.landings)),
    )


def point_in_mesh(design: Design, mass: MassProperties) -> Array:
    """Return the body's centre of mass O, which poses follow, in the frame of the walker's mesh, shape (3,), mm."""
    return np.array([*-to_centre_frame(design.limbs, mass, np.zeros(2)), 0.5 * design.size.depth])


def body_outline(shot: Shot, pose: int) -> list[Array]:
    """Return the polygons of the body seen from above, in the plane of the plate, shape (n, 2) each, mm.

    `pose`: index of the pose.
    """
    place: Array = shot.track[pose]
    heading = shot.poses.heading[pose]
    return [place + rotate(shot.base + contour, heading) for contour in shot.contours]


def foot_edges(shot: Shot, pose: int) -> Array:
    """Return the left and the right end (x, y) of each foot seen from above, shape (feet, 2, 2), mm."""
    ends: Array = shot.poses.corners[pose][:, [0, 2]] * (1.0, -1.0)
    return ends.reshape(-1, 2, 2)


def rotate(points: Array, angle: float) -> Array:
    """Rotate points (..., 2) counter-clockwise by an angle, rad."""
    c, s = np.cos(angle), np.sin(angle)
    return np.asarray(points @ np.array([[c, s], [-s, c]]))
