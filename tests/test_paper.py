"""The paper's facts have their source, and the rule that judges our numbers is fair."""

import math

import pytest

from walkergen.jobs.trust.published import FACTS, Fact, judge

VALUE = Fact("a", 2, "around ten", "text", "tilt", "deg", 10.0, 8.0, 12.0, "ours")
ABOVE = Fact("b", 3, "more than 95%", "text", "share", "%", 95.0, 95.0, math.inf, "stated")
BELOW = Fact("c", 2, "always below 10", "text", "tilt", "deg", 10.0, -math.inf, 10.0, "stated")


@pytest.mark.parametrize(
    ("fact", "ours", "se", "told"),
    [
        (VALUE, 10.0, 0.0, "agrees"),
        (VALUE, 10.3, 0.2, "agrees"),  # 10 itself lies within two standard errors
        (VALUE, 11.0, 0.2, "agrees within 1 deg"),
        (VALUE, 8.0, 0.0, "agrees within 2 deg"),
        (VALUE, 11.8, 0.2, "undecided: off by 1.8 deg"),
        (VALUE, 12.2, 0.2, "undecided: off by 2.2 deg"),
        (VALUE, 12.5, 0.1, "differs by 2.5 deg"),
        (VALUE, -3.0, 1.0, "differs by 13 deg"),
        (VALUE, 10.0, 50.0, "undecided"),  # noise is no agreement
        (VALUE, 10.5, None, "undecided: off by 0.5 deg"),
        (VALUE, None, None, "not measured"),
        (ABOVE, 99.0, 1.0, "agrees"),
        (ABOVE, 96.0, 1.0, "undecided"),
        (ABOVE, 94.0, 1.0, "undecided: off by 1 %"),
        (ABOVE, 20.0, 1.0, "differs by 75 %"),
        (BELOW, 9.0, 0.1, "agrees"),
        (BELOW, -40.0, 0.1, "agrees"),
        (BELOW, 11.0, 0.1, "differs by 1 deg"),
    ],
)
def test_verdicts_follow_from_the_numbers_alone(fact, ours, se, told):
    assert str(judge(fact, ours, se)) == told


def test_a_margin_without_unit_leaves_no_trailing_space():
    assert str(judge(VALUE._replace(unit=""), 13.0, 0.1)) == "differs by 3"


@pytest.mark.parametrize("fact", FACTS.values(), ids=FACTS)
def test_facts_carry_their_source_and_agree_with_themselves(fact):
    assert len(fact.quote) > 20
    assert "figure" in fact.where or "equation" in fact.where
    assert fact.margin.startswith(("stated", "our reading"))
    assert fact.low <= fact.value <= fact.high
    assert str(judge(fact, fact.value, 0.0)) == "agrees"
    assert fact.figure in (2, 3, 5, 6)


def test_claims_read_as_stated():
    assert FACTS["peak speed"].claim == "60 ± 5 mm/s"
    assert FACTS["types II and III"].claim == "> 95 %"
    assert FACTS["maximum below"].claim == "< 10 deg"
    assert FACTS["impact speed"].claim == "1 (0.32 to 3.2)"
    assert FACTS["crossover at 35"].claim == "1 (0.32 to 3.2) s"
    assert FACTS["superdiffusive at 35"].claim == "> 1"
