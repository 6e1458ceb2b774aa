"""Legs as a list: two equal ones are the pair; others weigh what their solids do."""

import mesh_checks
import numpy as np
import pytest

from walkergen.core.errors import GeometryError
from walkergen.core.files import config
from walkergen.core.scene import Scene
from walkergen.core.simulation.plan import prepare
from walkergen.core.theory.speed import factors
from walkergen.core.theory.stationary import project_to_plane
from walkergen.core.walker import mass, solids
from walkergen.core.walker.design import Design

DENSITY = 1.24e-3


def read_design(folder, text):
    path = folder / "mine.toml"
    path.write_text(text)
    return config.read_section(path, Design)


def design_with_legs(*legs, **tables):
    return Design.model_validate({"legs": list(legs)} | tables)


def two_rows(*legs, **tables):
    """Legs at back and front, each in a row of these, x measured from the row's middle."""
    rows = [leg | {"along_mm": x} for x in (-6.5, 6.5) for leg in legs]
    return design_with_legs(*rows, **tables)


@pytest.mark.parametrize("foot", ["flat", "square", "round"])
@pytest.mark.parametrize("kind", ["flexible", "braced"])
@pytest.mark.parametrize("tilt", [-12.0, 0.0, 25.0])
def test_two_equal_legs_of_a_list_are_the_pair_to_the_last_bit(tmp_path, kind, foot, tilt):
    keys = f"kind = '{kind}'\nfoot = '{foot}'\ntilt_deg = {tilt}\n"
    pair = read_design(tmp_path, "[legs]\n" + keys)
    both = read_design(tmp_path, "".join(f"[[legs]]\n{keys}along_mm = {x}\n" for x in (-6.5, 6.5)))
    assert both.limbs == pair.limbs
    for one, other in zip(list_meshes(solids.build(pair)), list_meshes(solids.build(both)), strict=True):
        assert np.array_equal(one.vertices, other.vertices)
        assert np.array_equal(one.triangles, other.triangles)
    weighed = [solids.mass_of(design) for design in (pair, both)]
    np.testing.assert_equal(weighed[0], weighed[1])
    np.testing.assert_equal(*(factors(found, 0.8, 0.25) for found in weighed))


def list_meshes(built):
    return [built.walker, built.body, *built.legs]


@pytest.mark.parametrize("kind", ["flexible", "braced"])
def test_models_run_two_equal_legs_of_a_list_as_the_pair(kind):
    pair = Design().variant(kind=kind)
    both = two_rows({"kind": kind, "tilt_deg": 10.0})
    scene = Scene.model_validate({"run": {"seconds": 0.1}})
    walkers = [prepare(scene, one, solids.mass_of(one)).world.walker for one in (pair, both)]
    np.testing.assert_equal(walkers[0], walkers[1])


def test_legs_side_by_side_are_one_as_wide_in_the_plane():
    for kind in ("flexible", "braced"):
        row = [{"kind": kind, "across_mm": z, "width_mm": 4.0} for z in (-2.0, 2.0)]
        four, pair = two_rows(*row), Design().variant(kind=kind)
        found, whole = solids.mass_of(four), solids.mass_of(pair)
        # 1e-12: roundings of two weighings, as with one leg
        assert found.total == pytest.approx(whole.total, rel=1e-12)
        assert found.J == pytest.approx(whole.J, rel=1e-12)
        np.testing.assert_allclose(found.spatial.body, whole.spatial.body, rtol=1e-12, atol=1e-12)
        flat, limbs = project_to_plane(four, found)
        assert [limb.width for limb in limbs] == [limb.width for limb in pair.limbs]
        for leg, like in zip(flat.legs, whole.legs, strict=True):
            assert leg.m == pytest.approx(like.m, rel=1e-12)
            assert leg.j == pytest.approx(like.j, rel=1e-12)
            np.testing.assert_allclose(leg.anchor, like.anchor, rtol=0.0, atol=1e-12)
            np.testing.assert_allclose(leg.foot, like.foot, rtol=0.0, atol=1e-12)


def test_a_braced_leg_among_flexible_ones_belongs_to_the_body():
    """Rival: weigh the union of the body and the braced leg, made without the other leg."""
    braced = {"kind": "braced", "tilt_deg": 20.0, "along_mm": -6.5, "across_mm": -1.0, "width_mm": 5.0}
    design = design_with_legs(braced, {"tilt_deg": 20.0, "along_mm": 6.5})
    found, built = solids.mass_of(design), solids.build(design)
    back, front = design.limbs
    z = 0.5 * design.size.depth + back.across - 0.5 * back.width
    placed = built.legs[0].vertices + np.array([*back.anchor, z])
    stays = [built.body, built.legs[0]._replace(vertices=placed)]
    whole = [mass.weigh(part, DENSITY) for part in stays]
    M = sum(part.mass for part in whole)
    O = sum(part.mass * part.centre for part in whole) / M  # noqa: E741  (the paper's name)
    tensor = np.zeros((3, 3))
    for part in whole:
        arm = part.centre - O
        tensor += part.tensor + part.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    assert (found.rigid, found.legs[0].m, found.legs[0].j) == (False, 0.0, 0.0)
    assert pytest.approx(M, rel=1e-13) == found.M
    assert pytest.approx(tensor[2, 2], rel=1e-12) == found.J
    np.testing.assert_allclose(found.spatial.body, tensor, rtol=0.0, atol=1e-12 * tensor.max())
    assert found.spatial.z == pytest.approx(O[2] - 4.0, abs=1e-12)
    feet = [leg.foot + O[:2] for leg in found.legs]
    on_plate = [(-6.5, back.foot_height), (6.5, front.foot_height)]
    np.testing.assert_allclose(feet, on_plate)
    united = mass.weigh(built.walker, DENSITY)
    assert found.total == pytest.approx(united.mass, rel=1e-12)
    frozen = mass.to_rigid(found)
    assert (frozen.M, frozen.J) == pytest.approx((united.mass, united.inertia), rel=1e-12)
    np.testing.assert_allclose(frozen.spatial.body, united.tensor, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose([united.centre[:2] + leg.foot for leg in frozen.legs], on_plate)


FORTY_LEGS = [
    {"tilt_deg": 0.0, "along_mm": -13.0 + 2.0 * k, "across_mm": z, "width_mm": 1.5}
    for k in range(14)
    for z in (-3.0, 0.0, 3.0)
][:40]


def test_forty_legs_are_one_sound_solid():
    built = mesh_checks.check(design_with_legs(*FORTY_LEGS))
    assert len(built.legs) == 40


def test_the_length_recommended_for_a_short_leg_reaches_the_plate():
    short = {"tilt_deg": 0.0, "along_mm": 6.5, "length_mm": 7.4862}
    with pytest.raises(GeometryError, match=r"legs\[1\].length_mm = 7.5: .* 7.6017 mm would reach"):
        design_with_legs({"along_mm": -6.5}, short)
    level = design_with_legs({"along_mm": -6.5, "length_mm": 7.6017}, short)
    back, front = (limb.foot_height for limb in level.limbs)
    assert back == pytest.approx(front, abs=1e-4)


def test_legs_without_a_tilt_follow_the_family():
    design = two_rows({}, family={"tilt_deg": [5.0, 20.0]})
    members = design.members()
    assert [member.tilt_deg for member in members] == [5.0, 20.0]
    assert [np.degrees(member.limbs[1].tilt) for member in members] == pytest.approx([5.0, 20.0])
    across = [{"across_mm": z, "width_mm": 2.0, "mirrored": z > 0} for z in (-3.0, 3.0)]
    mirrored = two_rows(*across).variant(tilt_deg=15.0)
    assert [round(np.degrees(limb.tilt)) for limb in mirrored.limbs] == [15, -15, 15, -15]
    with pytest.raises(GeometryError, match="cannot be made braced"):
        design.members(kinds=["braced"])
    own = two_rows({"tilt_deg": 10.0})
    assert own.members() == [own]
    with pytest.raises(GeometryError, match=r"no variant at 20 deg\. Remove tilt_deg"):
        own.members([20.0])


def test_legs_cut_flush_with_a_round_body_keep_the_whole_walkers_centre_and_tensor(tmp_path):
    """Legs at the flank of a ball: the parts, each about its own centre, make the weighed union."""
    import trimesh

    ball = trimesh.creation.icosphere(subdivisions=3, radius=9.0)
    ball.apply_scale([1.4, 1.0, 1.0])
    ball.export(tmp_path / "ball.stl")
    legs = [{"along_mm": x, "across_mm": z, "width_mm": 2.0} for x in (-5, 5) for z in (-3, 3)]
    design = config.validate({"body": {"mesh": str(tmp_path / "ball.stl")}, "legs": legs}, Design, "test")
    built = solids.build(design)
    parts, whole = solids.weigh(design, built), mass.weigh(built.walker, 1.24e-3)
    centres = np.array([(0.0, 0.0), *(leg.anchor + leg.c_A for leg in parts.legs)])
    masses = np.array([parts.M, *(leg.m for leg in parts.legs)])
    centre, tensor = mass.centre_and_inertia(parts.spatial, parts.legs, masses, centres)
    # A leg's flat sides lie in the union's; sums of 2600 triangles round to 1e-12
    assert masses.sum() == pytest.approx(whole.mass, rel=1e-10)
    middle = whole.centre - (*(-mass.to_centre_frame(design.limbs, parts, np.zeros(2))), 0.5 * design.size.depth)
    np.testing.assert_allclose(centre, middle, atol=1e-8)
    np.testing.assert_allclose(tensor, whole.tensor, rtol=1e-8, atol=1e-7)


def test_a_family_that_cannot_be_built_names_the_tilts():
    legs = [{"along_mm": along, "width_mm": 6.0} for along in (-2.5, 3.0)]
    body = {"outline": "disc", "length_mm": 16.0}
    design = Design.model_validate({"body": body, "legs": legs})
    assert len(design.members([0.0, 10.0])) == 2
    with pytest.raises(GeometryError, match=r"^at tilt 40 deg: .*legs\[2\].along_mm = 3"):
        design.members([10.0, 40.0, 45.0])
