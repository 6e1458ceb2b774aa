"""`reproduce`: sweeps, what is compared, and the folder as a user meets it."""

import csv
import json

import numpy as np
import pytest
from typer.testing import CliRunner

from walkergen.analysis.landings import QUIET_S
from walkergen.analysis.values import Value, mean
from walkergen.cli import command_line
from walkergen.errors import InputError
from walkergen.files import templates
from walkergen.jobs.trust.reproduce import compare, curves, sweeps, theory
from walkergen.jobs.trust.reproduce import make as reproduce
from walkergen.jobs.trust.reproduce.report import number
from walkergen.jobs.trust.reproduce.sweeps import Assumption, Case, Point
from walkergen.scene import Scene
from walkergen.simulation import ensemble
from walkergen.simulation.plan import prepare
from walkergen.simulation.run import Outcome, impacts_of
from walkergen.theory import maximum
from walkergen.walker.design import Design

FILES = {
    "figure2.csv",
    "figure2.pdf",
    "figure2.png",
    "figure2_labels.csv",
    "figure2_theory.csv",
    "figure3.csv",
    "figure3.pdf",
    "figure3.png",
    "figure5.csv",
    "figure5.pdf",
    "figure5.png",
    "figure6.csv",
    "figure6.pdf",
    "figure6.png",
    "figure6_densities.csv",
    "figure6_exponents.csv",
    "figure6_tracks.csv",
    "mechanisms.csv",
    "mechanisms.pdf",
    "mechanisms.png",
    "reproduce.csv",
    "reproduce.md",
}

SCENE = """
[drive]
frequency_hz = 90.0
gamma = 1.8

[contact]
restitution = {restitution}
friction = {friction}

[run]
discard_seconds = 0.05
"""


@pytest.fixture(scope="module")
def design():
    return templates.load("koumakis2016", "walkers", Design)


@pytest.fixture
def run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "measured.toml").write_text(SCENE.format(restitution=0.8, friction=0.25))
    (tmp_path / "fitted.toml").write_text(SCENE.format(restitution=0.9, friction=0.1))
    words = ("--scene", "measured.toml", "--scene-fitted", "fitted.toml")

    def call(*more):
        return CliRunner().invoke(command_line, ["reproduce", *words, *more], catch_exceptions=True)

    return call


def point(model="compliant", tilt=10.0, plate=31.0, speed=(60.0, 1.0), shares=None, lost=0):
    value = None if speed is None else Value(*speed)
    return Point("measured", model, tilt, plate, value, Value(50.0, 1.0), shares or {}, lost, "")


def table(path):
    with path.open() as file:
        return list(csv.DictReader(file))


FAST = ("--tilt", "5,10,20", "--gamma", "1.6,2", "--seconds", "0.2")


@pytest.mark.slow
def test_a_fast_run_makes_every_file(run, tmp_path):
    result = run(*FAST, "--json")
    assert result.exit_code == 0, result.exception
    found = json.loads(result.stdout)
    folder = tmp_path / found["folder"]
    assert {path.name for path in folder.glob("[!.]*")} == FILES
    for number_ in (2, 3, 5, 6):
        assert (folder / f"figure{number_}.png").read_bytes().startswith(b"\x89PNG")
        assert (folder / f"figure{number_}.pdf").read_bytes().startswith(b"%PDF")

    speeds = table(folder / "figure2.csv")
    assert len(speeds) == 3 * 5 * 3  # contacts x series x tilts
    assert len(table(folder / "figure5.csv")) == 3 * 4 * 2
    assert len(table(folder / "figure2_labels.csv")) == 3 + 3 * 4 + 3
    tracks = table(folder / "figure6_tracks.csv")
    assert len(tracks) == 3 * 3 * 8 * 8  # contacts x tilts x runs x samples every 40 ms of 0.3 s
    for row in table(folder / "figure3.csv"):
        shares = [float(row[f"share_{kind}"]) for kind in sweeps.TYPES]
        assert sum(shares) == pytest.approx(1.0, abs=1e-12)  # rounding of six numbers
    compared = table(folder / "reproduce.csv")
    assert {row["fact"] for row in compared} == set(compare.FACTS)
    page = (folder / "reproduce.md").read_text()
    assert all(page.count(fact.quote) >= 1 for fact in compare.FACTS.values())
    width = {line.count("|") for line in page.splitlines() if line.startswith("|")}
    assert width == {6, 7}  # comparison, mechanisms: a cell with a bar of its own would break the table


@pytest.mark.nightly
def test_equal_runs_make_equal_files(run, tmp_path):
    for folder in ("once", "again"):
        result = run(*FAST, "--out", folder)
        assert result.exit_code == 0, result.exception
    for name in FILES:
        once, again = ((tmp_path / folder / name).read_bytes() for folder in ("once", "again"))
        assert once == again, name
    assert "= agrees, ! differs, ? undecided" in result.stdout
    assert max(map(len, result.stdout.splitlines())) <= 100


@pytest.mark.nightly
def test_ctrl_c_keeps_the_figures_already_done(run, tmp_path, monkeypatch):
    def some(cases, tilts, progress):
        return [point(case.model, tilt)._replace(assumption=case.assumption.name) for case in cases for tilt in tilts]

    def interrupted(cases, gammas, progress):
        raise KeyboardInterrupt

    monkeypatch.setattr(sweeps, "along_tilts", some)
    monkeypatch.setattr(sweeps, "along_drives", interrupted)
    result = run("--tilt", "5,10,20", "--out", "here")
    assert result.exit_code == 130
    names = {path.name for path in (tmp_path / "here").glob("[!.]*")}
    kept = {name for name in FILES if name.startswith(("figure2", "figure3"))}
    assert names == kept | {"figure2_labels.csv"}


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--runs", "7"), "--runs 7: at least 8"),
        (("--tilt", "5,10"), "--tilt 5,10: give 3 or more"),
        (("--tilt", "5,15,10"), "each above the last"),
        (("--tilt=-5,0,5",), "none negative"),
        (("--tilt", "0,10,84"), "tilt_deg"),
        (("--gamma", "1.8"), "--gamma 1.8: give 2 or more"),
        (("--gamma", "1.8,fast"), "--gamma '1.8,fast': write numbers"),
        (("--gamma", "nan,2"), "--gamma 'nan,2': write numbers"),
        (("--seconds", "0"), "seconds"),
        (("--seconds", "0.05"), "--seconds 0.05: at least 0.1"),
        (("--scene", "nowhere"), "no such template"),
    ],
)
def test_bad_input_is_named_before_anything_is_written(run, tmp_path, words, told):
    result = run(*words)
    assert result.exit_code != 0
    assert told in str(result.exception)
    assert not (tmp_path / "out").exists()


def test_another_law_is_refused_for_the_papers_is_poissons(design):
    scene = templates.load("lane-90hz", "scenes", Scene)
    newton = scene.model_copy(update={"contact": scene.contact.model_copy(update={"law": "newton"})})
    with pytest.raises(InputError, match=r"contact\.law = 'newton'"):
        reproduce.check(reproduce.Job(design, newton, scene))


@pytest.mark.parametrize(
    ("tilt", "mode", "mean"),
    [(10, "paper", 3.9965), (20, "coulomb", 2.377), (35, "paper", 1.316), (5, "paper", 5.2415), (5, "coulomb", 5.001)],
)
def test_the_theory_drawn_has_the_known_values(design, tilt, mode, mean):
    # docs/physics.md section 4, e = 0.9, mu = 0.1: means of its back and front, for masses that are
    # rounded to three digits.
    scene = templates.load("lane-90hz-fitted", "scenes", Scene)
    curve = theory.curve(design, scene, mode, 0.0, 45.0)
    (at,) = np.flatnonzero(curve.tilt_deg == tilt)
    assert curve.speed[at] / scene.impact_speed == pytest.approx(mean, abs=3e-3)  # for masses of three digits


def test_the_contact_that_the_paper_measured_is_taken_where_a_scene_gives_none(design):
    lane = templates.load("lane-90hz", "scenes", Scene)
    fitted = templates.load("lane-90hz-fitted", "scenes", Scene)
    for scene, restitution in ((lane, 0.8), (lane.variant(**{"contact.restitution": 0.6}), 0.6)):
        measured, other, low = reproduce.assumptions_of(reproduce.Job(design, scene, fitted))
        assert measured.scene.contact.restitution == restitution
        assert (other.scene.contact.restitution, low.scene.contact.restitution) == (0.9, 0.3)
        assert {one.scene.contact.friction for one in (measured, low)} == {0.25}


def test_impacts_at_the_theorys_stationary_speed_are_of_type_three(design):
    for name in ("lane-90hz", "lane-90hz-fitted"):
        scene = templates.load(name, "scenes", Scene)
        share = compare.stationary_type_three(design, scene, (0.0, 5.0, 20.0, 45.0), "coulomb")
        assert share == 1.0


def test_the_theorys_maximum_lies_below_ten_degrees_for_realistic_contacts(design):
    found = maximum.tilts(design, "coulomb")
    assert 0.25 < found.low_deg < found.high_deg < 10.0


def test_a_parabola_gives_its_own_top():
    series = [point(tilt=t, speed=(60.0 - (t - 11.0) ** 2, 1e-6)) for t in (5.0, 8.0, 12.0, 15.0)]
    top = curves.peak(series)
    assert top.place.mean == pytest.approx(11.0)
    assert top.height.mean == pytest.approx(60.0)
    assert top.place.se == pytest.approx(3.5 / np.sqrt(12.0), rel=0.01)  # of the grid alone


def test_the_peaks_error_is_that_of_the_speeds():
    series = [point(tilt=t, speed=(s, 2.0)) for t, s in ((5.0, 0.0), (10.0, 90.0), (15.0, 0.0))]
    top = curves.peak(series)
    assert top.place.mean == 10.0
    assert top.height.se == pytest.approx(2.0, rel=0.05)  # 1.6 % for the draws


def test_tilts_without_a_speed_are_passed_over_and_too_few_are_no_peak():
    series = [point(tilt=t, speed=(60.0 - (t - 9.0) ** 2, 0.1)) for t in (5.0, 8.0, 12.0)]
    gap = point(tilt=20.0, speed=None)
    assert curves.peak([*series, gap]) == curves.peak(series)
    assert curves.peak([*series[:2], gap]) is None


def test_a_largest_speed_at_an_end_of_the_tilts_is_no_peak():
    series = [point(tilt=t, speed=(60.0 - t, 0.1)) for t in (5.0, 8.0, 12.0)]
    assert curves.peak(series) is None
    assert curves.peak([point(tilt=0.0, speed=(0.0, 0.1)), *series]).place.mean > 0.0


def test_a_line_through_zero_is_proportional_and_a_threshold_is_not():
    line = [point(plate=p, speed=(2.0 * p, 0.1)) for p in (10.0, 20.0, 30.0, 40.0)]
    assert curves.through_zero(line).mean == pytest.approx(2.0)
    assert curves.proportionality(line).mean == pytest.approx(0.0, abs=1e-12)
    # 0, 0, 0, 80: slope 80 x 40/3000, rms distance by hand.
    jump = [point(plate=p, speed=(80.0 * (p > 35), 0.1)) for p in (10.0, 20.0, 30.0, 40.0)]
    slope = 80.0 * 40.0 / 3000.0
    rms = np.sqrt((slope**2 * 1400.0 + (80.0 - 40.0 * slope) ** 2) / 4.0)
    assert curves.proportionality(jump).mean == pytest.approx(rms / 20.0)


def test_a_walker_at_rest_is_not_proportional_to_anything():
    assert curves.proportionality([point(plate=p, speed=(0.0, 0.0)) for p in (1.0, 2.0)]) is None


@pytest.mark.nightly
def test_a_plate_too_weak_to_lift_anything_is_told_not_crashed_on(run, tmp_path):
    weak = SCENE.format(restitution=0.8, friction=0.25).replace("gamma = 1.8", "gamma = 0.5")
    (tmp_path / "measured.toml").write_text(weak)
    (tmp_path / "fitted.toml").write_text(weak)
    words = ("--tilt", "5,10,15", "--gamma", "0.4,0.5", "--seconds", "0.2", "--json")
    result = run(*words)
    assert result.exit_code == 0, result.exception
    rows = [row for row in json.loads(result.stdout)["rows"] if row["fact"] == "proportional"]
    assert len(rows) == 3 * 5  # contacts x (series, and space from the scene's own drive up)
    told = {row["verdict"]["word"] for row in rows}
    assert told <= {"not measured", "undecided", "differs by"}


def test_standard_error_of_independent_runs():
    assert mean([1.0, 3.0]) == Value(2.0, 1.0)


def test_another_gamma_changes_the_amplitude_and_keeps_the_frequency():
    scene = templates.load("lane-90hz", "scenes", Scene)
    driven = sweeps.driven(scene, 2.7)
    assert driven.drive.frequency == 90.0
    assert driven.drive.peak_gamma == pytest.approx(2.7)
    assert driven.drive.peak_speed == pytest.approx(1.5 * scene.drive.peak_speed)


@pytest.fixture(scope="module")
def case(design):
    scene = templates.load("lane-90hz", "scenes", Scene)
    short = scene.run.model_copy(update={"seconds": 0.3, "discard_seconds": 0.1, "runs": 2})
    scene = scene.model_copy(update={"run": short})
    return Case(Assumption("measured", scene), "compliant", design)


def silent(what, done, total):
    pass


def simulated(case):
    scene, design, mass = sweeps._asked(case)
    return ensemble.measure(prepare(scene, design, mass), silent, impacts=True)


def test_every_impact_of_the_tally_is_an_event(case):
    # Of the compliant walker; relaxed legs make one event of a whole cascade.
    _, results = simulated(case)
    for result in results:
        kinds = sweeps._impacts(result).kind
        assert len(kinds) > 100
        counted = sweeps._of_counts(result.tally.counts)
        assert sweeps._of_events(kinds, np.ones(len(kinds))) == pytest.approx(counted)


def test_landings_are_fewer_than_impacts_and_no_foot_lands_twice_within_the_quiet_time(case):
    _, (result, _) = simulated(case)
    impacts, rows = sweeps._impacts(result), impacts_of(result)
    assert 0 < impacts.landing.sum() < len(rows)
    for foot in (0, 1):
        times = rows[impacts.landing & (rows[:, 1] == foot), 0]
        assert np.diff(times).min() > QUIET_S


def test_room_for_impacts_grows_until_it_holds_them_all(case, monkeypatch):
    (whole,) = sweeps.along_tilts([case], [10.0], silent)
    monkeypatch.setattr("walkergen.simulation.run.FIRST_ROOM", -8.5)  # 26 impacts' room at first
    (grown,) = sweeps.along_tilts([case], [10.0], silent)
    assert grown == whole
    assert whole.lost == 0


@pytest.mark.parametrize(("lost", "known"), [(1, True), (2, False)])
def test_runs_that_ended_badly_are_left_out_of_the_means(case, monkeypatch, lost, known):
    scene = case.assumption.scene
    three = scene.model_copy(update={"run": scene.run.model_copy(update={"runs": 3})})
    asked = case._replace(assumption=Assumption("measured", three))
    real, kept = ensemble.measure, []

    def bad(*words, **more):
        summary, results = real(*words, **more)
        kept.extend(result.speed for result in results[lost:])
        return summary, [
            result._replace(outcome=Outcome.TOPPLED) if place < lost else result for place, result in enumerate(results)
        ]

    monkeypatch.setattr(ensemble, "measure", bad)
    (found,) = sweeps.along_tilts([asked], [asked.design.tilt_deg], silent)
    assert found.lost == lost
    assert found.speed == (mean(kept) if known else None)


def test_shares_by_hand():
    kinds = np.array([3, 3, 2, 1, 5, -2, -3, 4])
    assert sweeps._of_events(kinds, np.ones(8)) == pytest.approx(np.array([2, 1, 1, 1, 1, 2]) / 8)
    weights = np.array([7.0, 0, 0, 1, 0, 0, 0, 0])
    assert sweeps._of_events(kinds, weights)[:3] == pytest.approx([7 / 8, 0.0, 1 / 8])
    counts = np.array([8, 1, 1, 2, 1, 1, 1, 1, 5])
    assert sweeps._of_counts(counts) == pytest.approx(np.array([2, 1, 1, 1, 1, 2]) / 8)


@pytest.mark.parametrize(
    ("value", "se", "told"),
    [
        (63.04, 0.76, "63.0 ± 1.5"),
        (63.04, 4.0, "63 ± 8"),
        (0.3, 0.0, "0.3"),
        (153.2, 34.0, "153 ± 68"),
        (5.75, 0.07, "5.75 ± 0.14"),
        (-0.004, 0.3, "0.0 ± 0.6"),
        (12.0, None, "12"),
    ],
)
def test_numbers_show_the_digits_that_their_error_leaves(value, se, told):
    assert number(value, se) == told
