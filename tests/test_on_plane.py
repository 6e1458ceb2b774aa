"""`reproduce` in space: scenes, landings of corners, growth of the squared displacement, figure 6.

Known walks stand for the simulator: ballistic, diffusive, and persistent ones in between.
"""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.figure import Figure

from walkergen.analysis import walks
from walkergen.analysis.landings import QUIET_S
from walkergen.analysis.tracks import Track, Tracks
from walkergen.analysis.values import Value
from walkergen.errors import InputError
from walkergen.files import figures as pictures
from walkergen.files import templates
from walkergen.jobs.trust.reproduce import compare, curves, plane, plane_figure, sweeps
from walkergen.jobs.trust.reproduce import make as reproduce
from walkergen.jobs.trust.reproduce.sweeps import Assumption, Case, Point
from walkergen.scene import Scene
from walkergen.simulation.run import Outcome
from walkergen.walker.design import Design

INTERVAL, LENGTH = 0.004, 2500


@pytest.fixture(scope="module")
def design():
    return templates.load("koumakis2016", "walkers", Design)


@pytest.fixture(scope="module")
def scene():
    return templates.load("lane-90hz", "scenes", Scene)


def tracks_of(positions, headings=None):
    """Tracks of complex positions (mm), their headings along x where none are given."""
    headings = [np.zeros(len(one)) for one in positions] if headings is None else headings
    return Tracks(
        tuple(
            Track(number, np.stack([place.real, place.imag], axis=1), heading)
            for number, (place, heading) in enumerate(zip(positions, headings, strict=True))
        ),
        INTERVAL,
        0,
        "",
    )


def persistent(rate, runs=16, length=LENGTH, speed=10.0):
    """Walks of constant speed (mm/s) whose heading diffuses at a rate (1/s), with their headings.

    Directions decorrelate as exp(-rate t): variance 2 rate t of the heading.
    """
    rng = np.random.default_rng(6)
    turns = rng.normal(scale=math.sqrt(2.0 * rate * INTERVAL), size=(runs, length))
    headings = np.cumsum(turns, axis=1)
    places = np.cumsum(speed * INTERVAL * np.exp(1j * headings), axis=1)
    return tracks_of(places, headings)


def test_a_straight_run_has_the_exponent_two_at_every_lag():
    time = INTERVAL * np.arange(LENGTH)
    grown = plane.growth(tracks_of([speed * time + 0j for speed in (50.0, 60.0, 70.0)]))
    assert grown.exponents.value == pytest.approx(2.0, abs=1e-9)  # rounding of the transforms
    assert grown.smallest.mean == pytest.approx(2.0, abs=1e-9)
    assert grown.late.mean == pytest.approx(2.0, abs=1e-9)
    assert grown.crossover is None


def test_a_random_walk_has_the_exponent_one_and_no_crossover():
    steps = np.random.default_rng(1).normal(size=(32, LENGTH, 2)) @ (1.0, 1.0j)
    grown = plane.growth(tracks_of(np.cumsum(steps, axis=1)))
    for value in (grown.first, grown.late):
        assert value.mean == pytest.approx(1.0, abs=4.0 * value.se)
        assert value.se < 0.2
    assert grown.crossover is None  # below halfway from the first lag on


@pytest.mark.parametrize("rate", [2.0, 8.0])
def test_a_persistent_walk_crosses_over_where_its_formula_does(rate):
    lag = np.geomspace(0.01, 10.0, 4001)
    slope = np.gradient(np.log(walks.squared(lag, walks.Spread(1.0, rate, 0.0, 0.0))), np.log(lag))
    expected = float(np.interp(-plane.HALFWAY, -slope, lag))
    grown = plane.growth(persistent(rate, runs=64))
    # The slope over a quarter of a decade shifts the crossing by less than 3 %
    margin = 3.0 * grown.crossover.se + 0.03 * expected
    assert grown.crossover.mean == pytest.approx(expected, abs=margin)
    assert margin < 0.3 * expected
    squares = walks.squared(  # to a quarter of 10 s
        np.array([plane.LATE, 2.5]), walks.Spread(1.0, rate, 0.0, 0.0)
    )
    late = math.log(squares[1] / squares[0]) / math.log(2.5 / plane.LATE)
    assert grown.late.mean == pytest.approx(late, abs=3.0 * grown.late.se + 0.01)
    assert grown.late.se < 0.1


def test_runs_too_short_or_at_rest_have_no_exponents():
    still = tracks_of([np.zeros(LENGTH, complex)] * 3)
    assert plane.growth(still).first is None
    short = tracks_of([np.arange(20.0) + 0j] * 3)
    assert not len(plane.growth(short).exponents.at)


def result(number, places, headings, outcome=Outcome.OK):
    times = INTERVAL * np.arange(len(places))
    rows = np.stack([times, places.real, places.imag, headings, 0.0 * times], axis=1)
    samples = SimpleNamespace(rows=rows, cursor=np.array([len(rows)]))
    return SimpleNamespace(number=number, outcome=outcome, speed=10.0 + number, tally=SimpleNamespace(samples=samples))


def test_runs_become_tracks_with_the_headings_of_films_and_bad_ones_are_left_out():
    time = INTERVAL * np.arange(LENGTH)
    angles = np.linspace(0.1, 3.0, 9)
    # Along their headings, which point every way: 60 mm/s along, 0 across.
    results = [result(n, 60.0 * time * np.exp(1j * a), a + 0.0 * time) for n, a in enumerate(angles)]
    results[3] = results[3].__class__(**(vars(results[3]) | {"outcome": Outcome.TOPPLED}))
    found = plane.measured("measured", 10.0, results)
    assert found.lost == 1
    assert [track.particle for track in found.tracks.tracks] == [0, 1, 2, 4, 5, 6, 7, 8]
    assert found.speed.mean == pytest.approx(10.0 + np.mean([0, 1, 2, 4, 5, 6, 7, 8]))
    moved = found.motion.estimates
    assert moved["parallel_mean"].value == pytest.approx(60.0 * plane.SHORTEST)
    assert moved["orthogonal_mean"].value == pytest.approx(0.0, abs=1e-9)
    assert plane.measured("measured", 10.0, results[2:4]) is None


def test_each_fact_of_figure_6_is_judged_at_its_own_tilt():
    grown = plane.growth(persistent(2.0))
    runs = plane.Runs("measured", 35.0, None, None, grown, Value(1.0, 0.1), 0)
    rows = {row.fact: row for row in compare._of_plane(runs)}
    assert set(rows) == {"superdiffusive at 35", "diffusive at 35", "crossover at 35"}
    assert rows["crossover at 35"].ours == grown.crossover.mean
    rows = list(compare._of_plane(runs._replace(tilt_deg=15.0)))
    assert [row.fact for row in rows] == ["ballistic at 15"]
    assert rows[0].verdict.word == "differs by"


def test_in_space_a_lane_becomes_a_plane_with_the_same_drive_and_contact(scene):
    lane = scene.model_copy(update={"arena": scene.arena.model_copy(update={"length_mm": 300.0, "gap_mm": 8.5})})
    ours = sweeps.on_plane(lane, 0.5)
    assert ours == Scene.model_validate(ours.model_dump())
    assert (ours.arena.kind, ours.legs.model, ours.run.step_us) == ("plane", "space", None)
    assert (ours.drive, ours.contact) == (lane.drive, lane.contact)
    assert ours.arena.length_mm == 300.0
    assert ours.plate.noise_ratio == 0.5
    assert sweeps.on_plane(lane).plate == lane.plate


def test_a_scene_that_space_refuses_is_named_before_anything_runs(design, scene):
    reproduce.check(reproduce.Job(design, scene, scene))
    narrow = {"noise_low_hz": 100.0, "noise_high_hz": 100.1}
    bad = scene.model_copy(update={"plate": scene.plate.model_copy(update=narrow)})
    with pytest.raises(InputError, match="noise_low_hz"):
        reproduce.check(reproduce.Job(design, bad, scene))


def test_a_foot_in_space_lands_with_either_corner_once_within_the_quiet_time():
    quiet = QUIET_S
    rows = np.zeros((5, 7))
    # Time of landing, corner; in the order in which the contacts end.
    rows[:, :2] = [(0.1 * quiet, 1), (0.0, 0), (0.2 * quiet, 3), (0.2 * quiet, 2), (3.0 * quiet, 0)]
    events = SimpleNamespace(rows=rows, cursor=np.array([5]))
    result = SimpleNamespace(tally=SimpleNamespace(events=events))
    landing = sweeps._impacts(result, corners=2).landing
    assert list(landing) == [False, True, True, False, True]


def top(speed, e):
    return [
        Point(f"e = {e}", "space", tilt, 31.0, Value(v, 0.5), None, {}, 0, "")
        for tilt, v in ((7.5, 0.0), (10.0, speed), (12.5, 0.0))
    ]


def findings(labels, assumptions=()):
    return compare.Findings(assumptions, (), (), (), labels, (), ())


def test_the_restitution_of_the_stated_peak_lies_between_those_simulated():
    value = curves.restitution_of_peak({0.1: top(50.0, 0.1), 0.3: top(70.0, 0.3)}, 60.0)
    assert value.mean == pytest.approx(0.2)
    # Halfway: each of both errors counts half, 0.01 of restitution per mm/s.
    assert value.se == pytest.approx(0.01 * 0.5 / math.sqrt(2.0), rel=0.05)  # 1.6 % for the draws
    assert curves.restitution_of_peak({0.1: top(30.0, 0.1), 0.3: top(50.0, 0.3)}, 60.0) is None


def test_proportionality_from_the_scenes_own_drive_up_forgets_the_threshold(scene):
    peak = scene.drive.peak_speed
    series = [
        Point("measured", "space", 15.0, share * peak, Value(speed, 0.1), None, {}, 0, "")
        for share, speed in ((0.7, 0.0), (0.9, 5.0), (1.0, 40.0), (1.2, 48.0), (1.4, 56.0))
    ]
    found = findings({}, [Assumption("measured", scene)])
    row = compare._of_lively(series, found)
    assert row.model == "space, from 1.8 g"
    assert row.ours == pytest.approx(0.0, abs=1e-9)
    assert curves.proportionality(series).mean > 0.2


def test_figure_6_draws_what_there_is(scene):
    low = Assumption(compare.LOW, scene)
    runs = [
        plane.Runs(compare.LOW, tilt, tracks, plane.motion.analyse(tracks), plane.growth(tracks), Value(1.0, 0.1), 0)
        for tilt, tracks in zip(plane.TILTS, (persistent(r, 8, 600) for r in (0.1, 0.2, 8.0)), strict=True)
    ]
    for shown in (runs, runs[:1], []):
        figure = Figure(figsize=(10.0, 6.8), layout="constrained")
        plane_figure.draw(figure, findings({}, [low])._replace(plane=shown))
        assert len(figure.axes) == 6
        tracks = [line for axes in figure.axes[2:4] for line in axes.get_lines()[:-1]]
        drawn = [line.get_color() for line in tracks]
        wanted = [plane_figure.STYLES[one.tilt_deg][0] for one in shown for _ in range(8)]
        assert drawn == wanted
        assert pictures.png(figure, 50).startswith(b"\x89PNG")


@pytest.mark.slow
def test_a_real_run_on_a_plane_goes_through_the_analysis_of_films(design, scene):
    short = scene.run.model_copy(update={"seconds": 1.0, "discard_seconds": 0.3, "runs": 8})
    low = scene.contact.model_copy(update={"restitution": 0.3})
    one = Assumption(compare.LOW, scene.model_copy(update={"run": short, "contact": low}))
    walker = design.variant(tilt_deg=10.0, kind="flexible")
    (found,) = plane.along_tilts([one], [walker], lambda *_: None)
    assert found.lost == 0
    assert len(found.tracks.tracks) == 8
    # 1.5 s every 4 ms, both ends
    assert {len(track.position) for track in found.tracks.tracks} == {376}
    # docs/physics.md section 7: ballistic for seconds; its speeds 5-10 % by independent prototypes
    assert found.growth.smallest.mean > 1.9
    assert found.motion.estimates["speed"].value == pytest.approx(found.speed.mean, rel=0.02)
    assert 55.0 < found.speed.mean < 90.0
    (point,) = sweeps.along_tilts([Case(one, "space", walker)], [10.0], lambda *_: None)
    assert point.speed.mean == pytest.approx(found.speed.mean, rel=0.1)
    assert point.shares["by impulse", "II+III"].mean > 0.2
