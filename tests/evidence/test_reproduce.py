"""`python -m evidence reproduce`: what is simulated, what is compared, and the folder as a user meets it."""

import json
from types import SimpleNamespace

import numpy as np
import pytest
from command_checks import rows_of
from test_growth import INTERVAL, LENGTH, persistent
from typer.testing import CliRunner

from evidence import paper_simulation
from evidence.commands import commands
from evidence.landings import QUIET_S
from evidence.published import FACTS
from evidence.reproduce import compare, curves, figures, growth, impact_types, maximum, mechanisms, runs, theory
from evidence.reproduce import make as reproduce
from evidence.reproduce import motion as on_plane
from evidence.reproduce.report import format_number
from evidence.reproduce.runs import Assumption, Case, Point
from walkergen.analysis import motion
from walkergen.core.files.progress import silent
from walkergen.core.numerics.quantity import Quantity, Verdict, mean
from walkergen.core.scene import Scene
from walkergen.core.simulation import record
from walkergen.core.simulation.run import Outcome, recorded_impacts
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.files import figures as pictures
from walkergen.files import templates
from walkergen.guests.sweep import sweep_setup
from walkergen.points import walkers

FIGURES = ("figure2", "figure5", "figure6", "mechanisms")
TABLES = (
    "figure2_restitutions",
    "figure2_theory",
    "figure3",
    "figure6_densities",
    "figure6_exponents",
    "figure6_tracks",
)
FILES = {f"{name}.{kind}" for name in FIGURES for kind in ("csv", "pdf", "png")}
FILES |= {f"{name}.csv" for name in TABLES} | {"reproduce.csv", "reproduce.md", "manifest.json"}


@pytest.fixture(scope="module")
def design():
    return templates.load("koumakis2016", "walkers", Design)


@pytest.fixture(scope="module")
def scene():
    return templates.load("lane-90hz", "scenes", Scene)


MEASURED = Assumption("measured", templates.load("lane-90hz", "scenes", Scene))


@pytest.fixture
def run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def call(*words):
        return CliRunner().invoke(commands, ["reproduce", *words], catch_exceptions=True)

    return call


def point(model=runs.PAPER_MODEL, tilt=10.0, plate=31.0, speed=60.0, se=0.5, assumption=MEASURED):
    return Point(assumption, model, tilt, plate, Quantity("speed", "mm_s", speed, se), mean("", "", []), {}, 0, "")


def points_along(speed_of, tilts):
    return [point(tilt=tilt, speed=speed_of(tilt)) for tilt in tilts]


FAST_RUN = ("--tilt", "5,10,20", "--gamma", "1.6,2", "--seconds", "0.2")


@pytest.mark.nightly
def test_a_fast_run_makes_every_file(run, tmp_path):
    result = run(*FAST_RUN, "--json")
    assert result.exit_code == 0, result.exception
    folder = tmp_path / json.loads(result.stdout)["folder"]
    assert {path.name for path in folder.glob("[!.]*")} == FILES
    assert len(rows_of(folder / "figure2.csv")) == 3 * 3 * 3  # contacts x series x tilts
    assert len(rows_of(folder / "figure5.csv")) == 3 * 3 * 2
    assert len(rows_of(folder / "figure2_restitutions.csv")) == 3 + 3 * 4 + 3
    tracks = rows_of(folder / "figure6_tracks.csv")
    assert len(tracks) == 3 * 3 * 8 * 8  # contacts x tilts x runs x samples every 40 ms of 0.3 s
    for row in rows_of(folder / "figure3.csv"):
        shares = [float(row[f"share_{kind}"]) for kind in impact_types.TYPES]
        assert sum(shares) == pytest.approx(1.0, abs=1e-12)  # rounding of six numbers
    assert {row["fact"] for row in rows_of(folder / "reproduce.csv")} == set(FACTS)
    page = (folder / "reproduce.md").read_text()
    assert all(page.count(fact.quote) >= 1 for fact in FACTS.values())


@pytest.mark.nightly
def test_equal_runs_make_equal_files(run, tmp_path):
    for folder in ("once", "again"):
        result = run(*FAST_RUN, "--out", folder)
        assert result.exit_code == 0, result.exception
    for name in FILES:
        assert (tmp_path / "once" / name).read_bytes() == (tmp_path / "again" / name).read_bytes(), name
    assert "= agrees, ! disagrees, ? undecided" in result.stdout


@pytest.mark.nightly
def test_ctrl_c_keeps_the_figures_already_done(run, tmp_path, monkeypatch):
    def some(cases, progress):
        if any(case.gamma for case in cases):
            raise KeyboardInterrupt
        return [point(case.model, case.design.tilt_deg, assumption=case.assumption) for case in cases]

    monkeypatch.setattr(runs, "simulate_cases", some)
    assert run("--tilt", "5,10,20", "--out", "here").exit_code == 130
    names = {path.name for path in (tmp_path / "here").glob("[!.]*")}
    assert names == {name for name in FILES if name.startswith(("figure2", "figure3"))}


@pytest.mark.parametrize("name", ["figure2", "figure2-restitutions", "figure5", "figure6"])
def test_the_shipped_sweeps_are_requests_of_their_own(name):
    request = sweep_setup.from_file(templates.folder() / "sweeps" / f"{name}.toml")
    assert request.space.point_count == np.prod([len(values) for values in runs.sweep_values(name)])
    assert request.point({}).simulated


@pytest.mark.parametrize(
    ("tilt", "mode", "factor"),
    [(10, "paper", 3.9965), (20, "coulomb", 2.377), (35, "paper", 1.316), (5, "paper", 5.2415), (5, "coulomb", 5.001)],
)
def test_the_theory_drawn_has_the_known_values(design, tilt, mode, factor):
    # docs/physics.md section 4, e = 0.9, mu = 0.1: means of its back and front, for masses that are
    # rounded to three digits.
    scene = templates.load("lane-90hz-fitted", "scenes", Scene)
    curve = theory.compute_curve(design, scene, mode, 0.0, 45.0)
    (at,) = np.flatnonzero(curve.tilt_deg == tilt)
    impact_speed = scene.prediction.impact_speed_factor * scene.drive.peak_speed
    assert curve.speed[at] / impact_speed == pytest.approx(factor, abs=3e-3)


def test_the_contacts_are_those_that_the_paper_measured_and_fitted():
    contacts = [one.scene.contact for one in reproduce.make_assumptions(reproduce.make_job(None, None, {}))]
    assert [contact.restitution for contact in contacts] == [FACTS["restitution"].value, 0.9, 0.3]
    assert contacts[0].friction == contacts[2].friction == FACTS["friction"].value
    for name in ("restitution", "friction"):
        sd = FACTS[name].high - FACTS[name].value
        assert getattr(contacts[0], f"{name}_sd") == pytest.approx(sd)


def test_impacts_at_the_theorys_stationary_speed_are_of_type_three(design):
    for name in ("lane-90hz", "lane-90hz-fitted"):
        own = templates.load(name, "scenes", Scene)
        assert theory.share_of_type_three(design, own, (0.0, 5.0, 20.0, 45.0), "coulomb") == 1.0


def test_the_theorys_maximum_lies_below_ten_degrees_for_realistic_contacts(design):
    tilts = maximum.find_tilts(design, "coulomb")
    assert 0.25 < tilts.low_deg < tilts.high_deg < 10.0


def test_a_peak_needs_three_speeds_and_lower_ones_on_both_sides():
    series = points_along(lambda tilt: 60.0 - (tilt - 9.0) ** 2, (5.0, 8.0, 12.0))
    gap = point(tilt=20.0, speed=None)
    assert curves.find_peak(series).place.value == pytest.approx(9.0)
    assert curves.find_peak([*series, gap]) == curves.find_peak(series)
    assert curves.find_peak([*series[:2], gap]) == curves.NO_TOP
    assert curves.find_peak(points_along(lambda tilt: 60.0 - tilt, (5.0, 8.0, 12.0))) == curves.NO_TOP


def test_a_walker_at_rest_is_not_proportional_to_anything():
    assert curves.proportionality([point(plate=p, speed=0.0, se=0.0) for p in (1.0, 2.0)]).value is None


def test_proportionality_from_the_scenes_own_drive_up_forgets_the_threshold(scene):
    drives = ((0.7, 0.0), (0.9, 5.0), (1.0, 40.0), (1.2, 48.0), (1.4, 56.0))
    peak = scene.drive.peak_speed
    series = [point("space", 15.0, share * peak, speed, 0.1) for share, speed in drives]
    whole, lively = compare.compare_facts(compare.Findings([], [], [], [], drives=series))
    assert lively.model == "space, from 1.8 g"
    assert lively.ours.value == pytest.approx(0.0, abs=1e-7)
    assert whole.ours.value > 20.0


def test_the_restitution_of_the_stated_peak_lies_between_those_simulated():
    def top(speed):
        return [point("space", tilt, speed=height) for tilt, height in ((7.5, 0.0), (10.0, speed), (12.5, 0.0))]

    restitution = curves.restitution_of_peak({0.1: top(50.0), 0.3: top(70.0)}, 60.0)
    assert restitution.value == pytest.approx(0.2)
    # Halfway: each of both errors counts half, 0.01 of restitution per mm/s.
    assert restitution.se == pytest.approx(0.01 * 0.5 / np.sqrt(2.0), rel=0.05)  # 1.6 % for the draws
    assert curves.restitution_of_peak({0.1: top(30.0), 0.3: top(50.0)}, 60.0).value is None


def test_each_fact_of_figure_6_is_judged_at_its_own_tilt():
    grown = growth.measure_growth(persistent(2.0))
    slow = on_plane.Runs("measured", 35.0, None, None, grown, mean("speed", "mm_s", [1.0, 2.0]), 0)
    rows = compare.compare_facts(compare.Findings([], [], [], [], plane=[slow, slow._replace(tilt_deg=15.0)]))
    facts = ["ballistic at 15", "superdiffusive at 35", "diffusive at 35", "crossover at 35"]
    assert [row.fact for row in rows] == facts
    assert rows[3].ours == grown.crossover
    assert rows[0].verdict is Verdict.DISAGREE


@pytest.mark.nightly
def test_a_plate_too_weak_to_lift_anything_is_reported(design, scene, tmp_path):
    weak = scene.variant(**{"drive.gamma": 0.5, "run.seconds": 0.2, "run.discard_seconds": 0.05, "run.runs": 8})
    job = reproduce.Job(design, weak, weak, [5.0, 10.0, 15.0], [0.4, 0.5])
    found = reproduce.reproduce(job, tmp_path / "weak", silent)
    rows = [row for row in found.facts["rows"] if row["fact"] == "proportional"]
    assert len(rows) == 3 * 4  # contacts x (series, and space from the scene's own drive up)
    assert "agree" not in {row["verdict"] for row in rows}


def test_another_gamma_changes_the_amplitude_and_keeps_the_frequency(design, scene):
    drive = Case(MEASURED, "space", design, 2.7).scene.drive
    assert (drive.frequency, drive.peak_gamma) == (90.0, pytest.approx(2.7))
    assert drive.peak_speed == pytest.approx(1.5 * scene.drive.peak_speed)


def test_in_space_a_lane_becomes_a_plane_with_the_same_drive_and_contact(scene):
    lane = scene.model_copy(update={"arena": scene.arena.model_copy(update={"length_mm": 300.0, "gap_mm": 8.5})})
    ours = runs.move_to_plane(lane, 0.5, 0.5)
    assert ours == Scene.model_validate(ours.model_dump())
    assert (ours.arena.kind, ours.run.step_us) == ("plane", None)
    assert (ours.drive, ours.contact, ours.arena.length_mm) == (lane.drive, lane.contact, 300.0)
    assert ours.plate.noise_ratio == 0.5
    assert runs.move_to_plane(lane, 0.5).plate == lane.plate


@pytest.fixture(scope="module")
def case(design, scene):
    short = scene.run.model_copy(update={"seconds": 0.3, "discard_seconds": 0.1, "runs": 3})
    return Case(Assumption("measured", scene.model_copy(update={"run": short})), "space", design)


def test_every_impact_of_the_tally_is_an_event_and_landings_are_fewer(case):
    for result in walkers.simulate(case.walker()).results:
        rows = recorded_impacts(result)
        impacts = impact_types.classify_impacts(rows, 2)
        assert len(impacts.kind) == result.tally.counts[record.IMPACTS] > 40
        assert 0 < impacts.landing.sum() < len(rows)
        for foot in (0, 1):
            times = np.sort(rows[impacts.landing & (rows[:, 1] // 2 == foot), 0])
            assert np.diff(times).min() > QUIET_S


def test_the_papers_own_model_gives_its_speed_and_its_types(case, monkeypatch):
    paper = case._replace(model=runs.PAPER_MODEL, design=case.design.variant(tilt_deg=10.0))
    (found,) = runs.simulate_cases([paper], silent)
    own = paper_simulation.simulate(paper.scene, paper.design, solids.mass_of(paper.design))
    assert found.speed == mean("speed", "mm_s", [run.speed for run in own])
    assert found.shares["landings", "II+III"].value > 0.5
    assert (found.lost, found.outcomes) == (0, "3 ok")
    fallen = paper_simulation.Run(97.5, paper_simulation.FALLEN, np.zeros((0, 7)))
    monkeypatch.setattr(paper_simulation, "simulate", lambda *_: [fallen] * 3)
    (found,) = runs.simulate_cases([paper], silent)
    assert (found.lost, found.outcomes, found.speed.value) == (3, "3 toppled", None)


def test_room_for_impacts_grows_until_it_holds_them_all(case, monkeypatch):
    (whole,) = runs.simulate_cases([case], silent)
    monkeypatch.setattr("walkergen.core.simulation.run.FIRST_EVENT_ROOM", -8.5)  # 26 impacts' room at first
    (grown,) = runs.simulate_cases([case], silent)
    assert grown == whole
    assert whole.lost == 0


@pytest.mark.parametrize(("lost", "known"), [(1, True), (2, False)])
def test_runs_that_ended_badly_are_left_out_of_the_means(case, monkeypatch, lost, known):
    real, kept = walkers.simulate_each, []

    def bad(*words):
        for point in real(*words):
            kept.extend(result.speed for result in point.results[lost:])
            toppled = [result._replace(outcome=Outcome.TOPPLED) for result in point.results[:lost]]
            yield point._replace(results=[*toppled, *point.results[lost:]])

    monkeypatch.setattr(walkers, "simulate_each", bad)
    (found,) = runs.simulate_cases([case], silent)
    assert found.lost == lost
    assert found.speed == mean("speed", "mm_s", kept if known else [])


def test_runs_become_tracks_with_the_headings_of_films_and_bad_ones_are_left_out():
    def result(number, places, headings, outcome):
        times = INTERVAL * np.arange(LENGTH)
        rows = np.stack([times, places.real, places.imag, headings, 0.0 * times], axis=1)
        tally = SimpleNamespace(samples=SimpleNamespace(rows=rows, cursor=np.array([LENGTH])))
        return SimpleNamespace(number=number, outcome=outcome, speed=10.0 + number, tally=tally)

    time = INTERVAL * np.arange(LENGTH)
    # Along their headings, which point every way: 60 mm/s along, 0 across.
    results = [
        result(n, 60.0 * time * np.exp(1j * a), a + 0.0 * time, Outcome.TOPPLED if n == 3 else Outcome.OK)
        for n, a in enumerate(np.linspace(0.1, 3.0, 9))
    ]
    found = on_plane.analyse_runs("measured", 10.0, results)
    assert found.lost == 1
    assert [track.particle for track in found.tracks.tracks] == [0, 1, 2, 4, 5, 6, 7, 8]
    assert found.speed.value == pytest.approx(10.0 + np.mean([0, 1, 2, 4, 5, 6, 7, 8]))
    moved = found.motion.estimates
    assert moved["parallel_mean"].value == pytest.approx(60.0 * growth.MIN_LAG_S)
    assert moved["orthogonal_mean"].value == pytest.approx(0.0, abs=1e-9)
    assert on_plane.analyse_runs("measured", 10.0, results[2:4]) is None


def test_figure_6_draws_partial_results(scene):
    low, speed = Assumption(compare.LOW_RESTITUTION, scene), mean("speed", "mm_s", [1.0, 2.0])
    tracks = [persistent(rate, 8, 600) for rate in (0.1, 0.2, 8.0)]
    plane = [
        on_plane.Runs(compare.LOW_RESTITUTION, tilt, own, motion.analyse(own), growth.measure_growth(own), speed, 0)
        for tilt, own in zip((10.0, 15.0, 35.0), tracks, strict=True)
    ]
    for shown in (plane, plane[:1], []):
        figure = figures.figure6(compare.Findings([low], [], [], [], plane=shown))
        assert pictures.png(figure, 50).startswith(b"\x89PNG")


@pytest.mark.slow
def test_a_real_run_on_a_plane_goes_through_the_analysis_of_films(design, scene):
    short = scene.run.model_copy(update={"seconds": 1.0, "discard_seconds": 0.3, "runs": 8})
    low = scene.contact.model_copy(update={"restitution": 0.3})
    one = Assumption(compare.LOW_RESTITUTION, scene.model_copy(update={"run": short, "contact": low}))
    walker = design.variant(tilt_deg=10.0, kind="flexible")
    (found,) = on_plane.simulate_plane([one], [walker], silent)
    assert found.lost == 0
    # 1.5 s every 4 ms, both ends
    assert [len(track.position) for track in found.tracks.tracks] == [376] * 8
    # docs/physics.md section 7: ballistic for seconds
    assert found.growth.smallest.value > 1.9
    assert found.motion.estimates["speed"].value == pytest.approx(found.speed.value, rel=0.02)
    assert 40.0 < found.speed.value < 60.0
    (space,) = runs.simulate_cases([Case(one, "space", walker)], silent)
    assert space.speed.value == pytest.approx(found.speed.value, rel=0.1)
    assert space.shares["by impulse", "II+III"].value > 0.2


@pytest.mark.parametrize(
    ("value", "se", "shown"),
    [
        (63.04, 0.76, "63.0 ± 1.5"),
        (153.2, 34.0, "153 ± 68"),
        (0.3, 0.0, "0.3"),
        (5.75, 0.07, "5.75 ± 0.14"),
        (-0.004, 0.3, "0.0 ± 0.6"),
        (12.0, None, "12"),
    ],
)
def test_numbers_show_the_digits_that_their_error_leaves(value, se, shown):
    assert format_number(Quantity("", "", value, se)) == shown


@pytest.mark.parametrize(
    ("speed", "theory", "direction"),
    [
        (4.0, 5.0, "same"),
        (-4.0, 5.0, "opposite"),
        (-4.0, -5.0, "same"),
        (1.9, 5.0, "undecided"),
        (None, 5.0, "undecided"),
        (4.0, 0.0, "undecided"),
    ],
)
def test_directions_are_judged_by_the_bounds_of_the_simulated_speed(speed, theory, direction):
    own, expected = Quantity("speed", "mm_s", speed, 1.0), Quantity("theory", "mm_s", theory, 1.0)
    found = Point(None, "space", 0.0, 31.0, own, own, {}, 0, "")
    assert mechanisms.Mechanism("x", Design(), expected, "balance", found).direction == direction


def test_the_mechanisms_are_those_of_the_paper(design):
    found = mechanisms.load_designs(design)
    assert [design.kind for _, design in found] == ["flexible", "braced", "braced"]
    frictions = {limb.friction for limb in found[1][1].limbs}
    assert frictions == {0.1, 0.6}
    assert {limb.friction for limb in found[2][1].limbs} == {None}
    lengths = {limb.length for limb in found[2][1].limbs}
    assert len(lengths) == 2
