"""`python -m evidence crowds-published`: numbers of known crowds, signs and their verdicts, sources, the folder."""

import csv
import json
import math

import numpy as np
import pytest

from evidence.crowds_published import cases, compared, make, numbers, report
from evidence.crowds_published.published import FINDINGS
from walkergen.core.dish import parse_dish
from walkergen.core.numerics.quantity import Quantity, Verdict
from walkergen.core.walker import solids
from walkergen.guests.crowd.statistics.film import NO_OUTLINES, from_positions
from walkergen.readers.walkers import top_outline

SIZE = cases.Size(3, 0.5, 0.2, 1)


def crowd(place, heading, dish="disc:200", interval=0.02):
    """Film of walkers at places x + iy (mm), shape (times, walkers)."""
    poses = np.zeros((*place.shape, 6))
    poses[..., 0], poses[..., 1], poses[..., 2] = place.real, place.imag, heading
    times = np.arange(len(place)) * interval
    return from_positions(times, poses, ("walker",) * place.shape[1], NO_OUTLINES, parse_dish(dish))


def turning(count=5, rate=0.3, radius=40.0, own=0.0):
    """Walkers on a circle about the middle, headed along it."""
    times = 0.02 * np.arange(100)
    angle = rate * times[:, None] + 2.0 * math.pi * np.arange(count) / count + own
    return crowd(radius * np.exp(1j * angle), angle + math.copysign(0.5 * math.pi, rate))


def straggling(seed, count=6, times=400):
    """Walkers that step at random, headed at random."""
    rng = np.random.default_rng(seed)
    steps = rng.normal(size=(times, count, 2)) @ [1.0, 1j]
    return crowd(np.cumsum(steps, axis=0), rng.uniform(-math.pi, math.pi, (times, count)))


def test_walkers_that_run_as_one_are_in_order_and_agree():
    times = 0.02 * np.arange(50)
    place = 60.0 * times[:, None] * np.exp(0.4j) + np.array([0.0, 10.0, 10j])
    run = crowd(place, np.full(place.shape, 0.4))
    assert numbers.polar_order(run) == pytest.approx(1.0)
    assert numbers.velocity_agreement(run, 20.0) == pytest.approx(1.0)
    assert numbers.mean_speed(run) == pytest.approx(60.0)


@pytest.mark.parametrize("rate", [0.3, -0.3])
def test_walkers_round_the_middle_circulate_and_are_in_no_order(rate):
    run = turning(rate=rate)
    assert numbers.circulation(run) == pytest.approx(1.0, abs=1e-3)
    assert numbers.polar_order(run) == pytest.approx(-0.25)  # five headings that add up to nothing
    assert numbers.mean_speed(run) == pytest.approx(0.3 * 40.0, rel=1e-3)


def test_chance_is_no_order_no_circulation_and_no_agreement():
    found = [straggling(seed) for seed in range(12)]
    for number in (numbers.polar_order, lambda run: numbers.velocity_agreement(run, 1e9)):
        values = np.array([number(run) for run in found])
        assert abs(values.mean()) < 4.0 * values.std(ddof=1) / math.sqrt(len(values))
    squares = np.array([math.copysign(value**2, value) for value in map(numbers.circulation, found)])
    assert abs(squares.mean()) < 4.0 * squares.std(ddof=1) / math.sqrt(len(squares))


def test_neighbours_across_the_edge_of_a_periodic_square_count():
    times = 0.02 * np.arange(20)
    place = 10.0 * times[:, None] + np.array([-49.0, 49.0])
    heading = np.zeros(place.shape)
    assert math.isnan(numbers.velocity_agreement(crowd(place, heading), 5.0))
    across = crowd(place, heading, "periodic:100")
    assert numbers.velocity_agreement(across, 5.0) == pytest.approx(1.0)


def test_a_number_of_a_source_is_in_its_quoted_words():
    for finding in FINDINGS:
        assert finding.source.read
        assert finding.source.address.startswith("https://")
        for value in finding.values:
            said = finding.quote.replace("0.36 cm", "3.6 cm").replace("0.25 cm", "2.5 cm")
            assert f"{value:g}" in said, f"{finding.key}: {value:g} is not in the words quoted"


def rising_numbers(slope=1.0, se=0.01):
    """Numbers of every case that change along each series by a slope."""
    whole = {}
    for place, case in enumerate([*cases.single_cases(SIZE), *cases.crowd_cases(SIZE)]):
        named = dict.fromkeys(("order", "agreement", "clustered", "at wall", "circulation"), (slope * place, se))
        named |= {"forward": (60.0, 1.0), "between prints": (2.0, 0.3)}
        named |= {"speed": (10.0 + place, 0.1), "spin": (0.1 * place, 0.01)}
        whole[case.series, case.setting] = {key: Quantity(key, "", *value) for key, value in named.items()}
    return whole


@pytest.mark.parametrize(
    ("change", "rises", "verdict"),
    [
        ((0.4, 0.1), True, Verdict.AGREE),
        ((0.4, 0.1), False, Verdict.DISAGREE),
        ((-0.4, 0.1), False, Verdict.AGREE),
        ((0.1, 0.1), True, Verdict.UNDECIDED),
        ((0.0, 0.0), True, Verdict.DISAGREE),
    ],
)
def test_a_sign_is_that_of_all_the_bounds(change, rises, verdict):
    assert compared.judge_sign(Quantity("change", "", *change), rises) == verdict


def test_every_statement_has_its_row_and_noise_decides_nothing():
    rows = list(compared.compare_findings(rising_numbers()))
    assert {row.finding for row in rows} == set(FINDINGS)
    assert all(row.note for row in rows)
    noisy = {
        row.verdict for row in compared.compare_findings(rising_numbers(se=1e3)) if row.finding.key == "polar discs"
    }
    assert noisy == {Verdict.UNDECIDED}


def test_series_are_ordered_by_numbers_of_single_walkers():
    whole = rising_numbers()
    points = compared.series_points(whole, "lean", "circulation")
    assert [at for at, _ in points] == sorted(whole["lean alone", lean]["spin"].value for lean in cases.RIGHT_TILTS_DEG)
    assert compared.series_points(whole, "lean", "speed over alone")[0][1].se > 0.0
    assert [at for at, _ in compared.series_points(whole, "packing", "order")] == list(cases.PACKINGS)


def test_page_and_table_name_every_source_and_the_part_read(tmp_path):
    made = report.make_report(list(compared.compare_findings(rising_numbers())), tmp_path, "How")
    page = made.markdown()
    assert next(csv.DictReader(made["crowds_published"].csv().splitlines()))["source"]
    for finding in FINDINGS:
        assert finding.source.address in page
        assert finding.source.read in page
    json.dumps(made.facts, allow_nan=False)
    assert made.figures["crowds"]()


@pytest.mark.parametrize("lean", cases.RIGHT_TILTS_DEG)
def test_oblong_walkers_differ_in_the_tilt_of_their_right_legs_alone(lean):
    walking, design = cases.oblong_walker(10.0), cases.oblong_walker(lean)
    assert top_outline.area_of(tuple(top_outline.outline_of(design, solids.mass_of(design)))) == pytest.approx(
        28.0 * 16.0
    )
    tilts = [math.degrees(limb.tilt) for limb in design.limbs]
    assert tilts == pytest.approx([10.0, 10.0, lean, lean])
    heights = [limb.foot_height for limb in (*design.limbs, *walking.limbs)]
    assert heights == pytest.approx([heights[0]] * 8, abs=1e-6)


def test_tapered_walkers_narrow_toward_the_front_in_two_steps():
    design = cases.tapered_walker()
    (outline,) = top_outline.outline_of(design, solids.mass_of(design))
    behind_tip = outline[:, 0].max() - outline[:, 0]
    widths = [np.ptp(outline[behind_tip < x, 1]) for x in (14.0, 4.0, 2.0)]
    assert widths == pytest.approx([8.0, 5.5, 3.0], abs=0.05)


@pytest.mark.nightly
def test_two_crowds_give_a_folder_and_the_same_bytes_again(tmp_path, monkeypatch):
    two = cases.crowd_cases(SIZE)[6:8]
    monkeypatch.setattr(make, "crowd_cases", lambda size: two)
    for name in ("one", "two"):
        made = make.compare_crowds(SIZE, tmp_path / name, lambda *_: None)
    assert "missing" in set(made["crowds_published"]["verdict"])
    files = {"crowds.csv", "crowds.pdf", "crowds.png", "crowds_published.csv", "crowds_published.md"}
    for name in ("crowds.csv", "crowds_published.csv", "crowds_published.md"):
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes()
    assert files <= {path.name for path in (tmp_path / "one").iterdir()}
