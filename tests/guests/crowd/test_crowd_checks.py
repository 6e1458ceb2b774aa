"""Checks of crowds in a plane: meetings that are known in closed form, and the command's table."""

import csv
import math

import numpy as np
import pytest
from flat_cards import BOX, silent, with_lammps
from typer.testing import CliRunner

from evidence.commands import commands
from evidence.crowd_checks import checks, crowds, make, meetings, reasons, report, setting
from evidence.crowd_checks.meetings import MEETINGS
from evidence.crowd_checks.parts import Parts
from evidence.crowd_checks.report import Checked, Row
from evidence.crowd_checks.setting import RATE_HZ
from walkergen.core.errors import InputError
from walkergen.core.numerics.quantity import Quantity, Verdict
from walkergen.guests.crowd import in_plane
from walkergen.guests.crowd.flat import lammps_engine

OUTLINE = np.array(BOX)


def filmed(meeting, restitution, frames=90):
    """Two that walk at 60 mm/s, and at their first touch keep a share of their approach."""
    two = meetings.start_places(meeting, OUTLINE, np.random.default_rng(1))
    way = meetings.approach_direction(meeting)
    velocity = 60.0 * np.stack([(np.cos(a), np.sin(a)) for a in two[:, 2]])
    poses = []
    for _ in range(frames):
        poses.append(two.copy())
        together = (velocity[0] - velocity[1]) @ way
        if together > 0.0 and meetings.body_gaps(OUTLINE, two[0], two[1]) < 0.5:
            change = 0.5 * (1.0 + restitution) * together * way
            velocity += np.stack((-change, change))
        two[:, :2] += velocity / RATE_HZ
    return np.array(poses)


@pytest.mark.parametrize("meeting", MEETINGS, ids=lambda meeting: meeting.name)
def test_two_meet_in_every_way_and_keep_what_their_blow_leaves(meeting):
    found = meetings.measure_meeting(meeting, OUTLINE, filmed(meeting, 0.4))
    assert found["velocity_kept"] == pytest.approx(0.4, abs=0.25)
    assert found["turn_in_0.3_s"] == 0.0
    assert found["time_together"] < 0.6


@pytest.mark.parametrize("meeting", MEETINGS, ids=lambda meeting: meeting.name)
def test_both_have_as_far_to_go_and_touch_where_they_should(meeting):
    two = meetings.start_places(meeting, OUTLINE, np.random.default_rng(2))
    ways = []
    for way in np.linspace(0.0, 20.0, 2001):
        now = two.copy()
        now[:, :2] += way * np.stack([(np.cos(a), np.sin(a)) for a in two[:, 2]])
        if meetings.body_gaps(OUTLINE, now[0], now[1]) <= 0.0:
            ways.append(way)
    assert meetings.MIN_WAY_MM - 0.02 <= min(ways) <= meetings.MAX_WAY_MM + 0.02


def test_two_that_miss_each_other_are_no_meeting():
    poses = filmed(MEETINGS[0], 0.4)
    poses[:, 1, 1] += 50.0
    assert meetings.measure_meeting(MEETINGS[0], OUTLINE, poses) is None


def test_pairs_of_a_run_are_out_of_each_others_reach():
    one = silent()
    places = checks.pair_places(setting.QUICK, one, MEETINGS[1], 0)
    middles = places.reshape(-1, 2, 3)[:, :, :2].mean(axis=1)
    apart = np.hypot(*(middles[:, None] - middles[None]).transpose(2, 0, 1))
    assert apart[~np.eye(len(middles), dtype=bool)].min() > 100.0


def row(check, space, plane, unit="mm_s"):
    return Row(check, "", Quantity("number", unit, *space), Quantity("number", unit, *plane))


def test_a_verdict_is_by_the_bounds_of_the_difference_and_noise_makes_none_agree():
    assert row("collective", (20.0, 0.3), (20.5, 0.3)).verdict == Verdict.AGREE
    assert row("collective", (20.0, 3.0), (20.5, 3.0)).verdict == Verdict.UNDECIDED
    assert row("collective", (10.0, 3.0), (20.0, 4.0)).verdict == Verdict.UNDECIDED
    assert row("collective", (10.0, 0.3), (20.0, 0.4)).verdict == Verdict.DISAGREE
    # An order near 0 need not be so to a tenth
    assert row("collective", (0.02, 0.005), (0.04, 0.005), "").verdict == Verdict.AGREE
    # The plane's input is the number of space: its own error alone parts them
    assert row("single", (10.0, 3.0), (10.1, 0.25)).verdict == Verdict.AGREE
    assert row("binary", (10.0, 3.0), (10.1, 0.25)).verdict == Verdict.UNDECIDED


def of(key, *numbers):
    return Quantity(key, "", *numbers)


def test_the_report_says_of_its_own_rows_where_cards_hold_and_why(tmp_path):
    rubbed = {"head on": {"along": of("along", 0.1, 0.01), "up": of("up", 0.2, 0.01)}}
    rows = [
        Row("collective", "packing 0.1", of("speed", 40.0, 0.3), of("speed", 41.0, 0.3)),
        Row("collective", "packing 0.3", of("speed", 20.0, 0.3), of("speed", 30.0, 0.3)),
        Row("collective", "packing 0.3", of("g_up_to_1_lengths", 1.0, 0.3), of("g_up_to_1_lengths", 1.1, 0.3)),
    ]
    still, slowing, noisy = (of("gained", *numbers, 7.0) for numbers in ((0.01, 0.01), (-0.3, 0.05), (-0.1, 0.3)))
    gained = {"packing 0.1": (still, still), "packing 0.3": (noisy, slowing)}
    lines = report.make_report(Checked(rows, 0.3, 0.1, rubbed, gained, []), tmp_path, []).lines
    assert "packing 0.1: cards hold; plane over space: speed 1.025 ± 0.011" in lines
    assert any(line.startswith("packing 0.3: cards off in speed; undecided in g up to 1 lengths; ") for line in lines)
    assert any(line.startswith("friction of 0.3 gives 0.1 ") and "and 0.2 up or down" in line for line in lines)
    first, second = (line for line in lines if "the first half" in line)
    assert first.count("(stationary to 10 %)") == 2
    assert "-10 ± 30 % in space (undecided whether stationary), by -30 ± 5 % in the plane (not stationary)" in second


@pytest.mark.parametrize(
    ("space", "plane", "end"),
    [
        ((24.0, 0.3), (24.5, 0.3), "13.00 ± 0.60 mm/s of the difference go with it"),
        ((10.1, 0.3), (23.5, 0.3), ": it is no reason"),
        ((15.0, 9.0), (23.0, 9.0), "leave open whether it is a reason"),
    ],
)
def test_a_reason_is_what_takes_its_part_of_the_difference_with_it(tmp_path, space, plane, end):
    case = f"packing {reasons.DENSEST:g}"
    rows = [Row("collective", case, of("speed", 10.0, 0.3), of("speed", 23.5, 0.3))]
    changed = [
        reasons.Changed("bodies do not rub", of("speed", *space), of("speed", *plane)),
        reasons.Changed("the plane rubs more", None, of("speed", 20.5, 0.4)),
    ]
    rubbed = {"head on": {"along": of("along", 0.1, 0.01), "up": of("up", 0.2, 0.01)}}
    lines = report.make_report(Checked(rows, 0.3, 0.1, rubbed, {}, changed), tmp_path, []).lines
    assert any("bodies do not rub" in line and line.endswith(end) for line in lines)
    assert any("the plane rubs more: the plane has 20.50 ± 0.40 mm/s, -3.00 ± 0.50 more" in line for line in lines)


def test_cards_give_numbers_where_the_checks_held_them_against_space():
    assert in_plane.MAX_TESTED_PACKING in setting.PACKINGS
    assert in_plane.MAX_TESTED_PACKING < reasons.DENSEST


def test_the_plane_has_the_friction_that_pairs_in_space_measured():
    rubbed = {name: {"along": of("along", share, 0.01)} for name, share in (("head on", 0.1), ("glancing", 0.3))}
    assert checks.set_friction(silent(), rubbed).friction == pytest.approx(0.2)


def test_crowds_that_slow_down_are_told_from_those_that_go_on():
    """Bodies side by side, 8 mm apart, which halve their speed: their g and what they lose."""
    times = np.arange(21) / 10.0
    way = 20.0 * np.minimum(times, 1.0) + 10.0 * np.maximum(times - 1.0, 0.0)
    size = setting.QUICK._replace(crowd_discard_seconds=0.0)
    films = []
    for shift in (0.0, 0.1):
        poses = np.zeros((21, 12, 3))
        poses[:, :, 0], poses[:, :, 1] = way[:, None] * (1.0 + shift), 8.2 * np.arange(12)
        films.append(crowds.make_film(size, silent(), crowds.Run(times, poses)))
    crowd = crowds.measure_films(films, 28.0)
    assert crowd.gained.value == pytest.approx(-0.5)
    assert crowd.numbers["polar_order"].value == 1.0
    assert crowd.numbers["g_up_to_0.5_lengths"].value > 1.0


def test_without_lammps_nothing_is_simulated(monkeypatch):
    def absent():
        raise InputError("needs LAMMPS")

    monkeypatch.setattr(lammps_engine, "find_lammps", absent)
    result = CliRunner().invoke(commands, ["crowd-checks"])
    assert "needs LAMMPS" in str(result.exception)


@with_lammps
@pytest.mark.slow
def test_without_noise_walkers_alone_have_their_cards_speed_and_turning():
    one = silent(turning_rad_s=0.5, velocity_relaxation_s=0.05)
    found = checks.simulate_alone_in_plane(setting.QUICK._replace(alone_seconds=2.0), one)["alone"]
    assert found["speed"].value == pytest.approx(56.0, rel=1e-3)
    assert found["turning"].value == pytest.approx(0.5, rel=1e-3)


@with_lammps
@pytest.mark.nightly
def test_the_command_makes_the_table_and_the_same_again(tmp_path, monkeypatch):
    tiny = setting.Size(16, 2.0, 2, 1, 2, 0.5, 0.2, 2, 1)
    written = []
    for folder in ("a", "b"):
        report = make.compare_crowds(tiny, "test", tmp_path / folder, lambda *_: None)
        written.append((tmp_path / folder / "crowd_checks.csv").read_bytes())
    assert written[0] == written[1]
    rows = list(csv.DictReader(written[0].decode().splitlines()))
    assert {row["check"] for row in rows} == {"single", "binary", "collective"}
    assert all(math.isfinite(float(row["space"])) for row in rows)
    assert "verdict" in report.markdown()


def test_what_ends_the_checks_loses_no_finished_part(tmp_path):
    first = Parts(tmp_path / "checks", setting.QUICK)
    assert first.load_or_make("crowd, packing 0.3", lambda: Quantity("speed", "mm_s", 1.0, 0.1)) == Quantity(
        "speed", "mm_s", 1.0, 0.1
    )
    again = Parts(tmp_path / "checks", setting.QUICK)
    assert again.load_or_make("crowd, packing 0.3", lambda: 1 / 0) == Quantity("speed", "mm_s", 1.0, 0.1)
    assert Parts(tmp_path / "checks", setting.FULL).load_or_make("crowd, packing 0.3", lambda: 2) == 2
    again.remove()
    assert first.load_or_make("crowd, packing 0.3", lambda: 3) == 3
