"""The paper's facts have their source, and one rule compares numbers with them."""

import math

import pytest

from evidence.published import FACTS, Fact
from walkergen.core.numerics.quantity import Quantity, Verdict, exact

VALUE = Fact("a", 2, "around ten", "text", "tilt", "deg", 10.0, 8.0, 12.0, "ours")
ABOVE = Fact("b", 3, "more than 95%", "text", "share", "%", 95.0, 95.0, math.inf, "stated")
BELOW = Fact("c", 2, "always below 10", "text", "tilt", "deg", 10.0, -math.inf, 10.0, "stated")


@pytest.mark.parametrize(
    ("fact", "ours", "se", "verdict", "off"),
    [
        (VALUE, 11.0, 0.2, Verdict.AGREE, 1.0),
        (VALUE, 11.8, 0.2, Verdict.UNDECIDED, 1.8),
        (VALUE, 12.5, 0.1, Verdict.DISAGREE, 2.5),
        (VALUE, 10.0, 50.0, Verdict.UNDECIDED, 0.0),  # noise is no agreement
        (VALUE, 10.5, None, Verdict.UNDECIDED, 0.5),
        (VALUE, None, None, Verdict.MISSING, None),
        (ABOVE, 99.0, 1.0, Verdict.AGREE, 0.0),
        (ABOVE, 94.0, 1.0, Verdict.UNDECIDED, 1.0),
        (BELOW, -40.0, 0.1, Verdict.AGREE, 0.0),
        (BELOW, 11.0, 0.1, Verdict.DISAGREE, 1.0),
    ],
)
def test_verdicts_follow_from_the_numbers_alone(fact, ours, se, verdict, off):
    quantity = Quantity("ours", "", ours, se)
    assert fact.verdict(quantity) is verdict
    assert fact.distance(quantity) == (None if off is None else pytest.approx(off))


@pytest.mark.parametrize("fact", FACTS.values(), ids=FACTS)
def test_facts_carry_their_source_and_agree_with_themselves(fact):
    assert len(fact.quote) > 20
    assert "figure" in fact.where or "equation" in fact.where
    assert fact.margin.startswith(("stated", "our reading"))
    assert fact.low <= fact.value <= fact.high
    assert fact.verdict(exact(fact.key, fact.unit, fact.value)) is Verdict.AGREE
    assert fact.figure in (2, 3, 5, 6)


def test_claims_read_as_stated():
    claims = {"peak speed": "60 ± 5 mm/s", "types II and III": "> 95 %", "maximum below": "< 10 deg"}
    claims["crossover at 35"] = "1 (0.32 to 3.2) s"
    assert {key: FACTS[key].claim for key in claims} == claims
