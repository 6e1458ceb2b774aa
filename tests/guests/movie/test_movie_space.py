"""Movies of walkers in space: what is drawn is what was simulated."""

import json
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from PIL import Image
from scipy.spatial import ConvexHull

from walkergen.core.errors import InputError
from walkergen.core.scene import Scene
from walkergen.core.shapes.mesh import Mesh
from walkergen.core.simulation.plan import prepare
from walkergen.core.simulation.run import simulate
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.guests.movie import film, impacts, perspective, raster, shot, top_view
from walkergen.guests.movie import make as movie
from walkergen.guests.movie.request import MovieRequest
from walkergen.points import poses

PAPER = templates.load("koumakis2016", "walkers", Design)
PLANE = templates.load("plane-90hz", "scenes", Scene)
LANE = templates.load("lane-90hz", "scenes", Scene)


def silent(what, done, total):
    pass


def film_of(members, scene, **choices):
    return film.plan_film(MovieRequest(**choices), members, scene)


def lasting(scene, seconds, discard=0.0):
    run = scene.run.model_copy(update={"seconds": seconds, "discard_seconds": discard})
    return scene.model_copy(update={"run": run})


@cache
def slow():
    """Three periods, 40 frames of 0.8 ms, 8 poses a frame."""
    job = film_of([PAPER], lasting(PLANE, 1.0), periods=3, slow=60, fps=20, view="perspective")
    return job, movie.simulate_shot(job, PAPER, movie.SLOW_POSES_PER_FRAME)


@cache
def real():
    """Half a second in real time, from above."""
    job = film_of([PAPER], lasting(PLANE, 1.0), seconds=0.5, fps=10)
    return job, movie.simulate_shot(job, PAPER, movie.ABOVE_POSES_PER_FRAME)


def from_above(one, job, gap=None):
    return top_view.make_draw_function([one], movie.ABOVE_POSES_PER_FRAME, job.slow, "settings", 1.0 / 90.0, gap)


def reddest(frame):
    """Pixels of the trail."""
    wanted = [int(top_view.TRAIL_COLOUR[i : i + 2], 16) for i in (1, 3, 5)]
    return np.abs(frame[top_view.HEAD_PX + 30 :].astype(int) - wanted).max(axis=-1) < 8


def test_poses_are_those_of_the_simulation():
    plan = prepare(lasting(PLANE, 0.05), PAPER, solids.mass_of(PAPER))
    found = poses.sample(plan, 1e-3)
    rows = simulate(plan, 0, sample_interval=1e-3, event_room=1000).tally.samples.rows
    assert len(found.times) == 51
    assert found.places[:, 0] == pytest.approx(rows[:51, 1] - rows[0, 1], abs=1e-12)
    assert found.heading == pytest.approx(rows[:51, 3], abs=0)
    assert found.turns @ (1, 0, 0, 0) == pytest.approx(1.0, abs=1e-3)


def test_the_mesh_stands_on_its_corners():
    # Legs bend by 10 um or so; the mesh is rigid, and its lowest points are the feet.
    _, one = slow()
    for at in range(0, len(one.times), 10):
        world = one.mesh.vertices @ one.poses.rotations[at].T + one.poses.places[at]
        # A corner stands in the middle of a flat foot's width, 0.4 mm / cos 10 deg.
        half = 0.2 / np.cos(PAPER.tilt_deg * np.pi / 180)
        nearest = [np.hypot(*(world - corner).T[[0, 2]]).min() for corner in one.poses.corners[at]]
        assert nearest == pytest.approx([half] * 4, abs=0.02)
        assert world[:, 1].min() == pytest.approx(one.poses.corners[at, :, 1].min(), abs=0.05)


def test_corners_press_where_they_are_below_the_plate_only():
    _, one = slow()
    closed, gaps = one.poses.closed, one.poses.gaps
    assert 0.02 < closed.mean() < 0.5
    # A contact acts by its gap in the middle of a step: it may be open by half a step's motion.
    assert gaps[closed].max() < 1e-3
    assert gaps[~closed].min() > -1e-3
    assert gaps.max() > 0.01


@pytest.mark.slow
@pytest.mark.nightly
def test_poses_are_of_the_print_and_the_plate_that_ran():
    scene = templates.load("plane-noisy", "scenes", Scene)
    rough = {"noise_ratio": 0.5, "roughness_um": 5.0}
    scene = scene.model_copy(
        update={
            "feet": scene.feet.model_copy(update={"unevenness_um": 20.0}),
            "plate": scene.plate.model_copy(update=rough),
        }
    )
    found = poses.sample(prepare(lasting(scene, 0.1), PAPER, solids.mass_of(PAPER)), 5e-5)
    assert found.closed.mean() > 0.02
    assert found.gaps[found.closed].max() < 1e-3
    assert found.gaps[~found.closed].min() > -1e-3


def test_corners_press_at_their_landings():
    _, one = slow()
    interval = one.times[1]
    assert len(one.impacts) > 10
    for hit in one.impacts:
        # A landing lasts some 50 us, two poses lie 35 us apart.
        near = round(hit.time / interval)
        assert one.poses.gaps[max(near - 1, 0) : near + 2, hit.foot].min() < 0.01
    assert {hit.foot for hit in one.impacts} == {0, 1, 2, 3}


@pytest.mark.parametrize("heading", [0.0, 0.7, -2.0, 8.0])
def test_bodies_are_drawn_along_their_heading(heading):
    _, one = real()
    turned = one._replace(poses=one.poses._replace(heading=one.poses.heading * 0 + heading))
    back, front = (shot.body_outline(turned, 3)[0][i] for i in (0, 1))
    assert np.hypot(*(front - back)) == pytest.approx(28.0, abs=1e-12)
    assert (front - back) / 28.0 == pytest.approx((np.cos(heading), np.sin(heading)), abs=1e-12)
    # The left side is a quarter turn counter-clockwise from ahead.
    left = shot.body_outline(turned, 3)[0][2] - front
    assert left == pytest.approx(8.0 * np.array((-np.sin(heading), np.cos(heading))), abs=1e-12)


def test_feet_lie_across_the_heading_under_the_body():
    _, one = real()
    for at in (0, len(one.times) - 1):
        ahead = np.array([np.cos(one.poses.heading[at]), np.sin(one.poses.heading[at])])
        for right_end, other in shot.foot_edges(one, at)[:, ::-1]:
            assert np.hypot(*(right_end - other)) == pytest.approx(8.0, abs=0.02)
            assert abs((right_end - other) @ ahead) < 0.02


def test_the_distance_is_run_along_the_heading():
    _, one = real()
    straight = np.hypot(*(one.track[-1] - one.track[0]))
    assert one.distance == pytest.approx(straight, rel=0.1)
    reversed_ = one._replace(poses=one.poses._replace(heading=one.poses.heading + np.pi))
    assert reversed_.distance == pytest.approx(-one.distance, rel=1e-9)


def test_the_trail_follows_the_track():
    job, one = real()
    draw = from_above(one, job)
    wide = [np.ptp(np.nonzero(reddest(draw(k)))[1]) for k in (1, 3, job.frames - 1)]
    run = [np.ptp(one.track[: k * movie.ABOVE_POSES_PER_FRAME + 1, 0]) for k in (1, 3, job.frames - 1)]
    assert wide[0] < wide[1] < wide[2]
    assert (wide[2] - wide[1]) / (wide[1] - wide[0]) == pytest.approx(
        (run[2] - run[1]) / (run[1] - run[0]), rel=0.2
    )  # a pixel is 0.1 mm; marks and line are 5 pixels wide at both ends


def test_a_run_to_the_left_is_drawn_upward():
    job, one = real()
    turn = np.array([(0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (-1.0, 0.0, 0.0)])  # x -> -z, to the left
    left = one._replace(
        poses=one.poses._replace(
            places=one.poses.places @ turn.T,
            corners=one.poses.corners @ turn.T,
            heading=one.poses.heading + 0.5 * np.pi,
        )
    )
    draw = from_above(left, job)
    first, last = (np.nonzero(reddest(draw(k)))[0].min() for k in (0, job.frames - 1))
    assert last < first - 50


def test_frames_differ_and_do_not_depend_on_those_before():
    job, one = real()
    draw = from_above(one, job)
    frames = [draw(k) for k in range(job.frames)]
    assert all((a != b).any() for a, b in pairwise(frames))
    assert np.array_equal(draw(2), frames[2])


def test_a_lane_shows_its_walls():
    job, one = real()
    lane, plane = (from_above(one, job, gap)(0) for gap in (9.0, None))
    dark = [(frame.max(axis=-1) < 0x40).mean(axis=1) for frame in (lane, plane)]
    assert (dark[0] > 0.9).sum() >= 2
    assert (dark[1] > 0.9).sum() == 0


def test_a_movie_has_equal_bytes_for_equal_input(tmp_path):
    job = film_of([PAPER], lasting(PLANE, 1.0), seconds=0.3, fps=10)
    one, two = (movie.make_movie(job, tmp_path / f"{k}.gif", silent) for k in "ab")
    assert (one.frames, job.view, job.slow) == (4, "above", 1.0)
    assert one.gif.read_bytes() == two.gif.read_bytes()
    with Image.open(one.gif) as image:
        assert image.n_frames == 4


@pytest.mark.slow
def test_a_movie_in_perspective_has_equal_bytes_for_equal_input(tmp_path):
    choice = {"periods": 0.5, "slow": 180, "fps": 10, "view": "perspective"}
    job = film_of([PAPER], lasting(PLANE, 1.0), **choice)
    one, two = (movie.make_movie(job, tmp_path / f"{k}.gif", silent) for k in "ab")
    assert one.gif.read_bytes() == two.gif.read_bytes()
    with Image.open(one.gif) as image:
        assert image.n_frames == job.frames
        assert image.size == (impacts.WIDTH_PX, impacts.HEIGHT_PX)
    assert film.file_name(job, {}).endswith("_plane-90hz_perspective.gif")
    values = {"scene.contact.friction": 0.5, "scene.plate.material": "../x\n"}
    assert film.file_name(job, values).endswith("_perspective_friction-0.5_material-..-x-.gif")


def test_several_tilts_run_in_an_arena_each(tmp_path):
    members = PAPER.members([5.0, 35.0], ["flexible"])
    job = film_of(members, lasting(PLANE, 1.0), seconds=0.2, fps=10)
    made = movie.make_movie(job, tmp_path / "a.gif", silent)
    assert [one.name for one in made.shots] == ["koumakis2016, 5°, flexible", "koumakis2016, 35°, flexible"]
    with Image.open(made.gif) as image:
        assert image.size[0] == top_view.WIDTH_PX
        assert (
            image.size[1]
            <= top_view.HEAD_PX + top_view.MAX_ARENAS_PX + 2 * (top_view.TITLE_PX + 1) + top_view.FOOT_PX + 1
        )


def in_perspective(one, job):
    return perspective.make_draw_function(one, movie.SLOW_POSES_PER_FRAME, job.slow, "settings")


def coloured(frame, colour, view):
    """Pixels of a view that are close to a colour."""
    left, bottom, width, height = (int(value) for value in view)
    top = impacts.HEIGHT_PX - bottom - height
    shown = frame[top : top + height, left : left + width].astype(int)
    wanted = [int(colour[i : i + 2], 16) for i in (1, 3, 5)]
    return int((np.abs(shown - wanted).max(axis=-1) < 8).sum())


@pytest.mark.parametrize("view", [perspective.MAIN_BOX, perspective.CLOSE_BOX])
def test_corners_flash_from_their_landing_on(view):
    job, one = slow()
    glow = impacts.AFTERGLOW_S / job.slow
    first = one.impacts[0]
    # That landing alone, so that no other hides the end of its flash.
    one = one._replace(impacts=(first,))
    draw = in_perspective(one, job)
    colour = impacts.impact_style(first.kind).colour
    begin = int(np.ceil(first.time * job.request.fps * job.slow))
    over = int(np.ceil((first.time + glow) * job.request.fps * job.slow))
    lit = [coloured(draw(frame), colour, view) for frame in (begin - 1, begin, over)]
    assert lit[1] > 30
    assert lit[0] == lit[2] == 0


def test_every_flash_is_that_of_a_landing_at_its_corner():
    job, one = slow()
    glow = impacts.AFTERGLOW_S / job.slow
    for at in range(0, len(one.times), 4 * movie.SLOW_POSES_PER_FRAME):
        for corner in range(4):
            shown = impacts.strongest_impact(one, one.times[at], glow, corner)
            recent = [hit for hit in one.impacts if hit.foot == corner and 0 <= one.times[at] - hit.time < glow]
            assert (shown is not None) == bool(recent)
            assert shown is None or shown[0] in recent


def test_corners_that_press_are_dotted():
    job, one = slow()
    draw = in_perspective(one._replace(impacts=()), job)
    closed = one.poses.closed[:: movie.SLOW_POSES_PER_FRAME].any(axis=1)
    pressing, free = int(np.argmax(closed)), int(np.argmin(closed))
    dark = [coloured(draw(frame), "#222222", perspective.CLOSE_BOX) for frame in (pressing, free)]
    shown = one._replace(poses=one.poses._replace(closed=np.zeros_like(one.poses.closed)))
    without = in_perspective(shown._replace(impacts=()), job)
    assert dark[0] > coloured(without(pressing), "#222222", perspective.CLOSE_BOX) + 8
    assert dark[1] == coloured(without(free), "#222222", perspective.CLOSE_BOX)


def test_drawing_in_perspective_does_not_depend_on_frames_before():
    job, one = slow()
    draw = in_perspective(one, job)
    frame = draw(30)
    assert (draw(3) != frame).any()
    assert np.array_equal(draw(30), frame)


def test_a_long_run_is_followed():
    job, one = slow()
    far = np.outer(np.linspace(0, 1e3, len(one.times)), (1.0, 0.0, -0.5))
    moved = one.poses._replace(places=one.poses.places + far, corners=one.poses.corners + far[:, None])
    draw = in_perspective(one._replace(poses=moved), job)
    seen = [coloured(draw(frame), "#9AB4CA", perspective.MAIN_BOX) for frame in (0, job.frames - 1)]
    assert seen[0] > 5_000
    assert seen[1] == pytest.approx(seen[0], rel=0.05)


def box():
    """Mesh of the box |x| < 1, |y| < 2, |z| < 3."""
    import manifold3d

    raw = manifold3d.Manifold.cube((2.0, 4.0, 6.0), True).to_mesh64()
    return Mesh(np.asarray(raw.vert_properties)[:, :3], np.asarray(raw.tri_verts, np.int64))


def test_a_camera_sees_what_it_is_made_for():
    points = box().vertices
    camera = raster.fit_camera(points, (300, 200))
    seen = camera.project(points)
    assert seen[:, :2].min() > -1e-9
    assert (seen[:, :2].max(axis=0) <= np.array((300, 200)) + 1e-9).all()
    nearest = np.argmin(np.linalg.norm(points - camera.eye, axis=1))
    assert np.argmax(seen[:, 2]) == nearest
    up, right = camera.project(np.array([(0, 1, 0), (1, 0, 0)])) - camera.project(np.zeros(3))
    assert up[0] == pytest.approx(0.0, abs=1e-9)
    assert up[1] > 0
    assert right[0] > 0


def test_a_box_covers_the_hull_of_its_corners():
    mesh = box()
    camera = raster.fit_camera(mesh.vertices, (300, 200))
    model = raster.make_model(mesh)
    assert len(model.edges) == 12
    picture, left, low = raster.render(model, np.eye(3), np.zeros(3), camera, "#ffffff", "#000000")
    hull = ConvexHull(camera.project(mesh.vertices)[:, :2]).volume
    covered = (picture[..., 3] / 255.0).sum()
    # The outline is a pixel wide, half of it outside: 0.3 of a hull's perimeter of 800 pixels.
    assert covered == pytest.approx(hull, abs=400)
    assert (left, low) == tuple(np.floor(camera.project(mesh.vertices)[:, :2].min(axis=0)).astype(int) - 1)
    # Three faces are seen, each with its own shade, and the ink.
    shades = {tuple(one) for one in picture[picture[..., 3] == 255][:, :3].tolist()}
    often = [one for one in shades if (picture[..., :3] == one).all(axis=-1).sum() > 500]
    assert len(set(often) - {(0, 0, 0)}) == 3


def test_nearer_faces_hide_those_behind_whatever_their_order():
    one, other = (np.array([(0.0, 0.0, near), (40.0, 0.0, near), (0.0, 40.0, near)]) for near in (0.1, 0.2))
    for order in ((one, other), (other, one)):
        number, near = np.full((50, 50), -1, np.int32), np.zeros((50, 50))
        for value, corners in enumerate(order):
            raster._fill_triangle(number, near, corners, value)
        assert number.max() == number[10, 10] == (0 if order[0] is other else 1)
        assert (near > 0).sum() == pytest.approx(800, abs=40)
        assert near.max() == pytest.approx(0.2)


COMMAND = ("movie",)


def test_the_command_films_a_plane_from_above(run):
    words = ("--scene", "plane-90hz", "--tilt", "10", "--seconds", "0.2", "--fps", "10", "--json")
    found = json.loads(run(*words).stdout)
    assert found["view"] == "above"
    assert found["gif"] == "out/koumakis2016/walker_t10.0_flexible_s0.40_plane-90hz.gif"
    assert found["walkers"][0]["distance_mm"] > 2.0


def test_views_follow_from_where_walkers_run():
    def seen(scene, members):
        return film_of(members, scene, seconds=0.2).view

    both = PAPER.members([10.0], ["flexible", "braced"])
    assert seen(PLANE, [PAPER]) == "above"
    assert seen(LANE, [PAPER]) == "perspective"
    assert seen(LANE, both) == "above"
    assert seen(LANE, both[1:]) == "perspective"


def test_a_run_that_ends_at_once_is_refused():
    # It runs at some 70 mm/s, and is off a plane of its own length before anything is measured.
    arena = PLANE.arena.model_copy(update={"length_mm": 28.0})
    job = film_of([PAPER], lasting(PLANE.model_copy(update={"arena": arena}), 1.0, 0.6), fps=10)
    with pytest.raises(InputError, match=r"10°, flexible: the run ended before .*left the"):
        movie.simulate_shot(job, PAPER, movie.ABOVE_POSES_PER_FRAME)


def test_the_bending_of_legs_is_magnified_below_the_plate():
    _, one = slow()
    assert one.poses.gaps.min() < 0.0  # some leg gives way
    canvas = perspective.Canvas(impacts.WIDTH_PX, impacts.HEIGHT_PX)
    centres = perspective._view_centres(one)
    close = perspective._make_close_view(canvas, one, centres)
    told = f"× {close.zoom}, bending of legs (below it) × {close.bend}; numbers: µm"
    assert any(told in text.get_text() for text in canvas.figure.texts)
    assert close.bend > close.zoom
    at, corner = np.unravel_index(one.poses.gaps.argmin(), one.poses.gaps.shape)
    glows = [None] * one.poses.gaps.shape[1]
    corners = one.poses.corners[at] - centres[at]
    perspective._update_close_view(close, one, perspective.Seen(at, centres[at], corners, glows))
    seen = np.column_stack(close.edges[corner // 2].get_data())[corner % 2]
    foot = corners[corner] * (1.0, 0.0, 1.0)
    foot[1] = close.bend * one.poses.gaps[at, corner]
    assert seen == pytest.approx(close.view.camera.project(foot)[:2])
    depth = close.view.camera.project(foot * (1.0, 0.0, 1.0))[1] - seen[1]
    assert 3.0 < depth < 80.0  # pixels: it can be seen
    words = [perspective._format_micrometres(length) for length in (0.0734, 0.0, -1e-6, -2.2e-4)]
    assert words == ["73", "0", "0", "\N{MINUS SIGN}0.2"]
