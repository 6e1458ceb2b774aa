"""A finished walker, cut, gives back the design that it was made from."""

import math

import hostile_meshes as hostile
import numpy as np
import pytest

from walkergen.core.errors import GeometryError
from walkergen.core.walker import mass, solids
from walkergen.core.walker.design import Design
from walkergen.readers.meshes import faults
from walkergen.readers.walkers import body_mesh, leg_cutting
from walkergen.readers.walkers.body_mesh import ReadOptions

DENSITY = 1.24e-3


def design_of(kind, foot, tilt):
    return Design.model_validate({"legs": {"foot": foot}}).variant(tilt_deg=tilt, kind=kind)


@pytest.mark.parametrize("kind", ["flexible", "braced"])
@pytest.mark.parametrize("foot", ["flat", "square", "round"])
@pytest.mark.parametrize("tilt", [0.0, 10.0, -20.0, 40.0])
def test_a_cut_at_the_bottom_face_gives_back_the_design(kind, foot, tilt):
    """Coordinates are exact but for rounding; a round foot's lowest micrometre is 0.03 mm wide.

    Of that width the arc's vertices, 0.01 mm apart, show all but one on either side.
    """
    design = design_of(kind, foot, tilt)
    parts, limb = solids.build(design), design.limbs[0]
    found = leg_cutting.cut_legs(parts.walker, -limb.anchor_to_foot[1])
    assert len(found.legs) == 2
    slack = 2e-2 if foot == "round" else 1e-9
    body = mass.weigh(found.body, DENSITY)
    assert body.mass == pytest.approx(mass.weigh(parts.body, DENSITY).mass, rel=1e-12)
    whole = mass.weigh(parts.legs[0], DENSITY)
    half = math.atan2(limb.thickness, limb.length)  # a square foot stands on a side
    for leg, like in zip(found.legs, design.limbs, strict=True):
        assert mass.weigh(leg.mesh, DENSITY).mass == pytest.approx(whole.mass, rel=1e-9)
        np.testing.assert_allclose(leg.foot[:2] - leg.anchor[:2], like.anchor_to_foot, atol=slack)
        assert (leg.width, leg.z) == pytest.approx((8.0, 4.0), rel=1e-12)
        assert leg.length == pytest.approx(math.hypot(*like.anchor_to_foot), abs=slack)
        assert leg.struts == (2 if solids.has_window(like) else 1)
        if leg.struts == 2 or kind == "flexible":
            np.testing.assert_allclose(leg.anchor[:2], like.anchor, atol=1e-9)
            along = math.cos(leg.tilt) / math.cos(like.tilt)
            assert leg.thickness == pytest.approx(like.thickness * along, rel=1e-9)
        if foot == "flat":
            assert leg.tilt == pytest.approx(like.tilt, abs=1e-9)
            assert leg.length == pytest.approx(like.length, rel=1e-9)
        else:
            assert abs(leg.tilt - like.tilt) < half


def test_a_lower_cut_leaves_stumps_on_the_body():
    """A hundredth of the leg stays above the cut: the tilt is the same, length and mass follow."""
    design = design_of("flexible", "flat", 10.0)
    limb, walker = design.limbs[0], solids.build(design).walker
    found = leg_cutting.cut_legs(walker, 0.99 * -limb.anchor_to_foot[1])
    total = mass.weigh(walker, DENSITY).mass
    masses = [mass.weigh(mesh, DENSITY).mass for mesh in (found.body, *(f.mesh for f in found.legs))]
    assert sum(masses) == pytest.approx(total, rel=1e-13)
    assert masses[1] == pytest.approx(0.99 * 7.5 * 0.4 * 8.0 * DENSITY, rel=1e-10)
    for leg in found.legs:
        assert leg.tilt == pytest.approx(limb.tilt, abs=1e-10)
        assert leg.length == pytest.approx(0.99 * 7.5, rel=1e-10)


def test_through_a_file_of_32_bits(tmp_path):
    """STL keeps a coordinate of 14 mm to a millionth of a mm: angles of 7.5 mm to 1e-6 rad."""
    design = design_of("flexible", "flat", 17.0)
    path = hostile.to_stl(tmp_path / "whole.stl", solids.build(design).walker)
    # The file has our own axes: y up, z across
    read = body_mesh.read_body(path, ReadOptions(up="y", forward="x"), key="walker.mesh")
    assert read.changes == ()
    found = leg_cutting.cut_legs(read.mesh, 7.0)
    for leg in found.legs:
        assert leg.tilt == pytest.approx(design.limbs[0].tilt, abs=1e-6)
        assert leg.thickness == pytest.approx(0.4, abs=2e-6)
        faults.check_solid(leg.mesh, "leg")
    spacing = found.legs[1].foot[0] - found.legs[0].foot[0]
    assert spacing == pytest.approx(13.0, abs=2e-6)


def test_a_table_has_four_legs_in_order():
    tops = hostile.box(20.0, 2.0, 12.0)
    spots = [(x, -3.0, z) for x in (-8.0, 8.0) for z in (-4.0, 4.0)]
    legs = [hostile.box(1.0, 5.0, 2.0, spot) for spot in spots]
    from walkergen.core.shapes import joining

    found = leg_cutting.cut_legs(joining.unite_with_legs(joining.prepare_body(tops), legs), 4.0)
    places = [(round(leg.foot[0], 9), round(leg.z, 9)) for leg in found.legs]
    assert places == [(x, z) for x, _, z in spots]
    for leg in found.legs:
        assert (leg.thickness, leg.width, leg.length) == pytest.approx((1.0, 2.0, 4.0))


def test_cuts_that_make_no_walker_are_refused():
    walker = solids.build(design_of("flexible", "flat", 10.0)).walker
    for height in (0.0, -1.0, 10.4, math.nan, math.inf):
        with pytest.raises(GeometryError, match=r"legs_below_mm = .*: must lie in 0..10.39 mm"):
            leg_cutting.cut_legs(walker, height)
    upside_down = body_mesh.rotation("-y", "x", "key")
    turned = walker._replace(vertices=walker.vertices @ upside_down.T)
    with pytest.raises(GeometryError, match="above it are 2 pieces, must be one body"):
        leg_cutting.cut_legs(turned, 5.0)
