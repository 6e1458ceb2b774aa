"""Everything that stands on a walker, on walkers of unlike legs and of other bodies."""

import numpy as np
import pytest

from walkergen.analysis import landings
from walkergen.commands.simulate import quantities
from walkergen.core.errors import InputError
from walkergen.core.scene import Scene
from walkergen.core.simulation.effects.effect import Case
from walkergen.core.simulation.effects.legs import decide_compliance
from walkergen.core.simulation.plan import prepare
from walkergen.core.simulation.space.model import initial_state
from walkergen.core.simulation.space.points import MAX_HULL_POINTS
from walkergen.core.simulation.space.state import C_Z
from walkergen.core.theory import uncertain_inputs
from walkergen.core.theory.stationary import stationary_speed
from walkergen.core.walker import names, solids
from walkergen.core.walker.design import Design
from walkergen.guests.lab import drops
from walkergen.guests.movie import shot
from walkergen.points import experiments, poses

ROTATOR = [
    {"along_mm": x, "across_mm": z, "width_mm": 3.0, "mirrored": z > 0} for z in (-2.5, 2.5) for x in (-6.0, 6.0)
]
MIXED = [{"along_mm": 6.5}, {"along_mm": -6.5, "kind": "braced"}]
DISC = {"outline": "disc", "length_mm": 22.0, "thickness_mm": 2.0}
TWO = [{"along_mm": x, "width_mm": 6.0} for x in (-5.0, 5.0)]


def design_of(legs, **tables):
    return Design.model_validate({"legs": legs, **tables})


def scene_of(**tables):
    return Scene.model_validate({"arena": {"kind": "plane"}} | tables)


def test_legs_are_named_by_where_they_stand():
    assert names.leg_names(Design()) == ("back", "front")
    assert names.leg_names(design_of(MIXED)) == ("front", "back")
    assert names.leg_names(design_of(ROTATOR)) == ("leg 1", "leg 2", "leg 3", "leg 4")


def test_a_body_whose_weight_is_aside_starts_between_a_lanes_walls():
    corners = [[0, 0], [28, 0], [28, 12], [17, 12], [17, 24], [11, 24], [11, 12], [0, 12]]
    design = design_of({"placement": "auto"}, body={"outline": "polygon", "points_mm": corners})
    world = prepare(Scene(), design, solids.mass_of(design)).world
    walled = world.walker.wall_distance > 0.0
    sides, state = world.walker.root[walled, 2], initial_state(world, 0.1)
    assert abs(sides.min() + sides.max()) > 1.0  # the centre of mass is off the middle
    assert np.abs(sides + state[C_Z]).max() == pytest.approx(world.walker.wall_distance.max() - 0.25)


def test_landings_of_three_feet_by_hand():
    time, corner = 1e-6 * np.array([0, 10, 500, 505, 509]), np.array([4, 5, 0, 1, 3])
    found = landings.count(time, corner, 1.0, 3)
    assert found.corners.tolist() == [1, 1, 0, 1, 1, 1]
    assert found.edges.tolist() == [1, 0, 1]
    assert (found.pairs, found.alone, found.groups) == (1, 0, 2)
    names = quantities.landing_names(("leg 1", "leg 2", "leg 3"))
    counted = dict(zip(names, quantities.count_landings(found), strict=True))
    assert counted["leg_3_edge"] == counted["leg_2_right"] == counted["several_feet"] == 1
    assert names.index("leg_2_right") < 2 * 3  # among single corners


def test_poses_and_outline_of_a_walker_seen_from_above():
    for legs, body in ((ROTATOR, {}), (TWO, DISC)):
        design = design_of(legs, body=body)
        mass = solids.mass_of(design)
        scene = scene_of(run={"seconds": 0.01, "discard_seconds": 0.0})
        found = poses.sample(prepare(scene, design, mass), 2e-3)
        one = shot.make_shot("walker, 10°, flexible", design, mass, found)
        assert found.corners.shape == (len(found.times), 2 * len(legs), 3)
        assert len(found.names) == 2 * len(legs)
        assert shot.foot_edges(one, 0).shape == (len(legs), 2, 2)
        (contour,) = shot.body_outline(one, 0)
        assert np.ptp(contour, axis=0) == pytest.approx(one.size, rel=1e-3)


def test_a_disc_topples_by_its_rim_and_not_by_corners_of_its_box():
    design = design_of(TWO, body=DISC)
    walker = prepare(scene_of(), design, solids.mass_of(design)).world.walker
    assert len(walker.corners) <= MAX_HULL_POINTS
    flat = np.hypot(walker.corners[:, 0], walker.corners[:, 2])
    # Legs of 0.02 g each lean back, so that C stands off the middle by 0.03 mm
    assert flat.max() == pytest.approx(11.0, abs=0.1)
    plain = prepare(scene_of(), Design(), solids.mass_of(Design())).world.walker
    assert plain.corners.shape == (8, 3)


def test_a_point_of_a_drawing_is_named_by_what_the_drawing_holds(tmp_path):
    path, keys = tmp_path / "shape.svg", []
    for wide in (22, 24):
        path.write_text(
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{wide}mm" height="20mm" '
            f'viewBox="0 0 {wide} 20"><rect width="{wide}" height="20"/></svg>'
        )
        from walkergen.readers.walkers import body_shapes

        body_shapes.shape_by_key.cache_clear()
        design = design_of(TWO, body={"outline": str(path), "thickness_mm": 2.0})
        keys.append(experiments.key_facts(Scene(), design))
    assert keys[0] != keys[1]
    assert len(experiments.key_facts(Scene(), Design())) == 4


def test_explain_names_the_slowest_and_the_fastest_leg():
    unlike = [*TWO[:1], TWO[1] | {"thickness_mm": 0.6}]
    for each, told in ((TWO, False), (unlike, True)):
        design = design_of(each)
        case = Case(scene_of(), design, solids.mass_of(design))
        meaning = decide_compliance(case).meaning
        assert ("slowest back; fastest front, 1.5" in meaning) == told


def test_feet_of_another_material_change_as_the_scenes_contact_is_drawn():
    legs = [{"along_mm": -6.5, "friction": 0.1, "restitution": 0.9}, {"along_mm": 6.5}]
    design, scene = design_of(legs), Scene.model_validate({"contact": {"restitution": 0.5}})
    nominal = scene.contact.friction
    drawn = {"contact.friction": 1.5 * nominal, "contact.restitution": 0.6}
    _, changed, _ = uncertain_inputs.apply_inputs(scene, design, drawn)
    assert changed.limbs[0].friction == pytest.approx(0.15, rel=1e-12)
    assert changed.limbs[0].restitution == 1.0  # 0.9 x 1.2, capped
    assert changed.limbs[1].friction is None
    mass = solids.mass_of(design)
    by_draw = stationary_speed(design, mass, np.array([0.5, 0.6]), nominal * np.array([1, 1.5]), nominal=(0.5, nominal))
    by_design = stationary_speed(changed, mass, 0.6, 1.5 * nominal)
    assert by_draw.factor[1] == pytest.approx(float(by_design.factor), rel=1e-12)
    kept = stationary_speed(design, mass, 0.5, nominal)
    assert by_draw.factor[0] == pytest.approx(float(kept.factor), rel=1e-12)


def test_a_measurement_asks_for_one_material():
    two = design_of([TWO[0], TWO[1] | {"restitution": 0.4}])
    with pytest.raises(InputError, match=r"legs\[2\].restitution belongs to one foot"):
        drops.check_one_restitution(two)
    drops.check_one_restitution(design_of([TWO[0], TWO[1] | {"friction": 0.4}]))
