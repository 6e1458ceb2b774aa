"""Hard cases of a single impact."""

import itertools
import math
from collections.abc import Iterator
from fractions import Fraction

import numpy as np

from walkergen.commands.selftest import exact_impact
from walkergen.commands.selftest.case import IMPACT_LAW, Case, Check, check_fact
from walkergen.commands.selftest.scenes import LEG_LENGTH_MM, masses, paper_design
from walkergen.core.theory import speed
from walkergen.core.theory.impact import Impact, Kind, determinant, energy_change, resolve
from walkergen.core.theory.tensors import InverseMass, foot_tensors, rigid_tensor

ROUNDING_REASON = "rounding of some ten operations, times the tensor's condition (up to 1e4)"


def _random_impacts(count: int, seed: int) -> Iterator[tuple[exact_impact.Tensor, tuple[float, float], float, float]]:
    """Yield random impacts: inverse mass (xx, xy, yy), velocity (x, y), restitution e and friction mu.

    Conditions are up to 1e4, sliding speeds any, and e and mu include both ends.
    """
    rng = np.random.default_rng(seed)
    for _ in range(count):
        root = rng.normal(size=(2, 2))
        h = root @ root.T
        h += 1e-4 * np.trace(h) * np.eye(2)
        v_x = float(rng.choice([0.0, rng.normal(), 0.05 * rng.normal()]))
        e = float(rng.choice([0.0, 1.0, rng.uniform()]))
        mu = float(rng.choice([0.0, 5.0, 1e3, 10 ** rng.uniform(-2, 1)]))
        H = (float(h[0, 0]), float(h[0, 1]), float(h[1, 1]))
        yield H, (v_x, -float(rng.uniform(0.1, 1.0))), e, mu


def _relative_error(impact: Impact, expected: tuple[Fraction, ...], speed_before: float) -> float:
    """Return the largest difference from the exact impact (F_x, F_y, v_x, v_y), over impulse and speed."""
    F_x, F_y, v_x, v_y = expected
    impulse = float(max(abs(F_x), F_y))
    return max(
        float(abs(Fraction(impact.F_x) - F_x)) / impulse,
        float(abs(Fraction(impact.F_y) - F_y)) / impulse,
        float(abs(Fraction(impact.v_x) - v_x)) / speed_before,
        float(abs(Fraction(impact.v_y) - v_y)) / speed_before,
    )


def _check_against_exact() -> Iterator[Check]:
    """Check 400 random impacts against exact rational arithmetic."""
    worst, kinds = 0.0, set()
    for H, v, e, mu in _random_impacts(400, seed=1):
        impact = resolve(H, v, e, mu)
        worst = max(worst, _relative_error(impact, exact_impact.resolve_impact(H, v, e, mu), math.hypot(*v)))
        kinds.add((impact.kind, impact.sticks))
    yield Check("400 impacts in exact fractions", worst, 1e-9, ROUNDING_REASON)
    yield check_fact(
        "every type of impact met, stuck and slipping",
        {kind for kind, _ in kinds} >= {*Kind} - {Kind.NONE} and len(kinds) >= 10,
    )


def _check_no_friction() -> Iterator[Check]:
    """Check that impacts without friction have no horizontal impulse."""
    sideways = 0.0
    for H, v, e, _ in _random_impacts(200, seed=5):
        sideways = max(sideways, abs(resolve(H, v, e, 0.0).F_x))
    yield Check("horizontal impulse", sideways, 0.0, "exact: 0 times the normal impulse")


def _check_jamming() -> Iterator[Check]:
    """Check sliding that presses the foot down increasingly, until it stops and sticks."""
    H, mu, e = (1.0, -0.9, 1.0), 2.0, 0.5
    out = resolve(H, (-0.5, -1.0), e, mu)
    stop = 0.5 / (mu * H[0] + H[1])
    v_stop = -1.0 + (H[2] + mu * H[1]) * stop
    stuck = (H[0] * H[2] - H[1] ** 2) / H[0]
    expected = (1 + e) * (stop - v_stop / stuck)
    yield check_fact(
        "slip stops while pressed, then sticks", out.kind == Kind.III_MIRRORED and bool(out.sticks) and out.v_x == 0.0
    )
    yield Check(
        "normal impulse against the closed form", abs(out.F_y / expected - 1), 1e-13, "rounding of some ten operations"
    )
    just_out = resolve(H, (-0.5, -1.0), e, H[2] / -H[1] * (1 - 1e-12))
    yield check_fact("finite at the border of jamming", math.isfinite(just_out.F_y))


def _rod_tensor(angle: float) -> exact_impact.Tensor:
    """Return the inverse mass at the lower end of a rod of 1 g and 2 mm, `angle` (rad) from the plate."""
    H = rigid_tensor(1.0, 1.0 / 3.0, np.array([math.cos(angle), -math.sin(angle)]))
    return float(H.xx), float(H.xy), float(H.yy)


def _check_painleve_rod() -> Iterator[Check]:
    """Check a rod whose slip presses its end down increasingly: the slip stops in a tangential impact.

    Forces alone have no solution there, or two. The impulse is unique for any speed of approach.
    """
    angles = np.radians(np.linspace(20.0, 85.0, 6501))
    least = [xx[2] / abs(xx[1]) for xx in map(_rod_tensor, angles)]
    yield Check(
        "least friction that jams a rod, against 4/3", abs(min(least) - 4.0 / 3.0), 1e-7, "angles 0.01 deg apart"
    )
    there = math.degrees(angles[int(np.argmin(least))] - math.atan(2.0))
    yield Check("where: tan = 2, deg", abs(there), 0.01, "angles 0.01 deg apart")
    for mu, degrees in itertools.product((2.0, 10.0), (50.0, 63.4, 72.0, 80.0)):
        xx, xy, yy = H = _rod_tensor(math.radians(degrees))
        if mu * xy <= yy:
            continue
        worst = gain = 0.0
        for e, w in itertools.product((0.0, 0.5, 1.0), (1e-300, 1e-12, 1.0)):
            stop = 1.0 / (mu * xx - xy)  # impulse at which the slip of 1 mm/s has stopped
            stuck = (xx * yy - xy * xy) / xx
            expected = (1.0 + e) * (stop + (w + (mu * xy - yy) * stop) / stuck)
            out = resolve(H, (1.0, -w), e, mu)
            gain = max(gain, energy_change((1.0, -w), out))
            worst = max(worst, abs(out.F_y / expected - 1.0), abs(out.v_x))
        title = f"mu = {mu:g}, {degrees:g} deg"
        yield Check(f"{title}: normal impulse against the closed form", worst, 1e-12, ROUNDING_REASON)
        yield Check(f"{title}: energy gained, of 0.5 at most", gain, 1e-14, "rounding of the works' sum")


def _check_singular_tensor() -> Iterator[Check]:
    """Check the impulse that stops a foot held by friction, for inverse masses of condition 1e8 to 1e12."""
    worst = det = 0.0
    for condition in (1e8, 1e10, 1e12):
        x = 1.0 / 3.0
        H = (x, x, x * (1 + 4 / condition))
        xx, xy, yy = (Fraction(entry) for entry in H)
        true = float(xx * yy - xy * xy)
        det = max(det, abs(determinant(*H) / true - 1))
        out = resolve(H, (0.1, -1.0), 0.0, 1e15)  # restitution 0; friction has no limit
        left_x = 0.1 + float(xx * Fraction(out.F_x) + xy * Fraction(out.F_y))
        left_y = -1.0 + float(xy * Fraction(out.F_x) + yy * Fraction(out.F_y))
        worst = max(worst, math.hypot(left_x, left_y) / (abs(out.F_y) * x))
    yield Check("determinant against exact fractions", det, 1e-14, "rounding of the result")
    yield Check("speed left, over H F", worst, 1e-15, "rounding of the impulse itself")


def _check_energy() -> Iterator[Check]:
    """Check that random impacts gain no energy."""
    for e, count, seed in ((1.0, 600, 3), (0.0, 200, 4)):
        gain = 0.0
        for H, v, _, mu in _random_impacts(count, seed):
            out = resolve(H, v, e, mu)
            gain = max(gain, energy_change(v, out) / (math.hypot(*v) * out.F_y))
        yield Check(f"energy gained at e = {e:g}", gain, 1e-12, "rounding of the works' sum")


def _check_stationary_speed() -> Iterator[Check]:
    """Check that an impact at the closed form's speed gives no horizontal impulse."""
    worst, third = 0.0, True
    for H, _, e, mu in _random_impacts(400, seed=9):
        if mu == 0.0:
            continue
        v_x = float(speed.factor(InverseMass(*H), e, mu))
        out = resolve(H, (v_x, -1.0), e, mu)
        # rounding of v_x alone moves F_x by mu F_y eps v_x / v_x
        worst = max(worst, abs(out.F_x) / (out.F_y * max(mu, 1.0)))
        third = third and (abs(out.kind) in (3, 5) or e == 1.0)  # e = 1: a tie with II
    yield Check("horizontal over normal impulse", worst, 1e-10, ROUNDING_REASON)
    yield check_fact("always type III", third)


def _check_upright_walker() -> Iterator[Check]:
    """Check by symmetry: the feet of an upright walker push in opposite directions."""

    def factors(tilt: float, e: float, mu: float) -> speed.Factors:
        """Return the feet's speeds at a tilt (deg), over w, the speed at which they meet the plate."""
        return speed.factors(masses(paper_design(tilt)), e, mu)

    mean = odd = jump = 0.0
    for e in (0.0, 0.8, 1.0):
        for mu in (0.0, 0.1, 5.0, 1e3):
            at_zero = factors(0.0, e, mu)
            mean = max(mean, abs(float(at_zero.mean)))
            right, left = factors(1e-12, e, mu), factors(-1e-12, e, mu)
            odd = max(odd, abs(float(right.mean + left.mean)))
            if mu > 0.0:
                jump = max(jump, abs(float(right.mean)) / (1.0 + abs(float(at_zero.feet[0]))))
    yield Check("mean speed of the feet at tilt 0, over w", mean, 0.0, "exact: mirror images")
    yield Check("mean at +-1e-12 deg, summed", odd, 0.0, "exact: mirror images")
    yield Check("mean at 1e-12 deg, over w", jump, 1e-9, "speed grows by at most 1e3 per degree below 0.05 deg")


def _check_mirror_image() -> Iterator[Check]:
    """Check that mirrored impacts give the mirrored impulse and velocity."""
    worst = 0.0
    for (xx, xy, yy), (v_x, v_y), e, mu in _random_impacts(300, seed=6):
        out = resolve((xx, xy, yy), (v_x, v_y), e, mu)
        image = resolve((xx, -xy, yy), (-v_x, v_y), e, mu)
        worst = max(
            worst,
            abs(image.F_x + out.F_x),
            abs(image.F_y - out.F_y),
            abs(image.v_x + out.v_x),
            abs(image.v_y - out.v_y),
        )
    yield Check("impulse and velocity of the mirror image", worst, 0.0, "exact: only signs differ")


def _check_leg_masses() -> Iterator[Check]:
    """Check a foot's inverse mass H: H m / 3 -> P(c) / |c|^2 for light legs (docs/physics.md section 2), H > 0."""
    design = paper_design(10.0)
    reach = np.array(design.limbs[0].anchor_to_foot)
    worst, least = 0.0, math.inf
    for ratio in (1e-9, 1e-6, 1e-3, 1.0, 1e3):
        walker_mass = masses(design, leg_mass=0.833 * ratio)
        H = foot_tensors(walker_mass)[0]
        least = min(least, determinant(float(H.xx), float(H.xy), float(H.yy)))
        if ratio <= 1e-6:
            m, M = float(walker_mass.legs[0].m), float(walker_mass.M)
            scaled = np.array([H.xx, H.xy, H.yy]) * m / 3.0
            limit = np.array([reach[1] ** 2, -reach[0] * reach[1], reach[0] ** 2]) / LEG_LENGTH_MM**2
            worst = max(worst, float(abs(scaled - limit).max()) * M / m)
    yield Check(
        "distance from the light leg's limit, over m/M",
        worst,
        2.0,
        "the next order of the limit is m/M times the body's own mobility",
    )
    yield check_fact("positive definite for m/M of 1e-9 to 1e3", least > 0.0)


def _check_speed_scaling() -> Iterator[Check]:
    """Check that an impact scales with its speed to the last digit."""
    same = 0
    for H, v, e, mu in _random_impacts(40, seed=8):
        out = resolve(H, v, e, mu)
        for n in (-990, -600, -300, 300, 600, 990):
            slow = resolve(H, (math.ldexp(v[0], n), math.ldexp(v[1], n)), e, mu)
            grown = (math.ldexp(component, -n) for component in slow[:4])  # impulse and velocity
            same += (*grown, *slow[4:]) == tuple(out)
    yield check_fact("240 impacts of 1e-298 to 1e298 mm/s", same == 240)


CASES = [
    Case(
        "one impact at any speed",
        "6.3",
        "dimensional analysis: an impact is homogeneous in speed",
        IMPACT_LAW,
        _check_speed_scaling,
    ),
    Case("upright walker: closed-form speeds", "6.1", "mirror symmetry", IMPACT_LAW, _check_upright_walker),
    Case("no friction: one impact", "6.2", "Coulomb at mu = 0", IMPACT_LAW, _check_no_friction),
    Case("jamming: one impact", "6.2", "Painleve 1895: an impact stops the slip; Coulomb", IMPACT_LAW, _check_jamming),
    Case(
        "painleve: a rod that slides and jams",
        "6.2",
        "Painleve 1895: mu >= 4/3 at tan = 2",
        IMPACT_LAW,
        _check_painleve_rod,
    ),
    Case("impact law in exact fractions", "6.3", "exact rational arithmetic", IMPACT_LAW, _check_against_exact),
    Case("nearly singular tensor", "6.3", "exact rational arithmetic", IMPACT_LAW, _check_singular_tensor),
    Case(
        "stationary speed at any e and friction",
        "6.3",
        "Koumakis et al. 2016, eq. 15: no horizontal impulse",
        IMPACT_LAW,
        _check_stationary_speed,
    ),
    Case("energy in one impact", "6.4", "Poisson: no gain at e <= 1", IMPACT_LAW, _check_energy),
    Case(
        "legs of any mass: tensor",
        "6.5",
        "Routh: a thin rod's inertia about its hinge, m l^2 / 3",
        IMPACT_LAW,
        _check_leg_masses,
    ),
    Case("mirror image: one impact", "6.13", "mirror symmetry", IMPACT_LAW, _check_mirror_image),
]
