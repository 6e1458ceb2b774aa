"""Cards of walkers: measured, written, read again, and taken on to other programs."""

import json
import math
import random
import re
import runpy

import numpy as np
import pymunk
import pytest
from answers import refused
from inertial_tracks import Inertial, tracks

from walkergen.analysis import motion
from walkergen.analysis.tracks import from_places
from walkergen.core.errors import InputError, WalkergenError
from walkergen.core.files.progress import silent
from walkergen.core.numerics.quantity import Quantity
from walkergen.core.scene import Scene
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.guests.crowd.cards import card as cards
from walkergen.guests.crowd.cards import exports, make, overdamped, relaxation, wall_runs
from walkergen.guests.crowd.cards import walker_motion as measured
from walkergen.guests.crowd.cards.card import Card
from walkergen.guests.crowd.flat import motion as flat_motion

CARD = Card(
    name="printed",
    mass_g=0.9,
    inertia_g_mm2=60.0,
    outline_mm=[[[-14.0, -4.0], [14.0, -4.0], [14.0, 4.0], [-14.0, 4.0]]],
    speed_mm_s=cards.field_quantity("speed_mm_s", 60.0, 0.2, 16),
    velocity_relaxation_s=cards.field_quantity("velocity_relaxation_s", 0.07, 0.003, 16),
    turning_rad_s=cards.field_quantity("turning_rad_s", 0.5, 0.02, 16),
    turning_relaxation_s=cards.field_quantity("turning_relaxation_s", 0.04, 0.002, 16),
    rotational_diffusion_rad2_s=cards.field_quantity("rotational_diffusion_rad2_s", 0.2, 0.02, 16),
    self_alignment_per_mm=cards.field_quantity("self_alignment_per_mm", 0.02, 0.003, 16),
    translational_diffusion_mm2_s=cards.field_quantity("translational_diffusion_mm2_s", 3.0, 0.3, 16),
)


def design(name="koumakis2016"):
    return templates.load(name, "walkers", Design)


COMMAND = ("crowd", "--card")


def csv_of(own):
    lines = ["t_s,particle,x_mm,y_mm,theta_rad"]
    for track in own.tracks:
        for n, (place, heading) in enumerate(zip(track.position, track.heading, strict=True)):
            row = n * own.interval, track.particle, *place, heading
            lines.append(",".join(f"{value:.9g}" for value in row))
    return "\n".join(lines) + "\n"


def test_a_card_is_read_as_it_was_written(tmp_path):
    path = tmp_path / "card.json"
    path.write_bytes(cards.to_json(CARD))
    assert cards.read_card(path) == CARD
    assert cards.to_json(cards.read_card(path)) == path.read_bytes()


def test_a_card_of_a_person_makes_inputs_again(run, tmp_path):
    (tmp_path / "mine.json").write_bytes(cards.to_json(CARD))
    assert run("mine.json").exit_code == 0
    folder = tmp_path / "out" / "mine" / "card"
    assert (folder / "card.json").read_bytes() == cards.to_json(CARD)
    assert (folder / "crowd_pymunk.py").read_bytes() == exports.input_files(CARD)["crowd_pymunk.py"]
    assert "variable mass equal 0.9\n" in (folder / "card.lammps").read_text()


@pytest.mark.slow
def test_a_simulated_walker_has_a_card_with_errors(run, tmp_path):
    words = ("koumakis2016", "--runs", "8", "--seconds", "4", "--json", "--out")
    first, again = (run(*words, str(tmp_path / name)) for name in ("a", "b"))
    assert first.exit_code == again.exit_code == 0, (first.output, first.exception)
    card = cards.read_card(tmp_path / "a" / "card.json")
    assert card.model_dump(mode="json") == json.loads(first.stdout)["card"]
    assert 55.0 < card.speed_mm_s.value < 66.0
    # As ten ensembles of 16 x 10 s of other seeds had them
    for key, expected in (
        ("velocity_relaxation_s", 0.0566),
        ("sideways_relaxation_s", 0.0458),
        ("turning_relaxation_s", 0.0402),
        ("translational_diffusion_mm2_s", 7.3),
        ("rotational_diffusion_rad2_s", 0.106),
        ("self_alignment_per_mm", -0.0056),
    ):
        known = getattr(card, key)
        assert abs(known.value - expected) < 4.0 * known.se, (key, known)
        assert cards.run_count(known) == 8
    assert card.overdamped.enough is not True  # it coasts over 0.121 of its length, of which 8 runs leave 0.01 open
    assert card.outline_mm[0][0] == pytest.approx([-14.0, -4.0], abs=0.1)
    for path in (tmp_path / "a").iterdir():
        assert path.read_bytes() == (tmp_path / "b" / path.name).read_bytes(), path.name
    page = (tmp_path / "a" / "card.html").read_text(encoding="utf-8")
    assert "data:image/png;base64," in page
    assert "default-src 'none'" in page
    assert not re.search("https?:", page)


def test_filmed_walkers_have_a_card(run, tmp_path):
    one = Inertial(rotation=0.5, noise=0.03, heading_noise=0.01)
    own = tracks(11, one, walkers=10, seconds=8.0, interval=0.01)
    (tmp_path / "tracks.csv").write_text(csv_of(own))
    result = run("polar-disc", "--tracks", "tracks.csv", "--no-pictures", "--json")
    assert result.exit_code == 0, result.exception
    card = Card.model_validate(json.loads(result.stdout)["card"])
    assert card.name == "polar-disc"
    assert card.self_alignment_per_mm is None  # nobody pushes
    for key, truth in (
        ("velocity_relaxation_s", one.relaxation),
        ("delay_s", one.relaxation),
        ("turning_relaxation_s", one.turn_relaxation),
        ("turning_rad_s", 0.0),
        ("translational_diffusion_mm2_s", one.diffusion),
        ("rotational_diffusion_rad2_s", one.rotation),
    ):
        known = getattr(card, key)
        assert abs(known.value - truth) < 3.5 * known.se, (key, known)


@pytest.mark.parametrize("aside", [0.03, 0.08])
def test_a_push_tells_how_soon_it_is_forgotten_across_the_heading(aside):
    """Walkers that turn at random, pushed toward +x: m dv/dt = -(m / aside) v + push, across the heading."""
    rng, step, force = np.random.default_rng(3), 2e-3, 170.0
    heading = np.cumsum(rng.normal(scale=0.5 * math.sqrt(step), size=(12, 4000)), axis=1)
    noise = rng.normal(scale=7.0 * math.sqrt(2.0 * step / aside), size=heading.shape)
    left, place, places = np.zeros(12), np.zeros((12, 2)), []
    for n in range(4000):
        sine, cosine = np.sin(heading[:, n]), np.cos(heading[:, n])
        left += (-force * sine - left / aside) * step + noise[:, n]
        place = place + step * np.column_stack((60.0 * cosine - left * sine, 60.0 * sine + left * cosine))
        places.append(np.column_stack((place, heading[:, n])))
    own = from_places(np.array(places)[500::5].transpose(1, 0, 2), 5 * step, lane=False)
    known = measured.sideways_relaxation(own, force)
    assert known.se < 0.25 * aside
    assert abs(known.value - aside) < 3.0 * known.se
    straight = from_places(np.zeros((12, 50, 3)) + rng.normal(scale=1e-3, size=(12, 50, 3)), 0.01, lane=False)
    assert measured.sideways_relaxation(straight, force).value is None


def test_frames_within_a_period_are_thinned_to_one(tmp_path):
    own = tracks(12, Inertial(), walkers=8, seconds=4.0, interval=1.0 / 900.0)
    (tmp_path / "fast.csv").write_text(csv_of(own))
    scene = templates.load("plane-90hz", "scenes", Scene)
    numbers = measured.measure_film(tmp_path / "fast.csv", measured.Units(), scene)
    assert numbers.interval == pytest.approx(1.0 / 90.0)
    assert any("every 10th frame" in note for note in numbers.notes)


def test_films_that_tell_too_little_are_refused(run, tmp_path):
    path = tmp_path / "tracks.csv"
    path.write_text(csv_of(tracks(1, Inertial(), walkers=2, seconds=0.3)))
    assert "is not known" in refused(run, "rotator", "--tracks", "tracks.csv")
    assert "--runs 4" in refused(run, "rotator", "--tracks", "tracks.csv", "--runs", "4")
    path.write_text("frame,particle,x,y\n0,0,1,1\n1,0,2,2\n2,0,3,3\n")
    films = ("rotator", "--tracks", "tracks.csv", "--fps", "50", "--mm-per-px", "0.1")
    assert "no headings" in refused(run, *films)


def test_mass_and_inertia_are_those_of_the_whole_walker():
    """A rival: every part by itself, by Steiner's theorem, about the vertical axis."""
    mass = solids.mass_of(design("unequal-legs"))
    parts = [(mass.M, 0.0, mass.spatial.z, mass.spatial.body[1, 1])]
    parts += [(leg.m, (leg.anchor + leg.c_A)[0], leg.across, leg.tensor[1, 1]) for leg in mass.legs]
    total, x, z, own = np.array(parts).T
    forward, left = (total @ x) / total.sum(), -(total @ z) / total.sum()
    arms = (x - forward) ** 2 + (z + left) ** 2
    assert measured.centre_of_mass(mass) == pytest.approx([forward, left], abs=1e-9)
    assert measured.yaw_inertia(mass) == pytest.approx(own.sum() + total @ arms, rel=1e-9)


@pytest.mark.parametrize("turn", [0.0, 3.0])
def test_propulsion_is_that_which_gives_the_mean_speed(turn):
    one = Inertial(turn=turn, relaxation=0.2, rotation=1.0, turn_relaxation=0.002)
    own = tracks(3, one, seconds=20.0, interval=0.02)
    speed = motion.analyse(own).estimates["speed"]
    card = CARD.model_copy(
        update={
            "speed_mm_s": cards.field_quantity("speed_mm_s", speed.value),
            "turning_rad_s": cards.field_quantity("turning_rad_s", turn),
            "velocity_relaxation_s": cards.field_quantity("velocity_relaxation_s", one.relaxation),
            "rotational_diffusion_rad2_s": cards.field_quantity("rotational_diffusion_rad2_s", one.rotation),
        }
    )
    raised = card.propulsion_mm_s / speed.value
    assert raised > 1.15
    assert abs(card.propulsion_mm_s - one.speed) < 3.5 * raised * speed.se + 0.01 * one.speed


def test_a_walker_that_turns_too_fast_to_be_averaged_is_refused():
    update = {"turning_rad_s": cards.field_quantity("turning_rad_s", 1e9)}
    with pytest.raises(WalkergenError, match="that cannot be averaged; see turning_rad_s"):
        flat_motion.from_card(CARD.model_copy(update=update))


def judged(speed, turning, relaxed, relaxed_se=1e-4):
    known = relaxation.measure_velocity(tracks(1, Inertial(), walkers=8, seconds=2.0), True)[0]
    time = known.time._replace(value=relaxed, se=relaxed_se)
    velocity = known._replace(time=time, deviation=1.0)
    numbers = (Quantity("number", "", value, 0.01) for value in (speed, turning, 0.01))
    return overdamped.judge(*numbers, velocity, 28.0).enough


def test_a_model_without_inertia_is_enough_for_what_neither_turns_nor_coasts():
    assert judged(60.0, 0.1, 0.005) is True
    assert judged(60.0, 0.1, 0.07) is False  # coasts over 0.15 of its length
    assert judged(1.0, -5.0, 0.07) is False  # turns by 0.35 rad
    assert judged(60.0, 0.1, 0.046, 0.01) is None


def scripts(tmp_path, card):
    for name, text in exports.input_files(card).items():
        (tmp_path / name).write_bytes(text)
    return runpy.run_path(str(tmp_path / "crowd_pymunk.py"))


@pytest.mark.slow
def test_pymunk_gives_the_walker_of_the_card(tmp_path):
    """Speed, relaxation, both diffusions and turning of a walker alone come back."""
    script, draws = scripts(tmp_path, CARD), random.Random(5)
    space, step, every = pymunk.Space(), 2e-3, 5
    bodies = [script["walker"](space, (200.0 * n, 0.0), 0.3 * n, draws) for n in range(24)]
    rows = []
    for n in range(round(8.0 / step)):
        space.step(step)
        if n % every == 0:
            rows.append([(*body.position, body.angle) for body in bodies])
    own = from_places(np.array(rows)[20:].transpose(1, 0, 2), every * step, lane=False)
    moved = motion.analyse(own).estimates
    both, diffusion = relaxation.measure_velocity(own, exact=True)
    velocity = relaxation.measure_along_heading(own, True, both, diffusion)
    turning = relaxation.measure_turning(own, True, moved["rotational_diffusion"])
    for estimate, known in (
        (moved["speed"], CARD.speed_mm_s),
        (velocity.time, CARD.velocity_relaxation_s),
        (diffusion, CARD.translational_diffusion_mm2_s),
        (moved["turning_bias"], CARD.turning_rad_s),
        (moved["rotational_diffusion"], CARD.rotational_diffusion_rad2_s),
        (turning.time, CARD.turning_relaxation_s),
    ):
        assert abs(estimate.value - known.value) < 3.5 * estimate.se + 0.01 * known.value, (estimate, known)
    assert moved["speed"].se < 0.02 * CARD.speed_mm_s.value


def test_pymunk_forgets_what_goes_aside_within_its_own_time(tmp_path):
    sideways = cards.field_quantity("sideways_relaxation_s", 0.03)
    script, draws = scripts(tmp_path, CARD.model_copy(update={"sideways_relaxation_s": sideways})), random.Random(5)
    space = pymunk.Space()
    bodies = [script["walker"](space, (200.0 * n, 0.0), 0.3 * n, draws) for n in range(24)]
    for body in bodies:
        body.velocity = pymunk.Vec2d(0.0, 200.0).rotated(body.angle)
    for _ in range(30):
        space.step(1e-3)
    left = np.mean([body.velocity.rotated(-body.angle).y for body in bodies])
    assert left == pytest.approx(200.0 / math.e, abs=8.0)


def test_pymunk_collides_with_the_card_s_restitution(tmp_path):
    """Two walkers without propulsion and friction, head on."""
    card = CARD.model_copy(
        update={
            "speed_mm_s": cards.field_quantity("speed_mm_s", 0.0),
            "velocity_relaxation_s": cards.field_quantity("velocity_relaxation_s", 1e6),
            "turning_relaxation_s": cards.field_quantity("turning_relaxation_s", 1e6),
            "turning_rad_s": cards.field_quantity("turning_rad_s", 0.0),
            "translational_diffusion_mm2_s": cards.field_quantity("translational_diffusion_mm2_s", 0.0),
            "restitution": 0.6,
            "rotational_diffusion_rad2_s": cards.field_quantity("rotational_diffusion_rad2_s", 0.0),
        }
    )
    script, draws, space = scripts(tmp_path, card), random.Random(1), pymunk.Space()
    assert script["MASS"] == card.mass_g
    left, right = (script["walker"](space, (x, 0.0), 0.0, draws) for x in (-20.0, 20.0))
    left.velocity, right.velocity = (30.0, 0.0), (-30.0, 0.0)
    for _ in range(1000):
        space.step(1e-3)
    assert right.velocity.x - left.velocity.x == pytest.approx(0.6 * 60.0, rel=0.02)
    assert left.velocity.x + right.velocity.x == pytest.approx(0.0, abs=1e-6)


def test_scripts_of_others_name_every_number_and_are_python(tmp_path):
    made = exports.input_files(CARD)
    for name in ("crowd_pymunk.py", "crowd_hoomd.py"):
        compile(made[name], name, "exec")
        text = made[name].decode()
        for number, value in exports.model_parameters(CARD).items():
            assert f"{number} = {value!r}" in text
    values = {
        words[1]: float(words[3])
        for line in made["card.lammps"].decode().splitlines()
        if (words := line.split())[0] == "variable"
    }
    assert values["thrust"] == pytest.approx(values["drag"] * CARD.propulsion_mm_s)
    relaxed = CARD.mass_g / values["drag"]
    assert relaxed == pytest.approx(CARD.velocity_relaxation_s.value)
    assert values["velocity_sd"] ** 2 * relaxed == pytest.approx(CARD.translational_diffusion_mm2_s.value)
    assert math.isfinite(sum(values.values()))


def test_numbers_that_every_card_has_are_asked_for():
    own = measured.measure_tracks(tracks(1, Inertial(), walkers=2, seconds=0.4), True, ())
    scene, walker = templates.load("plane-90hz", "scenes", Scene), design()
    with pytest.raises(InputError, match="is not known"):
        make.make_card(scene, walker, solids.mass_of(walker), own)


@pytest.mark.nightly
def test_a_wall_turns_a_walker_that_runs_against_it(run, tmp_path):
    """A flat nose stands head on, or beyond the reach of its corners turns along the wall."""
    words = ("koumakis2016", "--runs", "12", "--seconds", "3", "--arena", "disc:120", "--json")
    result = run(*words, "--out", "here")
    assert result.exit_code == 0, result.exception
    card = Card.model_validate(json.loads(result.stdout)["card"])
    assert -1.0 <= card.wall_alignment.value <= 1.0
    assert card.wall_turning_rad_s.value > 3.0 * card.wall_turning_rad_s.se
    late = card.turning_relaxation_s.value
    torque = card.inertia_g_mm2 * card.wall_turning_rad_s.value / late
    assert card.wall_torque_g_mm2_s2.value == pytest.approx(torque)
    assert (tmp_path / "here" / "walls.png").exists()


def test_dishes_in_which_a_walker_meets_no_wall_are_refused(run, tmp_path):
    assert "no walls" in refused(run, "--arena", "periodic:100")
    assert "'hexagon:3'" in refused(run, "--arena", "hexagon:3")
    (tmp_path / "tracks.csv").write_text(csv_of(tracks(1, Inertial(), walkers=2, seconds=0.3)))
    film = ("rotator", "--tracks", "tracks.csv", "--arena", "disc:120")
    assert "--arena disc:120: a film tells nothing of walls" in refused(run, *film)
    scene, walker = templates.load("plane-90hz", "scenes", Scene), design()
    small = scene.model_copy(update={"crowd": scene.crowd.model_copy(update={"arena_mm": "disc:35"})})
    with pytest.raises(InputError, match="too small"):
        wall_runs.simulate_wall_runs(small, walker, solids.mass_of(walker), CARD.speed_mm_s, silent)
