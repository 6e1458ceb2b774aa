"""Profiles of walkers, and the drawings of them that laser cutters read."""

import numpy as np
import pytest
from mesh_checks import to_trimesh

from walkergen.commands.export.profile import FORMATS, side_profile
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.readers.drawings.outlines import area, from_file


@pytest.mark.parametrize("kind", ["flexible", "braced"])
@pytest.mark.parametrize("tilt", [0.0, 1e-9, 10.0, -30.0])
def test_a_profile_times_the_depth_is_the_solid(kind, tilt):
    design = Design().variant(kind=kind, tilt_deg=tilt)
    profile = side_profile(design)
    volume = to_trimesh(solids.build(design).walker).volume
    # Two unions of the same polygons: they differ by roundings, and slivers that are no windows.
    assert design.body.depth_mm * sum(map(area, profile)) == pytest.approx(volume, rel=1e-8)
    assert [area(part) > 0 for part in profile] == [True] + [False] * (len(profile) - 1)
    assert len(profile) - 1 == sum(solids.has_window(limb) for limb in design.limbs)


@pytest.mark.parametrize("ending", FORMATS)
def test_what_is_written_is_read_again(tmp_path, ending):
    profile = side_profile(Design().variant(kind="braced", tilt_deg=30.0))
    path = tmp_path / f"walker.{ending}"
    path.write_bytes(FORMATS[ending](profile))
    again = from_file(path).polygons
    middle = 0.5 * (profile[0].min(axis=0) + profile[0].max(axis=0))
    assert len(again) == len(profile)
    for one, other in zip(again, profile, strict=True):
        # Files hold every digit; centring takes the last.
        np.testing.assert_allclose(one + middle, other, atol=1e-12)


@pytest.mark.parametrize("ending", FORMATS)
def test_equal_profiles_give_equal_bytes_without_a_date(ending):
    data = FORMATS[ending](side_profile(Design()))
    assert data == FORMATS[ending](side_profile(Design()))
    stated = {"dxf": b"$INSUNITS\n 70\n4\n", "svg": b'width="28.0mm"'}[ending]
    assert stated in data
