"""The landing of one foot on relaxed legs: its published speeds, and where it gains energy."""

import numpy as np
import pytest
from scipy.optimize import brentq

from walkergen.jobs.trust.selftest.scenes import design_of, masses
from walkergen.simulation.relaxed.cascade import cascade
from walkergen.simulation.relaxed.state import Tensor
from walkergen.simulation.world import Contact
from walkergen.theory.tensors import feet, rigid


def tensors(tilt_deg):
    """(flexible, rigid) of the back and of the front foot."""
    mass, pairs = masses(design_of("relaxed", tilt_deg)), []
    for own, leg in zip(feet(mass), mass.legs, strict=True):
        H = rigid(mass.M, mass.J, leg.anchor + 2 * leg.c_A)
        pairs.append((Tensor(*map(float, own)), Tensor(*map(float, H))))
    return pairs


def run(own, H, v_x, contact, v_y=-1.0):
    counts = np.zeros(9, np.int64)
    return cascade(own, H, float(v_x), v_y, contact, counts), int(counts[0])


@pytest.mark.parametrize(("tilt", "back", "front"), [(10, 3.41, 2.73), (35, 0.78, 0.28)])
def test_stationary_speed_of_the_whole_landing(tilt, back, front):
    """Where the horizontal impulse of a whole landing vanishes (docs/physics.md section 5)."""
    for (own, H), expected in zip(tensors(tilt), (back, front), strict=True):
        speed = brentq(lambda v, own=own, H=H: run(own, H, v, Contact(0.9, 0.1, 0))[0].F_x, 1e-6, 20.0)
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
