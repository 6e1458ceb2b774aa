"""Laws of one instant: the cascade of one foot, and landings of both."""

import numpy as np
import pytest
from scipy.optimize import brentq

from walkergen.kernels import kernel
from walkergen.mass import MassProperties
from walkergen.simulation import record
from walkergen.simulation.plate import Contact, Plate
from walkergen.simulation.relaxed import walker as walkers
from walkergen.simulation.relaxed.cascade import cascade
from walkergen.simulation.relaxed.landing import land
from walkergen.simulation.relaxed.walker import OMEGA, PITCH, V_X, V_Y, Tensor, Walker
from walkergen.theory.impact import impact
from walkergen.theory.tensors import feet, rigid

BODY = 28.0 * 8.0 * 3.0 * 1.24e-3
REST = Plate(0.0, 2 * np.pi * 90, None)
CORNERS = ((-14.0, -1.5), (14.0, -1.5), (-14.0, 1.5), (14.0, 1.5))


def masses(tilt_deg: float, leg: float = 0.02976) -> MassProperties:
    tilt = np.radians(tilt_deg)
    c = 3.75 * np.array([-np.sin(tilt), -np.cos(tilt)])
    a = np.array([-6.5 + 7.5 * np.sin(tilt), -1.5])
    J = BODY * (28.0**2 + 9.0) / 12
    return MassProperties(
        BODY, J, leg, leg * 7.5**2 / 12, a, a + np.array([13.0, 0.0]), c, c, False
    )


def walker(tilt_deg: float, flexible: bool = True, leg: float = 0.02976) -> Walker:
    mass = masses(tilt_deg, leg)
    d_y = float(mass.a[1] + 2 * mass.c_A[1])
    tensors = feet(mass) if flexible else None
    return walkers.new(mass.M, mass.J, (-6.5, d_y), (6.5, d_y), CORNERS, tensors)


def tensors(tilt_deg: float, leg: float = 0.02976) -> list[tuple[Tensor, Tensor]]:
    """(flexible, rigid) of the back and of the front foot."""
    mass, pairs = masses(tilt_deg, leg), []
    for own, anchor in zip(feet(mass), (mass.a, mass.b), strict=True):
        H = rigid(mass.M, mass.J, anchor + 2 * mass.c_A)
        pairs.append(
            (
                Tensor(float(own.xx), float(own.xy), float(own.yy)),
                Tensor(float(H.xx), float(H.xy), float(H.yy)),
            )
        )
    return pairs


def run(own, H, v_x, contact, v_y=-1.0):
    counts = np.zeros(9, np.int64)
    return cascade(own, H, float(v_x), v_y, contact, counts), int(counts[0])


@kernel
def one_by_one(own, H, v_x, v_y, contact, most):
    """The cascade summed impact by impact; its last approach."""
    F_x, F_y = 0.0, 0.0
    for _ in range(most):
        hit = impact(
            own.xx, own.xy, own.yy, v_x, v_y, contact.restitution, contact.friction, contact.law
        )
        v_x += H.xx * hit.F_x + H.xy * hit.F_y
        v_y += H.xy * hit.F_x + H.yy * hit.F_y
        F_x, F_y = F_x + hit.F_x, F_y + hit.F_y
        if v_y >= -1e-14:
            break
    return F_x, F_y, v_x, v_y


@pytest.mark.parametrize("law", [0, 1, 2])
def test_cascade_is_the_sum_of_its_impacts(law):
    rng = np.random.default_rng(law)
    for _ in range(4000):
        own, H = tensors(rng.uniform(-60, 60), 10 ** rng.uniform(-3, 0))[rng.integers(2)]
        mu = rng.choice([0.0, 10 ** rng.uniform(-2, 3)])
        contact = Contact(float(rng.choice([0.0, 1.0, rng.uniform()])), float(mu), law)
        v_x = rng.choice([0.0, rng.normal() * 10 ** rng.uniform(-2, 2)])
        landing, _ = run(own, H, v_x, contact)
        assert landing.finished
        F_x, F_y, _, v_y = one_by_one(own, H, float(v_x), -1.0, contact, 3_000_000)
        assert v_y >= -1e-14
        # the sum is cut at an approach of 1e-14; 1e5 roundings of it
        assert np.hypot(landing.F_x - F_x, landing.F_y - F_y) <= 1e-9 * np.hypot(F_x, F_y)


def test_landing_ends_without_approach_and_inside_the_friction_cone():
    rng = np.random.default_rng(7)
    for _ in range(20_000):
        own, H = tensors(rng.uniform(-80, 80), 10 ** rng.uniform(-10, 3))[rng.integers(2)]
        mu = float(rng.choice([0.0, 5.0, 1e3, rng.uniform(0, 1)]))
        contact = Contact(float(rng.choice([0.0, 1.0, 0.8])), mu, 0)
        v_x = float(rng.choice([0.0, rng.normal() * 10 ** rng.uniform(-3, 3)]))
        landing, impacts = run(own, H, v_x, contact)
        assert landing.finished
        assert landing.v_y >= 0.0
        assert abs(landing.F_x) <= mu * landing.F_y * (1 + 1e-9)  # rounding of H^-1
        assert impacts < 10_000  # finite work also for legs of 1e-10 g, with 1e10 impacts
        if mu == 0.0:
            assert landing.F_x == 0.0


def test_cascade_of_a_mirror_image_is_the_mirror_image():
    rng = np.random.default_rng(3)
    for _ in range(3000):
        own, H = tensors(rng.uniform(-60, 60), 10 ** rng.uniform(-4, 0))[0]
        contact = Contact(float(rng.uniform()), float(10 ** rng.uniform(-2, 2)), 0)
        v_x = float(rng.normal())
        seen, _ = run(own, H, v_x, contact)
        other, _ = run(own._replace(xy=-own.xy), H._replace(xy=-H.xy), -v_x, contact)
        assert (other.F_x, other.F_y, other.v_x) == (-seen.F_x, seen.F_y, -seen.v_x)


@pytest.mark.parametrize(("tilt", "back", "front"), [(10, 3.41, 2.73), (35, 0.78, 0.28)])
def test_stationary_speed_of_the_whole_landing(tilt, back, front):
    """Where the horizontal impulse of a whole landing vanishes (physics.md section 5)."""
    for (own, H), expected in zip(tensors(tilt), (back, front), strict=True):
        speed = brentq(
            lambda v, own=own, H=H: run(own, H, v, Contact(0.9, 0.1, 0))[0].F_x, 1e-6, 20.0
        )
        assert speed == pytest.approx(expected, abs=0.005)  # published to two digits


def test_scheme_gains_energy_only_for_small_tilts_and_high_restitution():
    def gain(tilt, e):
        own, H = tensors(tilt)[0]
        landing, _ = run(own, H, 1e-3, Contact(e, 0.1, 0))
        F = np.array([landing.F_x, landing.F_y])
        return F @ np.array([1e-3 + landing.v_x, landing.v_y - 1.0])

    assert gain(1.0, 0.99) > 0.0
    assert gain(1.0, 0.8) < 0.0
    assert gain(10.0, 0.99) < 0.0


def landed(w, contact, v_x, v_y, Omega, pitch=0.0):
    options = walkers.options_for(w, REST)
    state = walkers.level_state(w, REST)
    state[V_X], state[V_Y], state[OMEGA] = v_x, v_y, Omega
    if pitch:
        state[PITCH] = pitch
        lowest = min(
            walkers.lever(d, np.sin(pitch), np.cos(pitch))[1] for d in (w.d_back, w.d_front)
        )
        state[walkers.Y] = -lowest
    tally = record.new(9)
    assert land(w, REST, contact, options, state, 0.0, tally)
    return state, tally


def foot_speeds(w, state):
    sin, cos = np.sin(state[PITCH]), np.cos(state[PITCH])
    return [
        state[V_Y] + state[OMEGA] * walkers.lever(d, sin, cos)[0] for d in (w.d_back, w.d_front)
    ]


def mirrored(w: Walker) -> Walker:
    def flip(d):
        return (-d[0], d[1])

    flexible = w.flexible and walkers.FlexibleTensors(
        w.flexible.front._replace(xy=-w.flexible.front.xy),
        w.flexible.back._replace(xy=-w.flexible.back.xy),
    )
    corners = tuple(flip(c) for c in (w.corners[1], w.corners[0], w.corners[3], w.corners[2]))
    return w._replace(
        d_back=flip(w.d_front), d_front=flip(w.d_back), corners=corners, flexible=flexible
    )


@pytest.mark.parametrize("flexible", [True, False])
def test_two_feet_end_quiet_without_gaining_energy_and_without_numbering(flexible):
    rng = np.random.default_rng(11)
    for _ in range(3000):
        w = walker(rng.uniform(5, 35), flexible)
        mu = float(rng.choice([0.0, 0.1, 0.25, 5.0, 1e3]))
        contact = Contact(float(rng.choice([0.0, 1.0, 0.8])), mu, 2)
        start = rng.normal() * 30, -30 * rng.uniform(), rng.normal() * 3
        state, tally = landed(w, contact, *start)
        assert min(foot_speeds(w, state)) >= -walkers.options_for(w, REST).snap_speed
        scale = 0.5 * BODY * (start[0] ** 2 + start[1] ** 2)
        if not flexible:  # Stronge's law never creates energy, nor does the rule for two feet
            assert tally.sums[record.IMPACT_LOSS] >= -1e-9 * scale
        other, _ = landed(mirrored(w), contact, -start[0], start[1], -start[2])
        sign = np.array([-1, 1, -1, -1, 1, -1])
        assert np.array_equal(other[:6], sign * state[:6])


def test_level_landing_has_the_restitution_of_a_foot_and_no_preference():
    for e in (0.0, 0.5, 1.0):
        for friction in (0.0, 0.3):
            for flexible in (True, False):
                w = walker(0.0, flexible)
                state, _ = landed(w, Contact(e, friction, 0), 0.0, -20.0, 0.0)
                assert state[V_X] == 0.0
                assert state[OMEGA] == 0.0
                if friction == 0.0 and not flexible:
                    assert state[V_Y] == pytest.approx(20.0 * e, abs=1e-12)


def test_no_friction_no_horizontal_impulse():
    state, _ = landed(walker(10.0), Contact(0.8, 0.0, 0), 1e-5, -20.0, 1.0)
    assert state[V_X] == 1e-5


def test_jammed_foot_stops_at_once():
    """Sliding with mu > H_yy/|H_xy| = 1.8: its normal force would press it ever harder down."""
    w = walker(0.0, flexible=False)
    for v_x in (-10.0, 10.0):
        state, _ = landed(w, Contact(0.0, 5.0, 0), v_x, 0.0, 0.0, pitch=1e-3)
        r = walkers.lever(w.d_back, np.sin(1e-3), np.cos(1e-3))
        assert np.all(np.isfinite(state))
        if -r[0] * r[1] * v_x < 0:
            continue  # slides on
        assert state[V_X] - state[OMEGA] * r[1] == pytest.approx(0.0, abs=1e-12)
        assert state[V_Y] + state[OMEGA] * r[0] == pytest.approx(0.0, abs=1e-12)
