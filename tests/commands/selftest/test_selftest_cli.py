"""`walkergen selftest` as a user meets it: what holds, what fails, what raises, what is stopped."""

import json
import math

import numpy as np
import pytest
from typer.testing import CliRunner

from walkergen.cli import command_line
from walkergen.commands.selftest import catalogue, report
from walkergen.commands.selftest import make as selftest
from walkergen.commands.selftest.case import Case, Check

LAW = "impact law"


def call(*words):
    return CliRunner().invoke(command_line, ["selftest", *words], catch_exceptions=True)


@pytest.fixture(autouse=True)
def _wide_terminal(monkeypatch):
    """Room for a case's name on one line of the table."""
    monkeypatch.setenv("COLUMNS", "200")


def only(monkeypatch, check):
    monkeypatch.setattr(catalogue, "CASES", (Case("made up", "6.0", "nowhere", LAW, check),))


@pytest.mark.slow
def test_a_section_runs_its_cases_in_processes_of_their_own():
    result = call("--only", "6.3")
    assert result.exit_code == 0, result.output
    first, subject, _ = result.stdout.strip().splitlines()
    assert first.startswith("4 cases pass on this machine (")
    assert subject.startswith("impact law: 4 cases pass, closest to its limit: ")


def test_json_holds_every_check_with_its_reason():
    result = call("--only", "jamming: one impact", "--json")
    found = json.loads(result.stdout)
    assert (found["held"], found["failed"]) == (1, 0)
    (row,) = found["rows"]
    assert (row["section"], row["on"]) == ("6.2", "impact law")
    assert row["source"].startswith("Painleve")
    assert all(check["holds"] and check["reason"] for check in row["checks"])


def test_a_pass_fits_a_screen_and_all_prints_each_case(monkeypatch):
    checks = [Check("a long name of a check that a user reads", 0.5, 1.0, "because"), Check("b", 0.0, 1.0, "exact")]
    cases = [
        Case(f"{on}: case {n} of many", "6.0", "nowhere", on, lambda: iter(checks))
        for on in report.DISTRUSTED
        for n in range(20)
    ]
    monkeypatch.setattr(catalogue, "CASES", tuple(cases))
    monkeypatch.setattr(selftest.measure, "core_count", lambda: 1)
    monkeypatch.setenv("COLUMNS", "80")
    lines = call().stdout.strip().splitlines()
    assert lines[0] == "60 cases pass on this machine (120 checks)"
    assert len(lines) <= 25
    whole = call("--all").stdout
    assert whole.count(" of many ") >= 60
    assert max(map(len, whole.splitlines())) <= 80


def test_every_subject_says_what_its_failure_means():
    assert {case.on for case in catalogue.CASES} == set(report.DISTRUSTED)


def test_quiet_prints_nothing():
    result = call("--only", "jamming: one impact", "--quiet")
    assert (result.exit_code, result.output) == (0, "")


@pytest.mark.parametrize("value", [2.0, math.nan, math.inf])
def test_a_check_beyond_its_limit_fails_the_command(monkeypatch, value):
    only(monkeypatch, lambda: iter([Check("a thing", value, 1.0, "because")]))
    result = call()
    assert result.exit_code == 1
    first, failed, check, distrusted, send = result.stdout.strip().splitlines()
    assert first == "1 of 1 case FAILED on this machine (1 check)"
    assert failed == "FAILED 6.0, made up (source of the right value: nowhere)"
    assert check.strip() == f"a thing: {value:.3g}, limit 1 (because)"
    assert distrusted.startswith("do not trust: speeds from the theory")
    assert "selftest --json" in send
    assert json.loads(call("--json").stdout)["failed"] == 1


def test_json_takes_numbers_of_numpy(monkeypatch):
    check = Check("a thing", np.float32(0.5), np.int64(1), "because")
    only(monkeypatch, lambda: iter([check]))
    (row,) = json.loads(call("--json").stdout)["rows"]
    (told,) = row["checks"]
    assert (told["value"], told["limit"], told["holds"], row["holds"]) == (0.5, 1.0, True, True)


def test_a_case_that_raises_is_a_failed_case_with_its_message(monkeypatch):
    def raises():
        yield Check("first", 0.0, 1.0, "because")
        raise ValueError("no such\nluck")

    only(monkeypatch, raises)
    result = call()
    assert result.exit_code == 1
    assert "ValueError: no such luck" in result.stdout


def test_a_case_that_checks_nothing_fails(monkeypatch):
    only(monkeypatch, lambda: iter([]))
    result = call()
    assert result.exit_code == 1
    assert "it checked nothing" in result.stdout
    assert "1 of 1 case FAILED" in result.stdout


def test_ctrl_c_shows_what_is_done(monkeypatch):
    def interrupted():
        yield Check("first", 0.0, 1.0, "because")
        raise KeyboardInterrupt

    cases = (*catalogue.CASES[:1], Case("made up", "6.0", "nowhere", LAW, interrupted))
    monkeypatch.setattr(catalogue, "CASES", cases)
    monkeypatch.setattr(selftest.measure, "core_count", lambda: 1)
    result = call()
    assert result.exit_code == 130
    assert result.stdout.startswith("1 case passes on this machine (")
    assert catalogue.CASES[0].name in result.stdout
    assert "interrupted after 1 of 2" in result.stderr


def test_a_section_holds_those_below_it_and_no_others():
    sections = [case.section for case in selftest.select_cases(None)]
    assert {case.section for case in selftest.select_cases("6.1")} == {"6.1"}
    assert len(selftest.select_cases("6")) == sum(section.startswith("6.") for section in sections)
