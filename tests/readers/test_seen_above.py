"""Outlines seen from above are where the simulation has the body, and keep its handedness."""

import numpy as np
import pytest
import shapely
from shapely.affinity import rotate, translate

from walkergen.core.scene import Scene
from walkergen.core.shapes import stl
from walkergen.core.simulation.plan import prepare
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.core.walker.mass import to_centre_frame
from walkergen.files import templates
from walkergen.points import poses
from walkergen.readers.drawings.outlines import area
from walkergen.readers.walkers import leg_attachment, top_outline

HOOK = [[-14, -9], [14, -9], [14, 9], [6, 9], [6, -2], [-14, -2]]
"""A body whose left side ahead reaches out: no mirror image of it is the same."""

LEGS = [{"along_mm": x, "across_mm": 5.0, "width_mm": 3.0, "mirrored": x > 0} for x in (-8.0, 8.0)] + [
    {"along_mm": 10.0, "across_mm": -5.0, "width_mm": 3.0}
]

TURNER = Design.model_validate(
    {"name": "turner", "legs": LEGS, "body": {"outline": "polygon", "points_mm": HOOK, "thickness_mm": 3.0}}
)


def polygon_of(outline):
    return shapely.union_all([shapely.Polygon(contour) for contour in outline])


def test_an_outline_lies_where_the_simulation_has_the_body_and_its_mirror_image_does_not():
    scene = Scene.model_validate(
        {"arena": {"kind": "plane"}, "contact": {"restitution": 0.2}, "run": {"seconds": 0.3, "discard_seconds": 0.0}}
    )
    mass = solids.mass_of(TURNER)
    found = poses.sample(prepare(scene, TURNER, mass), 0.05)
    outline = polygon_of(top_outline.outline_of(TURNER, mass))
    mesh = leg_attachment.prepare_body(TURNER.body.cache_key).mesh
    body = mesh.vertices - np.array([0.0, 0.0, 0.5 * TURNER.size.depth])
    body[:, :2] = to_centre_frame(TURNER.limbs, mass, body[:, :2])
    for place, turn, heading in zip(found.places, found.rotations, found.heading, strict=True):
        x, _, z = (body @ turn.T + place).T
        faces = shapely.polygons(np.column_stack([x, -z])[mesh.triangles])
        seen = shapely.union_all(faces[shapely.area(faces) > 1e-6])

        def place_polygon(polygon, place=place, heading=heading):
            turned = rotate(polygon, heading, origin=(0.0, 0.0), use_radians=True)
            return translate(turned, place[0], -place[2])

        off = place_polygon(outline).symmetric_difference(seen).area
        mirrored = shapely.transform(outline, lambda points: points * (1.0, -1.0))
        assert off < 0.02 * outline.area  # the body pitches
        assert place_polygon(mirrored).symmetric_difference(seen).area > 0.3 * outline.area


def test_outlines_are_counter_clockwise_and_no_point_moves_farther_than_promised():
    for name in templates.names("walkers"):
        design = templates.load(name, "walkers", Design)
        outline = top_outline.outline_of(design)
        assert all(area(contour) > 0.0 for contour in outline)
        full = [ring for ring in top_outline.body_contours(design) if area(ring) > 0.0]
        O = to_centre_frame(design.limbs, solids.mass_of(design), np.zeros((1, 2)))[0, 0]  # noqa: E741
        moved = shapely.hausdorff_distance(
            shapely.union_all([shapely.Polygon(np.add(ring, (O, 0.0))) for ring in full]).boundary,
            polygon_of(outline).boundary,
        )
        assert moved <= top_outline.MAX_DEVIATION_MM
        assert len(outline[0]) <= len(full[0])


def test_a_rectangle_is_its_four_corners_about_the_centre_of_mass():
    design = templates.load("koumakis2016", "walkers", Design)
    (outline,) = top_outline.outline_of(design)
    assert len(outline) == 4
    assert np.ptp(outline, axis=0) == pytest.approx([28.0, 8.0])
    assert top_outline.area_of([outline]) == pytest.approx(28.0 * 8.0)
    braced = design.variant(kind="braced", tilt_deg=30.0)
    (other,) = top_outline.outline_of(braced)  # its legs, which lean, belong to its mass
    middle = 0.5 * (other.max(axis=0) + other.min(axis=0))
    assert middle[0] == pytest.approx(-0.0, abs=1.0)
    assert abs(middle[0]) > 0.05
    assert middle[1] == pytest.approx(0.0)


def test_the_projection_of_a_mesh_is_the_plan_that_it_was_made_of(tmp_path):
    mesh = leg_attachment.prepare_body(TURNER.body.cache_key).mesh
    (tmp_path / "hook.stl").write_bytes(stl.pack(mesh.vertices[mesh.triangles], "hook"))
    design = Design.model_validate(
        {
            "legs": [{"along_mm": x, "across_mm": 5.0, "width_mm": 3.0} for x in (-8.0, 8.0)]
            + [{"along_mm": 10.0, "across_mm": -5.0, "width_mm": 3.0}],
            "body": {"mesh": str(tmp_path / "hook.stl"), "up": "y", "forward": "x"},
        }
    )
    (ring,) = top_outline.body_contours(design)
    (own,) = top_outline.body_contours(TURNER)
    off = shapely.Polygon(ring).symmetric_difference(shapely.Polygon(own)).area
    assert off < 1e-3 * shapely.Polygon(own).area


def test_the_holes_of_letters_are_contours_but_no_outline():
    design = templates.load("name", "walkers", Design)
    contours = top_outline.body_contours(design)
    assert [area(ring) > 0.0 for ring in contours] == [True, *[False] * (len(contours) - 1)]
    assert len(contours) > 2
    assert len(top_outline.outline_of(design)) == 1


def test_a_disc_stays_round_about_its_middle():
    design = templates.load("rotator", "walkers", Design)
    (outline,) = top_outline.outline_of(design)
    middle = outline.mean(axis=0)
    assert np.hypot(*(outline - middle).T) == pytest.approx(14.0)
    assert middle[1] == pytest.approx(0.0, abs=1e-9)
    assert 40 <= len(outline) <= 120
