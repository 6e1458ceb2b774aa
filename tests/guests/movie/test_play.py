"""A run that a viewer plays is what was simulated."""

import base64

import numpy as np
import pytest

from walkergen.core.scene import Scene
from walkergen.core.simulation.plan import prepare
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.guests.movie import viewer_run
from walkergen.points import poses

PLANE = templates.load("plane-90hz", "scenes", Scene)
PAPER, BRISTLE = (templates.load(name, "walkers", Design) for name in ("koumakis2016", "bristle"))
SECONDS = 1.0


def floats(text, width):
    return np.frombuffer(base64.b64decode(text), "<f4").reshape(-1, width).astype(float)


@pytest.fixture(scope="module")
def design():
    return PAPER.members([35.0], ["flexible"])[0]


@pytest.fixture(scope="module")
def run(design):
    return viewer_run.record_run(design, PLANE, SECONDS)


@pytest.fixture(scope="module")
def truth(design):
    changed = PLANE.run.model_copy(update={"seconds": SECONDS})
    scene = PLANE.model_copy(update={"run": changed})
    return poses.sample(prepare(scene, design, solids.mass_of(design)), 1.0 / viewer_run.POSES_PER_SECOND)


@pytest.mark.slow
def test_the_part_stands_where_the_run_has_it(run, truth):
    rows, corners = floats(run["poses"], 7), np.array(run["corners"])
    assert len(rows) == len(truth.times) == 2001
    assert np.linalg.norm(rows[:, 3:], axis=1) == pytest.approx(1.0, abs=1e-6)
    for at in range(0, len(rows), 50):
        v, w = rows[at, 3:6], rows[at, 6]
        turned = corners + 2 * np.cross(v, np.cross(v, corners) + w * corners)
        # The mesh is rigid, legs bend by up to some hundredths of a millimetre.
        assert turned + rows[at, :3] == pytest.approx(truth.corners[at], abs=0.1)


@pytest.mark.parametrize("design", [PAPER.variant(tilt_deg=35.0), BRISTLE], ids=["on its side", "legs up"])
def test_corners_are_those_of_the_part(design):
    """In the frame of the mesh that a viewer shows, whichever way the part prints."""
    vertices = solids.build(design).walker.vertices
    half = 0.2 / np.cos(np.radians(design.tilt_deg))  # of a flat foot's width
    for corner in viewer_run.record_run(design, PLANE, 0.01)["corners"]:
        assert np.linalg.norm(vertices - corner, axis=1).min() == pytest.approx(half, abs=0.05)


def test_lights_are_those_of_the_landings(run, truth):
    landings = floats(run["landings"], 3)
    assert len(landings) == len(truth.landings) > 100
    assert landings[:, 0] == pytest.approx(truth.landings[:, 0], abs=1e-6)
    assert (landings[:, 1] == truth.landings[:, 1]).all()
    assert landings[:, 2].max() == pytest.approx(1.0, abs=1e-6)
    strongest = np.argmax(np.hypot(truth.landings[:, 2], truth.landings[:, 3]))
    assert np.argmax(landings[:, 2]) == strongest
    masks = np.frombuffer(base64.b64decode(run["closed"]), np.uint8)
    assert (np.unpackbits(masks[:, None], axis=1)[:, :4] == truth.closed).all()


def test_a_run_is_small_and_says_what_it_is(run):
    assert sum(len(part) for part in run.values() if isinstance(part, str)) < 300_000
    assert run["words"].startswith("walker_t35.0_flexible_s0.40 in plane-90hz: 90 Hz, 1.8 g")
