"""Layout of a state of the 3D simulation, the data on a walker that kernels read, and their work space.

Axes: x along the lane, y up, z across; the body's own axes are the same when it stands level. The position is that of
C, the centre of mass of the whole walker; O is that of its body. The rotation is kept as the turning rate that body and
legs would share if the joints were locked (W, body axes): with both, the kinetic energy has no cross terms, and gravity
and free flight are exact (docs/physics.md section 7).

A state is a float64 array: what a trajectory shows, in the plate's plane (y to the left of x); the motion; the drive's
phase, the noise's time, the time at rest; then the legs' coordinates and their rates; then a row for each contact.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.core.numerics.kernels import kernel

Array = npt.NDArray[np.float64]

SHOWN_X, SHOWN_Y, HEADING, HEIGHT, PITCH, ROLL = range(6)
C_X, C_Y, C_Z, V_X, V_Y, V_Z, W_X, W_Y, W_Z, Q_0, Q_X, Q_Y, Q_Z, PHASE, NOISE, QUIET = range(6, 22)
LEGS = 22
"""Place of the first leg's coordinate."""

TRAJECTORY_COLUMNS = ("x_mm", "y_mm", "theta_rad", "height_mm", "pitch_rad", "roll_rad")
"""Names, with units, of the entries that a trajectory shows: of O; headings count whole turns."""

# A contact's row: mode; stretch of its tangential spring along both tangents (mm) and that spring's
# stiffness (g/s^2); and of the landing under way: its time (s, since the record began), velocity
# (normal, along, across, mm/s), impulses (g mm/s), and when the slip stopped.
MODE, ALONG, ACROSS, SHEAR, LANDED, U_N, U_A, U_C, J_N, J_A, J_C, STOP = range(12)
ROW_LENGTH = 12

HALVINGS = 4
"""Halvings of a step after which the shortest flight is left: that of a body that spins by 7 000 rad/s."""

OPEN, STICK, SLIDE = range(3)
"""Modes of an elastic contact."""

SLIDING, IN_RESTITUTION, IN_COMPRESSION = range(3)
"""Values of STOP: the slip has gone on so far; it stopped in restitution; in compression."""


class Walker(NamedTuple):
    """The integrator's data on a walker: n legs' coordinates, k points of contact.

    Lengths in mm; vectors in body axes from C. The coordinates of a leg are the angle of its hinge
    and, if it twists, the twist of its foot (rad).
    """

    mass: float
    """Mass of the whole walker, g."""
    inverse_mass: Array
    """Inverse mass along x, y, z, shape (3,): zero across for a walker held in its plane."""
    inertia: Array
    """Inertia tensor about C, shape (3, 3), g mm^2."""
    inverse_inertia: Array
    """Inverse of the inertia tensor, shape (3, 3); of its z axis alone when held in the plane."""
    centre: Array
    """Vector C -> O of the relaxed walker, shape (3,)."""
    freedoms: int
    """Coordinates of a leg: 0 braced, 1 hinge, 2 hinge and twist."""
    hinge_inertia: Array
    """Inertia of the legs' coordinates with C and W given, shape (n, n), g mm^2."""
    hinge_mobility: Array
    """Inverse of `hinge_inertia`."""
    stiffness: Array
    """Stiffness of the coordinates, shape (n,), g mm^2/s^2 per rad."""
    damping: Array
    """Damping of the coordinates, shape (n,), g mm^2/s per rad."""
    fast: Array
    """Squares of the coordinates' own angular frequencies, shape (n,), 1/s^2."""
    shift: Array
    """Displacement of C against O by the coordinates, shape (3, n), mm/rad."""
    lock: Array
    """Turning rate W that a coordinate's rate is worth, shape (3, n)."""
    leg: npt.NDArray[np.int64]
    """Leg of each point, -1 for a point on the body, shape (k,)."""
    root: Array
    """Points on the body, or the anchors of the legs' points, shape (k, 3)."""
    reach: Array
    """Vectors anchor -> middle of the foot of a relaxed leg, with each corner's own height, shape
    (k, 2); zero on the body."""
    side: Array
    """Place of a point across its leg (zeta), shape (k,)."""
    axis: Array
    """Unit vectors anchor -> foot along the relaxed legs' centre lines, shape (k, 2)."""
    wall_distance: Array
    """What a point may touch, shape (k,), mm. Positive: walls at |z|. 0: the plate. Negative: minus the height of the
    lid over the plate."""
    upward: Array
    """Upward component of a contact's directions (normal, along, across), shape (k, 3)."""
    friction: Array
    """Friction coefficients of the contacts, shape (k,)."""
    spring: Array
    """Axial stiffness of the leg's corner behind each tip, shape (k,), g/s^2."""
    tip: Array
    """Hertz stiffness K of each tip, force K depth^1.5, shape (k,), g/(mm^0.5 s^2); infinite: rigid."""
    shear: Array
    """Tangential stiffness of the contacts over their normal tangent stiffness, shape (k,)."""
    damper: Array
    """Normal damping over the root of the `tips.press` damping stiffness, shape (k,), g^0.5."""
    corners: Array
    """Corners of the body, or points of its hull, shape (c, 3)."""
    forced: Array
    """Coordinates of the legs in flight as a motor shakes them, times the cosine and the sine of
    its phase, shape (2, n), rad."""
    flights: Array
    """Propagators of the legs' coordinates and rates in flight, for times `Options.step` 2^i with i from -HALVINGS,
    shape (levels, 2 n, 2 n)."""


class Options(NamedTuple):
    """Length of a time step, and number of steps in a frozen frame."""

    step: float
    """Longest step while a foot may touch, s."""
    frame: int
    """Number of steps with frozen pose and contact directions."""


# A point of contact: place from C (body axes, mm), derivatives by both coordinates of its leg, gap
# (mm), time (s) during which it cannot close.
POINT_DTYPE = np.dtype(
    (np.record, [("at", np.float64, 3), ("turned", np.float64, (2, 3)), ("gap", np.float64), ("clear", np.float64)])
)

# A contact near its surface in a frame; triples are normal, along, across, pairs along, across.
NEAR_DTYPE = np.dtype(
    (
        np.record,
        [
            ("number", np.int64),  # among all points
            ("tried", np.int64),  # its mode in the step
            ("unknown", np.int64),  # its first unknown in the equations
            # what does not change: friction coefficient, and the numbers of the same names of `Walker`
            ("friction", np.float64),
            ("spring", np.float64),
            ("tip", np.float64),
            ("shear", np.float64),
            ("damper", np.float64),
            # depth about which its normal spring is linearised, force and tangent stiffness there; tangential
            # stiffness, normal damping; resistances c + h k / 2, the share of the step, up to its end, with contact;
            # touches; elastic energy of its stretch as the step begins
            ("about", np.float64),
            ("push", np.float64),
            ("k_n", np.float64),
            ("k_t", np.float64),
            ("c_n", np.float64),
            ("b_n", np.float64),
            ("b_t", np.float64),
            ("share", np.float64),
            ("strain", np.float64),
            # directions of its stretch as it slides, in the middle and at the end of the step, and the
            # slip (mm/s) that they follow from
            ("toward", np.float64, 2),
            ("end", np.float64, 2),
            ("slip", np.float64, 2),
            ("gap", np.float64, 3),  # and stretches, mm
            ("speed", np.float64, 3),  # over the surface, mm/s
            ("free", np.float64, 3),  # in the middle of a step without contact forces
            ("middle", np.float64, 3),  # the same with them
            ("force", np.float64, 3),  # g mm/s^2
            ("drift", np.float64, 3),  # accelerations by all but contacts and legs
            # of the place under it relative to the plate's middle: velocity as a frame begins, acceleration in it
            ("swept", np.float64, 3),
            ("sweeping", np.float64, 3),
            ("impulse", np.float64, 3),  # since the frame began, g mm/s
            ("carried", np.float64, 3),  # integrals of the impulses, g mm
        ],
    )
)


class Work(NamedTuple):
    """Memory of a run: the pose, and matrices for a frozen frame with m contacts near a surface."""

    R: Array
    """Body axes -> world, shape (3, 3)."""
    now: Array
    """Velocity of C and turning rate, body axes, shape (6,)."""
    motion: Array
    """Velocity of C and W, body axes, shape (6,)."""
    acting: Array
    """Accelerations of both without contact, shape (6,)."""
    gained: Array
    """Change of both in a frame, shape (6,)."""
    moved: Array
    """Displacements from both in a frame, shape (6,)."""
    points: npt.NDArray[np.record]
    """Points of contact, shape (k,)."""
    near: npt.NDArray[np.record]
    """Contacts near a surface, shape (k,), the first m in use."""
    J: Array
    """Jacobian, three rows a near contact (normal, along, across), shape (3 k, 6 + n)."""
    MJ: Array
    """Inverse mass of the whole times its transpose, by rows as well, shape (3 k, 6)."""
    ML: Array
    """Inverse inertia of the legs in a step times the transpose of their columns, shape (3 k, n)."""
    H: Array
    """Inverse mass at the contacts, J M^-1 J^T, shape (3 k, 3 k), 1/g."""
    A: Array
    """Equations of the forces, shape (3 k, 3 k + 1)."""
    pull: Array
    """Accelerations of the legs' coordinates, shape (n,)."""
    before: Array
    """Coordinates at the start of a frame, and their rates in flight, shape (2 n,)."""
    after: Array
    """Coordinates and rates after a flight, shape (2 n,)."""
    left: Array
    """Lag torques on the legs from effects that turn the body, shape (n,)."""
    swing: Array
    """Inverse inertia of the coordinates in a step, their springs included, shape (n, n)."""
    swung: Array
    """Length of the step that `swing` belongs to, shape (1,), s."""
    thrown: Array
    """By how much a motor's unbalanced mass leads C away, its rate and its second derivative, body
    axes, shape (3, 3)."""
    midway: Array
    """State at the middle of a frame, estimated at its start."""


@kernel
def work_for(walker, state):
    """Create the work space for a walker and its state."""
    n, k = len(walker.stiffness), len(walker.leg)
    m = 3 * k
    return Work(
        np.zeros((3, 3)),
        np.zeros(6),
        np.zeros(6),
        np.zeros(6),
        np.zeros(6),
        np.zeros(6),
        np.zeros(k, POINT_DTYPE),
        np.zeros(k, NEAR_DTYPE),
        np.zeros((m, 6 + n)),
        np.zeros((m, 6)),
        np.zeros((m, n)),
        np.zeros((m, m)),
        np.zeros((m, m + 1)),
        np.zeros(n),
        np.zeros(2 * n),
        np.zeros(2 * n),
        np.zeros(n),
        np.zeros((n, n)),
        np.zeros(1),
        np.zeros((3, 3)),
        np.zeros_like(state),
    )


@kernel
def first_row(walker):
    """Return the index in a state at which the row of the first contact begins."""
    return LEGS + 2 * len(walker.stiffness)


def state_size(walker: Walker) -> int:
    """Return the number of entries of a state."""
    return LEGS + 2 * len(walker.stiffness) + ROW_LENGTH * len(walker.leg)
