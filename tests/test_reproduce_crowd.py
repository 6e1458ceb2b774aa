"""`python -m evidence crowds-published`: signs and their verdicts, every source on the page, runs as a user's."""

import csv
import json
import math

import numpy as np
import pytest
from typer.testing import CliRunner

from evidence.__main__ import commands
from evidence.crowds_published import cases as crowd_cases
from evidence.crowds_published import claims as crowd_claims
from evidence.crowds_published import make as crowd_make
from evidence.crowds_published import report as crowd_report
from evidence.crowds_published.published import FINDINGS
from walkergen.analysis.values import Value
from walkergen.errors import InputError
from walkergen.walker import seen_above, solids

SIZE = crowd_cases.Size(3, 0.5, 0.2, 1)


def found(slope=1.0, se=0.01):
    """Numbers of every case that change along each series by a slope."""
    cases = [*crowd_cases.alone(SIZE), *crowd_cases.crowds(SIZE)]
    names = ("order", "agreement", "clustered", "at wall", "circulation")
    numbers = {}
    for place, case in enumerate(cases):
        own = {name: Value(slope * place, se) for name in names}
        own |= {"forward": Value(60.0, 1.0), "between prints": Value(2.0, 0.3)}
        own |= {"speed": Value(10.0 + place, 0.1), "spin": Value(0.1 * place, 0.01)}
        numbers[case.series, case.setting] = own
    return numbers


@pytest.mark.parametrize(
    ("change", "stated", "word"),
    [
        (Value(0.4, 0.1), 1.0, "agrees"),
        (Value(0.4, 0.1), -1.0, "disagrees"),
        (Value(-0.4, 0.1), -1.0, "agrees"),
        (Value(0.2, 0.1), 1.0, "undecided"),
        (Value(0.0, 0.0), 1.0, "undecided"),
    ],
)
def test_a_sign_is_one_beyond_three_standard_errors(change, stated, word):
    assert crowd_claims.sign_of(change, stated) == word


def test_every_statement_has_its_row_and_those_of_another_sign_say_why():
    for slope in (1.0, -1.0):
        rows = crowd_claims.compared(found(slope))
        assert {row.finding.key for row in rows} == set(FINDINGS)
        for row in rows:
            assert row.word == "agrees" or row.why
    assert {row.word for row in crowd_claims.compared(found(1.0, se=1e3))} >= {"undecided"}


def test_series_stand_by_what_their_walkers_do_alone():
    numbers = found()
    points = crowd_claims.points_of(numbers, "lean", "circulation")
    assert [at for at, _ in points] == sorted(numbers["lean alone", lean]["spin"].mean for lean in crowd_cases.LEANS)
    ratio = crowd_claims.points_of(numbers, "lean", "speed over alone")[0][1]
    assert ratio.se > 0.0
    plain = crowd_claims.points_of(numbers, "packing", "order")
    assert [at for at, _ in plain] == list(crowd_cases.PACKINGS)


def test_page_and_table_name_every_source_and_what_was_read_of_it(tmp_path):
    rows = crowd_claims.compared(found())
    page = crowd_report.to_markdown(rows, "How.")
    report = crowd_report.of(rows, tmp_path, "How")
    listed = next(csv.DictReader(report.tables[0].csv().splitlines()))
    assert listed["source"]
    for finding in FINDINGS.values():
        assert finding.source.address in page
        assert finding.source.read in page
    json.dumps(report.facts, allow_nan=False)
    assert report.figures["crowds"]()


@pytest.mark.parametrize("lean", crowd_cases.LEANS)
def test_oblong_walkers_differ_in_the_tilt_of_their_right_legs_alone(lean):
    walking, design = crowd_cases.oblong(10.0), crowd_cases.oblong(lean)
    assert seen_above.area_of(tuple(seen_above.outline_of(design, solids.mass_of(design)))) == pytest.approx(
        28.0 * 16.0
    )
    tilts = [math.degrees(limb.tilt) for limb in design.limbs]
    assert tilts == pytest.approx([10.0, 10.0, lean, lean])
    heights = [limb.foot_height for limb in (*design.limbs, *walking.limbs)]
    assert heights == pytest.approx([heights[0]] * 8, abs=1e-6)


def test_tapered_walkers_narrow_toward_the_front_in_two_steps():
    design = crowd_cases.tapered()
    (outline,) = seen_above.outline_of(design, solids.mass_of(design))
    behind_tip = outline[:, 0].max() - outline[:, 0]
    widths = [np.ptp(outline[behind_tip < x, 1]) for x in (14.0, 4.0, 2.0)]
    assert widths == pytest.approx([8.0, 5.5, 3.0], abs=0.05)


@pytest.mark.parametrize(
    ("words", "named"), [(("--runs", "2"), "--runs"), (("--seconds", "0.1"), "--seconds"), (("--seed", "-1"), "seed")]
)
def test_too_little_is_refused(words, named, tmp_path):
    told = CliRunner().invoke(commands, ["crowds-published", *words, "--out", str(tmp_path / "no")])
    assert isinstance(told.exception, InputError)
    assert named in str(told.exception)
    assert not (tmp_path / "no").exists()


@pytest.mark.nightly
def test_two_crowds_give_a_folder_and_the_same_bytes_again(tmp_path, monkeypatch):
    cases = crowd_cases.crowds(SIZE)[6:8]
    monkeypatch.setattr(crowd_make, "crowds", lambda size: cases)
    for name in ("one", "two"):
        report = crowd_make.make(SIZE, tmp_path / name, lambda *_: None)
    assert "not compared" in {row.verdict for row in report.tables[0].rows}
    files = {"crowds.csv", "crowds.pdf", "crowds.png", "reproduce.csv", "reproduce.md"}
    for name in ("crowds.csv", "reproduce.csv", "reproduce.md"):
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes()
    assert files <= {path.name for path in (tmp_path / "one").iterdir()}
