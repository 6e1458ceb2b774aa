"""Mass properties against closed forms, translated and scaled; the solids' own shapes."""

import mpmath as mp
import numpy as np
import pytest

from walkergen.core.walker import mass, names, solids
from walkergen.core.walker.design import Design

mp.mp.dps = 50
DENSITY = 1.24e-3


def polygon_moments(points):
    """Area, centroid and polar second moment about it of a polygon, in 50 digits."""
    points = [(mp.mpf(float(x)), mp.mpf(float(y))) for x, y in points]
    A = X = Y = inertia = mp.mpf(0)
    for (x0, y0), (x1, y1) in zip(points, points[1:] + points[:1], strict=True):
        c = x0 * y1 - x1 * y0
        A += c / 2
        X += (x0 + x1) * c / 6
        Y += (y0 + y1) * c / 6
        inertia += (x0**2 + x0 * x1 + x1**2 + y0**2 + y0 * y1 + y1**2) * c / 12
    X, Y = X / A, Y / A
    return A, (X, Y), inertia - A * (X**2 + Y**2)


def variants():
    for foot in ("flat", "square"):
        for tilt in (0.0, 1e-12, 5.0, 10.0, 45.0, -20.0):
            yield Design.model_validate({"legs": {"foot": foot, "tilt_deg": tilt}})


def leg_polygon(design):
    """The leg's outline from the design, in 50 digits and without the modeller."""
    tilt = mp.mpf(design.tilt_deg) * mp.pi / 180
    limb = design.limbs[0]
    s, length = mp.mpf(limb.thickness), mp.mpf(limb.length)
    sin, cos = mp.sin(tilt), mp.cos(tilt)
    top = s / (2 * cos)
    across = (top, mp.mpf(0)) if limb.foot == "flat" else (s / 2 * cos, -s / 2 * sin)
    tip = (-length * sin, -length * cos)
    return [
        (-top, mp.mpf(0)),
        (tip[0] - across[0], tip[1] - across[1]),
        (tip[0] + across[0], tip[1] + across[1]),
        (top, mp.mpf(0)),
    ]


@pytest.mark.parametrize("design", list(variants()), ids=names.part_name)
def test_flexible_walker_against_closed_forms(design):
    found = solids.mass_of(design)
    depth = design.size.depth
    assert found.M == pytest.approx(28 * 8 * 3 * DENSITY, rel=1e-12)
    assert found.J == pytest.approx(found.M * (28**2 + 3**2) / 12, rel=1e-12)
    area, centre, second = polygon_moments(leg_polygon(design))
    # Both feet on the plate, symmetric about the middle, at any tilt.
    for leg, x in zip(found.legs, (-6.5, 6.5), strict=True):
        assert leg.m == pytest.approx(float(area) * depth * DENSITY, rel=1e-12)
        assert leg.m == pytest.approx(7.5 * 0.4 * 8 * DENSITY, rel=1e-12)
        assert leg.j == pytest.approx(float(second) * depth * DENSITY, rel=1e-11)
        np.testing.assert_allclose(leg.c_A, np.array(centre, dtype=float), atol=1e-12)
        assert leg.foot[0] == pytest.approx(x, abs=1e-12)


@pytest.mark.parametrize("tilt", [0.0, 3.0, 10.0, 35.0])
def test_braced_walker_is_one_rigid_body(tilt):
    """Rival: weigh the printable union."""
    design = Design().variant(tilt_deg=tilt, kind="braced")
    built = solids.build(design)
    found, whole = solids.weigh(design, built), mass.weigh(built.walker, DENSITY)
    assert found.M == pytest.approx(whole.mass, rel=1e-12)
    assert found.J == pytest.approx(whole.inertia, rel=1e-12)
    lowest = built.walker.vertices[:, 1].min()
    for leg, x in zip(found.legs, (-6.5, 6.5), strict=True):
        np.testing.assert_allclose(whole.centre[:2] + leg.foot, [x, lowest], atol=1e-12)
        assert (leg.m, leg.j) == (0.0, 0.0)
    assert found.rigid


def test_weighed_masses_override_and_rescale():
    weighed = {"body_mass_g": 1.0, "leg_mass_g": 0.05}
    for kind in ("flexible", "braced"):
        plain = Design.model_validate({"legs": {"kind": kind}})
        heavy = Design.model_validate({"legs": {"kind": kind}, "weighed": weighed})
        built = solids.build(plain)
        a, b = solids.weigh(plain, built), solids.weigh(heavy, built)
        if kind == "flexible":
            assert b.M == 1.0
            assert pytest.approx(a.J * 1.0 / a.M, rel=1e-14) == b.J
            for meshed, leg in zip(a.legs, b.legs, strict=True):
                assert leg.m == 0.05
                assert pytest.approx(meshed.j * 0.05 / meshed.m, rel=1e-14) == leg.j
        else:
            # Closed form: masses at their centres; the union adds nothing to its three parts.
            body, leg = (mass.weigh(mesh, 1.0) for mesh in (built.body, built.legs[0]))
            inertias = [1.0 * body.inertia / body.mass] + [0.05 * leg.inertia / leg.mass] * 2
            masses = np.array([1.0, 0.05, 0.05])
            legs = [np.add(limb.anchor, leg.centre[:2]) for limb in plain.limbs]
            places = np.array([body.centre[:2], *legs])
            places -= masses @ places / masses.sum()
            J = sum(inertias) + masses @ (places**2).sum(axis=1)
            assert pytest.approx(1.1, rel=1e-14) == b.M
            assert pytest.approx(J, rel=1e-12) == b.J
