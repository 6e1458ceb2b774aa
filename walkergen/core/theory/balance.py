"""Stationary speed of a walker on unlike feet: momentum and angular momentum balanced over impacts.

Between impacts momentum along the plate and angular momentum about the centre of mass are kept, so
in a stationary state impacts add none on average (docs/physics.md section 4b). Every foot arrives
with the same normal speed w and slides at the walker's speed v, as in the paper; the ratio v / w is
called the factor. For two equal feet it is the paper's mean (`walkergen.core.theory.speed`) within its
approximation. Two feet determine speed and shares of impacts; for more, loads are chosen.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.core.errors import TheoryError
from walkergen.core.numerics.kernels import kernel
from walkergen.core.theory.impact import impact
from walkergen.core.theory.speed import Mode, factor
from walkergen.core.theory.tensors import InverseMass
from walkergen.core.walker.mass import Values

Array = npt.NDArray[np.float64]

MIN_FRICTION = 1e-12
"""Friction that a smaller one counts as: where all are 0 and every speed is stationary, this gives
the limit of equal, vanishing frictions; elsewhere it changes the speed by about this ratio."""

EPSILON = float(np.finfo(float).eps)

# Columns of a foot in the table that kernels read.
XX, XY, YY, LEVER_X, LEVER_Y, RESTITUTION, FRICTION = range(7)


class Foot(NamedTuple):
    """Properties of a foot for impacts; each number may be an array, of shapes that broadcast."""

    H: InverseMass
    """Inverse-mass tensor at the foot, 1/g."""
    lever: tuple[Values, Values]
    """Vector (x, y) from the centre of mass of the whole walker to the foot, mm. Gravity has no torque about it. The
    paper uses that of the body."""
    restitution: Values
    friction: Values


class Balance(NamedTuple):
    """Stationary state of a walker; shapes (...) are those of the feet's numbers together."""

    factor: Array
    """Speed v over impact speed w, positive along +x, shape (...)."""
    shares: Array
    """Share of each foot in the number of impacts, shape (feet, ...); their sum is 1."""
    loads: Array
    """Share of each foot in the normal impulse, shape (feet, ...); their sum is 1."""
    note: str
    """Description of the balance and its assumptions."""


def solve_balance(feet: Sequence[Foot], mode: Mode = "coulomb") -> Balance:
    """Find speed and shares of impacts at which a walker gains neither momentum nor spin on average.

    F_i(v) is the impulse at foot i, the loads are N_i = s_i F_y,i / sum, and the force ratios rho_i = F_x,i / F_y,i.
    They obey sum N_i rho_i = 0 and sum N_i (x_i - y_i rho_i) = 0. Each rho_i falls with v and is 0 at the foot's own
    stationary speed. So v lies between these speeds, and is unique for feet at one height.

    More than two feet bear loads as on equal springs, which cannot pull: of all loads that balance the body, those
    nearest to equal ones. Arrays broadcast (1024 draws of two feet: 7 ms). Raises TheoryError for feet that are not on
    both sides of the centre of mass, for mode `paper`, which has no impact law, and for numbers out of range.
    """
    if mode == "paper":
        raise TheoryError(
            "mode = 'paper': eq. 15 lets every foot slide back and has no impact law that could "
            "balance unequal feet. Use mode coulomb."
        )
    if not feet:
        raise TheoryError("balance: a walker without feet has no speed. Give it two or more.")
    foot_factors = [factor(foot.H, foot.restitution, foot.friction, mode) for foot in feet]
    broadcast = np.broadcast_arrays(
        *foot_factors,
        *(
            np.asarray(value, dtype=float)
            for foot in feet
            for value in (*foot.H, *foot.lever, foot.restitution, foot.friction)
        ),
    )
    shape, count = broadcast[0].shape, len(feet)
    stationary = np.reshape(broadcast[:count], (count, -1))
    numbers = np.reshape(broadcast[count:], (count, 7, -1))
    _check_numbers(numbers)
    numbers[:, FRICTION] = np.maximum(numbers[:, FRICTION], MIN_FRICTION)
    speeds, loads, impulses = _bisect_speeds(
        np.ascontiguousarray(numbers.transpose(2, 0, 1)), stationary.min(axis=0), stationary.max(axis=0)
    )
    if np.isnan(speeds).any():
        raise TheoryError(
            f"feet at {_format_levers(numbers)} mm (x, y) from the centre of mass: their heights differ so much"
            " that friction tips the walker. There is no stationary speed. Level the feet."
        )
    impacts = (loads / impulses).T
    return Balance(
        speeds.reshape(shape),
        (impacts / impacts.sum(axis=0)).reshape(count, *shape),
        loads.T.reshape(count, *shape),
        "momentum and angular momentum balanced over "
        + ("both feet" if count == 2 else f"{count} feet, loaded as by equal springs"),
    )


def _check_numbers(numbers: Array) -> None:
    """Raise TheoryError for bad `numbers`, shape (feet, XX to FRICTION, draws), or a centre of mass beyond all feet."""
    xx, xy, yy, x = (numbers[:, column] for column in (XX, XY, YY, LEVER_X))
    if not np.isfinite(numbers).all():
        raise TheoryError("balance: tensors and levers of the feet must be finite numbers.")
    if not ((xx > 0) & (yy > 0) & (xx * yy > xy * xy)).all():
        raise TheoryError("balance: the inverse-mass tensor of every foot must be positive definite.")
    if not ((x.min(axis=0) < 0) & (x.max(axis=0) > 0)).all():
        raise TheoryError(
            f"feet at {_format_levers(numbers)} mm (x, y) from the centre of mass: the walker tips unless "
            "one foot is behind it and one in front (x < 0 < x). Move a leg or the centre of mass."
        )


def _format_levers(numbers: Array) -> str:
    """Return the levers (x, y) of the feet in the first draw as text, from `numbers` of shape (feet, 7, draws)."""
    return ", ".join(f"({x:.4g}, {y:.4g})" for x, y in numbers[:, (LEVER_X, LEVER_Y), 0])


@kernel
def _bisect_speeds(feet: Array, low: Array, high: Array) -> tuple[Array, Array, Array]:
    """Find the speed, between `low` and `high`, at which each draw's feet have no net horizontal force, by bisection.

    `feet`: shape (draws, feet, 7), columns XX to FRICTION. Returns speeds (draws,), shares of the load and normal
    impulses (draws, feet), for an impact speed w = 1. The speed is NaN where feet of different height cannot balance.
    Mirror images give mirrored numbers exactly.
    """
    draws, count = feet.shape[0], feet.shape[1]
    speeds, ratios, levers = np.empty(draws), np.empty(count), np.empty(count)
    loads, impulses = np.empty((draws, count)), np.empty((draws, count))
    for k in range(draws):
        below, above = low[k], high[k]
        resolved = EPSILON * max(abs(below), abs(above))
        while True:
            speed = 0.5 * (below + above)
            _fill_impulses(feet[k], speed, ratios, impulses[k])
            _fill_levers(feet[k], ratios, levers)
            if not levers.min() < 0.0 < levers.max():
                speed = np.nan
                break
            _fill_loads(levers, loads[k])
            net = 0.0  # eq. 4.3: sum N_i rho_i
            for i in range(count):
                net += loads[k, i] * ratios[i]
            if net == 0.0 or above - below <= resolved:
                break
            if net > 0.0:
                below = speed
            else:
                above = speed
        speeds[k] = speed
    return speeds, loads, impulses


@kernel
def _fill_impulses(feet: Array, speed: float, ratios: Array, impulses: Array) -> None:
    """Fill `ratios`, F_x / F_y, and `impulses`, F_y, both of shape (feet,), of feet that slide at `speed`.

    The impact speed is 1. `feet`: shape (feet, 7), with the columns XX to FRICTION.
    """
    for i, foot in enumerate(feet):
        hit = impact(foot[XX], foot[XY], foot[YY], speed, -1.0, foot[RESTITUTION], foot[FRICTION])
        impulses[i] = hit.F_y
        ratios[i] = hit.F_x / hit.F_y


@kernel
def _fill_levers(feet: Array, ratios: Array, levers: Array) -> None:
    """Fill `levers`, shape (feet,), with the x (mm) at which each impulse's line of action crosses the mean height.

    `feet`: shape (feet, 7); `ratios`: force ratios rho, shape (feet,).
    Where the net force vanishes, the height at which levers are taken does not matter.
    """
    height = 0.0
    for foot in feet:
        height += foot[LEVER_Y] / len(feet)
    for i, foot in enumerate(feet):
        # Eq. 4.3, with y_0 the feet's mean height
        levers[i] = foot[LEVER_X] - (foot[LEVER_Y] - height) * ratios[i]


@kernel
def _fill_loads(levers: Array, loads: Array) -> None:
    """Fill `loads`, shape (feet,), the shares nearest to equal ones that sum to 1, balance the `levers` and never pull.

    Least squares over the n feet on the ground: N_i = (S_2 - S_1 x_i) / (n S_2 - S_1^2), with S_1 and
    S_2 the sums of x and x^2. Feet that would pull are left out. They lie far out on one side,
    so that the others keep the sign of S_1 and lower |S_2 / S_1|: none would push again.
    """
    loads[:] = 1.0
    pulls = True
    while pulls:
        staying, first, second = 0, 0.0, 0.0
        for x, load in zip(levers, loads):  # noqa: B905  (numba knows no strict)
            if load > 0.0:
                staying += 1
                first += x
                second += x * x
        pulls = False
        for i, x in enumerate(levers):
            if loads[i] > 0.0:
                load = (second - first * x) / (staying * second - first * first)
                pulls = pulls or load < 0.0
                loads[i] = max(load, 0.0)
