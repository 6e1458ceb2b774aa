"""Self-alignment: that of made tracks, the same of mirror images, refused where none is seen; headings at starts."""

import math

import numpy as np
import pytest

import walkergen as wg
from walkergen.analysis import alignment, motion
from walkergen.analysis.estimates import NO_SLOPE_REASON
from walkergen.analysis.tracks import Track, Tracks
from walkergen.core.errors import InputError
from walkergen.core.scene import Scene
from walkergen.core.simulation.plan import prepare
from walkergen.core.simulation.run import drop_for_run
from walkergen.core.simulation.space.model import pose
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.points import walkers
from walkergen.points.experiments import Walker

PLANE = templates.load("plane-90hz", "scenes", Scene)
PAPER = templates.load("koumakis2016", "walkers", Design)
INTERVAL, DESCENT = 0.04, 0.7


def made(rng, kappa, count=16, seconds=6.0, speed=40.0, fall=8.0, diffusion=0.1, turn=0.3, noise=0.0, heading=None):
    """Tracks of walkers by the law itself, on a plate that takes them down at `fall` mm/s, from spread headings."""
    steps = 8
    h, frames = INTERVAL / steps, round(seconds / INTERVAL)
    theta = rng.uniform(0.0, 2.0 * math.pi, count) if heading is None else np.full(count, heading)
    place, own = np.zeros((count, 2)), rng.normal(0.0, turn, count)
    rows = []
    for step in range(frames * steps + 1):
        if step % steps == 0:
            rows.append(np.column_stack([place, theta]))
        drift = fall * np.sin(DESCENT - theta)
        velocity = speed * np.column_stack([np.cos(theta), np.sin(theta)])
        velocity = velocity + fall * np.array([math.cos(DESCENT), math.sin(DESCENT)])
        place = place + h * velocity
        theta = theta + h * (own + kappa * drift) + rng.normal(0.0, math.sqrt(2.0 * diffusion * h), count)
    states = np.array(rows)
    headings = states[:, :, 2] + rng.normal(0.0, noise, states.shape[:2])
    every = (Track(number, states[:, number, :2], headings[:, number]) for number in range(count))
    return Tracks(tuple(every), INTERVAL, 0, "")


def of(tracks, descent=DESCENT):
    return alignment.self_alignment([[track] for track in tracks.tracks], tracks.interval, descent)


@pytest.mark.parametrize(("kappa", "noise"), [(0.1, 0.0), (-0.05, 0.0), (0.02, 0.1)])
def test_kappa_of_made_walkers_lies_within_its_bounds(kappa, noise):
    rng = np.random.default_rng(5)
    inside = []
    for _ in range(40):
        found = of(made(rng, kappa, seconds=3.0, noise=noise))
        inside += [
            [
                low <= true <= high
                for true, (low, high) in zip(
                    (kappa, 8.0 * kappa), (number.interval(0.95) for number in found.values()), strict=True
                )
            ]
        ]
    # of 40 at 95 %, fewer than 34 happen once in 300
    assert (np.sum(inside, axis=0) >= 34).all()


def test_a_mirror_image_has_the_same_kappa():
    tracks = made(np.random.default_rng(1), 0.1)
    image = [track._replace(position=track.position * (1.0, -1.0), heading=-track.heading) for track in tracks.tracks]
    for name, number in of(tracks).items():
        other = of(tracks._replace(tracks=tuple(image)), -DESCENT)[name]
        assert (other.value, other.se) == pytest.approx((number.value, number.se), rel=1e-9)


def test_a_slope_is_no_turning_of_walkers_by_themselves():
    tracks = made(np.random.default_rng(2), -0.1, diffusion=0.01, turn=0.0)
    blind, told = motion.analyse(tracks), motion.analyse(tracks, descent=DESCENT)
    assert any("rates of their own" in doubt for doubt in blind.doubts)
    assert not any("rates of their own" in doubt for doubt in told.doubts)
    assert told.estimates["turning_scatter"].refused
    assert blind.estimates["self_alignment"].refused == NO_SLOPE_REASON


def test_a_film_of_a_tilted_plate_tells_kappa_whichever_way_y_points():
    tracks = made(np.random.default_rng(4), 0.1)
    rows = [
        (frame, track.particle, *state)
        for track in tracks.tracks
        for frame, state in enumerate(np.column_stack([track.position, track.heading]))
    ]
    table = np.array(rows)
    found = []
    for way in (1.0, -1.0):
        names = ("frame", "particle", "x_mm", "y_mm", "theta")
        columns = dict(zip(names, (table * (1.0, 1.0, 1.0, way, way)).T, strict=True))
        descent = way * math.degrees(DESCENT)
        given = {"fps": 1.0 / INTERVAL, "arena": "open", "descent_deg": descent, "y_down": way < 0.0}
        found.append(wg.analyse(columns, **given).estimates["self_alignment"])
    assert found[0].pair == pytest.approx(found[1].pair)
    assert found[0].value == pytest.approx(0.1, abs=4.0 * found[0].se)


def test_walkers_that_hardly_drift_or_all_head_alike_tell_no_kappa():
    rng = np.random.default_rng(3)
    assert "hardly drift" in of(made(rng, 0.1, fall=0.0))["self_alignment"].refused
    alike = made(rng, 0.0, heading=DESCENT, diffusion=0.0, turn=0.0, seconds=0.5)
    assert "hardly differ" in of(alike)["self_alignment"].refused


@pytest.mark.parametrize("side", [-1, 1])
def test_a_walker_of_which_one_foot_rubs_turns_about_it(side):
    """A foot that holds is a pivot: turning over drift is 1/d with the foot d behind the centre of mass, -1/d ahead."""
    d, leg = 6.0, {"kind": "braced", "tilt_deg": 0.0, "length_mm": 5.0}
    legs = [leg | {"along_mm": at * d, "friction": 0.3 if at == side else 0.0} for at in (-1, 1)]
    design = PAPER.variant(legs=legs)
    run = {"run.seconds": 0.6, "run.discard_seconds": 0.1, "run.runs": 16, "run.heading_deg": [60, 120, -60, -120]}
    scene = PLANE.variant(**{"plate.slope_deg": 3.0, **run})
    results = walkers.simulate(Walker(scene, design, solids.mass_of(design)), threads=1)
    found, _ = walkers.motion_of(results.results, scene)
    kappa = found.estimates["self_alignment"]
    # A foot that also slips lets the body slide past it: 0.54 ± 0.03 of the two sides
    assert 0.4 < -side * d * kappa.value < 1.05
    assert kappa.se < 0.2 * abs(kappa.value)


def heading_of(number, **keys):
    """Heading at which a run of a scene starts, deg."""
    plan = prepare(PLANE.variant(**keys), PAPER, solids.mass_of(PAPER))
    plan, state = drop_for_run(plan, number)
    assert plan.feet(state)[:, 1].min() >= 0.0
    return math.degrees(pose(state)[2])


def test_runs_start_at_the_headings_of_the_scene_in_turn():
    headings = [heading_of(number, **{"run.heading_deg": [0, 90, -135]}) for number in range(4)]
    assert headings == pytest.approx([0.0, 90.0, -135.0, 0.0], abs=0.1)  # pitch and roll turn them a little
    drawn = {round(heading_of(number, **{"run.heading_deg": "uniform"})) % 360 for number in range(4)}
    assert len(drawn) == 4


def test_a_start_at_heading_0_has_the_bits_that_it_had():
    mass = solids.mass_of(PAPER)
    plain, turned = (
        drop_for_run(prepare(PLANE.variant(**keys), PAPER, mass), 3)[1] for keys in ({}, {"run.heading_deg": "uniform"})
    )
    assert (
        drop_for_run(prepare(PLANE.variant(**{"run.heading_deg": 0}), PAPER, mass), 3)[1].tobytes() == plain.tobytes()
    )
    assert plain[13:16] != pytest.approx(turned[13:16])


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"effects.off": ["roll_and_yaw"]}, "holds the walker in its plane"),
        ({"arena.kind": "lane"}, "mm wide and the lane"),
    ],
)
@pytest.mark.parametrize("heading", ["uniform", [0.0, 20.0]])
def test_headings_are_refused_where_a_walker_cannot_start_so(keys, words, heading):
    with pytest.raises(InputError, match=words):
        prepare(PLANE.variant(**{"run.heading_deg": heading, **keys}), PAPER, solids.mass_of(PAPER))


def test_a_wide_lane_has_room_for_a_walker_across_it():
    keys = {"arena.kind": "lane", "arena.gap_mm": 40.0, "run.heading_deg": [90.0]}
    assert heading_of(0, **keys) == pytest.approx(90.0, abs=0.1)
