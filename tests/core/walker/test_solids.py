"""Every printable mesh is one closed body, outward, of the right genus and volume."""

import re

import mesh_checks
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from walkergen.core.errors import GeometryError
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design

FEET = ("flat", "square", "round")


@pytest.mark.parametrize("foot", FEET)
@pytest.mark.parametrize("kind", ["flexible", "braced"])
def test_the_family_is_sound(foot, kind):
    design = Design.model_validate({"legs": {"foot": foot}})
    for tilt in (0.0, 1e-12, -1e-12, 0.5, 5.0, 10.0, 30.0, 45.0, -10.0):
        mesh_checks.check(design.variant(tilt_deg=tilt, kind=kind))


@pytest.mark.parametrize("foot", FEET)
def test_feet_are_the_lowest_points_where_the_design_says(foot):
    for tilt in (-30.0, -5.0, 0.0, 5.0, 10.0, 45.0):
        design = Design.model_validate({"legs": {"foot": foot, "tilt_deg": tilt}})
        vertices = solids.build(design).walker.vertices
        lowest = vertices[:, 1].min()
        for limb, x in zip(design.limbs, (-6.5, 6.5), strict=True):
            foot_x, foot_y = np.array(limb.anchor) + limb.anchor_to_foot
            assert foot_x == pytest.approx(x, abs=1e-12)
            assert foot_y == pytest.approx(lowest, abs=1e-12)
            if foot != "flat" and tilt != 0.0:  # a point; a flat foot's is the middle of its edge
                touching = vertices[vertices[:, 1] < lowest + 1e-9]
                assert np.abs(touching[:, 0] - x).min() < 1e-9


def test_coordinates_keep_all_their_digits():
    """manifold3d's 2D booleans snap to 1e-8; ours must not."""
    design = Design.model_validate({"body": {"length_mm": 28 + 1 / 3}})
    x = solids.build(design).walker.vertices[:, 0].max()
    assert x == pytest.approx((28 + 1 / 3) / 2, abs=1e-14)


lengths = st.floats(0.05, 30.0)


@settings(max_examples=300, deadline=None, derandomize=True)
@given(
    body=st.tuples(st.floats(2.0, 60.0), st.floats(0.01, 30.0), st.floats(0.01, 10.0)),
    legs=st.tuples(lengths, lengths, st.floats(0.05, 3.0), st.floats(0.05, 3.0)),
    brace=st.floats(0.05, 2.0),
    tilt=st.one_of(st.sampled_from([0.0, 1e-12, -1e-9]), st.floats(-85.0, 85.0).filter(lambda deg: abs(deg) >= 1e-12)),
    kind=st.sampled_from(["flexible", "braced"]),
    foot=st.sampled_from(FEET),
    scale=st.sampled_from([1e-3, 1.0, 1e3]),
)
def test_any_design_is_sound_or_refused_with_a_reason(body, legs, brace, tilt, kind, foot, scale):
    data = {
        "body": dict(zip(("length_mm", "depth_mm", "thickness_mm"), (scale * v for v in body), strict=True)),
        "legs": {
            "kind": kind,
            "tilt_deg": tilt,
            "foot": foot,
            "length_mm": scale * legs[0],
            "contact_spacing_mm": scale * legs[1],
            "flexible_thickness_mm": scale * legs[2],
            "braced_thickness_mm": scale * legs[3],
            "brace_thickness_mm": scale * brace,
        },
    }
    try:
        design = Design.model_validate(data)
    except GeometryError as refusal:
        told = str(refusal).splitlines()
    else:
        mesh_checks.check(design)
        return
    assert all(re.match(r"legs\.\w+ = .+: .+", line) for line in told)
