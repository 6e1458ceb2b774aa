"""Comparison of the paper's facts with our numbers: each number, and the verdict on it."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from evidence.curves import Top
from evidence.published import FACTS
from evidence.reproduce import curves
from evidence.reproduce.impact_types import COUNTINGS
from evidence.reproduce.maximum import Range
from evidence.reproduce.mechanisms import Mechanism
from evidence.reproduce.motion import Runs
from evidence.reproduce.runs import PAPER_MODEL, Assumption, Point
from evidence.reproduce.theory import Curve, Theory
from walkergen.core.numerics.quantity import Quantity, Verdict, exact

FITTED = "fitted"
"""Name of the assumption whose contact is the paper's best fit."""

LOW_RESTITUTION = "low restitution"
"""Name of the assumption whose restitution is chosen, not measured."""

STATED_SPEED_TILT_DEG = 10.0
"""Tilt at which the paper states a speed, deg."""

COUNTING_ROWS = (
    *((counting, counting, "II+III", "III") for counting in COUNTINGS),
    ("landings, rest as III", "landings", "II+III+rest", "III+rest"),
)
"""Name of each way to count, its counting, and its shares for types II and III, and for III."""

RATIOS = {"15 below 10": (15.0, 10.0), "35 below 15": (35.0, 15.0)}
"""Tilts of the speeds that a fact compares, as numerator and denominator of a ratio, deg."""


class Findings(NamedTuple):
    """Theories and simulations that are compared with the paper's facts."""

    assumptions: Sequence[Assumption]
    theories: Sequence[Theory]
    peaks: Sequence[Range]
    tilts: Sequence[Point]
    """Ensembles along the tilt, of all series but that on a noisy plate."""
    restitutions: Mapping[float, Sequence[Point]] = {}
    """Ensembles along the tilt in space, with the measured friction, by restitution."""
    drives: Sequence[Point] = ()
    """Ensembles along the plate's speed, of all series of flexible legs."""
    plane: Sequence[Runs] = ()
    """Runs on a plane at the tilts of figure 6."""
    mechanisms: Sequence[Mechanism] = ()
    """The three ways to run, with the measured contact."""


class Row(NamedTuple):
    """Number compared with one fact under one assumption."""

    fact: str
    model: str
    """Model or theory that gave our number."""
    assumption: str
    ours: Quantity
    """Our number; the error of the theory is a standard deviation (restitution, friction, masses)."""

    @property
    def verdict(self) -> Verdict:
        """Verdict on the fact."""
        return FACTS[self.fact].verdict(self.ours)

    @property
    def distance(self) -> float | None:
        """Distance from what is stated."""
        return FACTS[self.fact].distance(self.ours)


def compare_facts(findings: Findings) -> list[Row]:
    """Compare every fact with each theory and simulation that has a number for it."""
    listed = [*_setting_rows(findings)]
    for theory in findings.theories:
        listed += _theory_rows(theory)
    for series in curves.group_points(findings.tilts):
        listed += _tilt_rows(series)
    for series in curves.group_points(findings.drives):
        listed.append(Row("proportional", series[0].model, series[0].assumption.name, curves.proportionality(series)))
        if series[0].model == "space":
            listed.append(_running_row(series))
    listed += [row for runs in findings.plane for row in _plane_rows(runs)]
    order = list(FACTS)
    return sorted(listed, key=lambda row: order.index(row.fact))


def _to_percent(share: Quantity) -> Quantity:
    if share.value is None:
        return share
    return share._replace(unit="percent", value=100.0 * share.value, se=100.0 * (share.se or 0.0))


def _setting_rows(findings: Findings) -> Iterator[Row]:
    """Rows of facts that need no model: the drive, and the friction that fitted best."""
    for name, scene in findings.assumptions:
        yield Row("plate speed", "sinusoidal drive", name, exact("plate", "mm_s", scene.drive.peak_speed))
        if name == FITTED:
            yield Row("friction", "the paper's best fit", name, exact("friction", "", scene.contact.friction))
    if findings.restitutions:
        restitution = curves.restitution_of_peak(findings.restitutions, FACTS["peak speed"].value)
        yield Row("restitution", "space, measured friction", findings.assumptions[0].name, restitution)


def _theory_rows(theory: Theory) -> Iterator[Row]:
    name, curve, label = theory.assumption, theory.curve, theory.label
    yield from _peak_rows(label, name, _predicted_peak(curve))
    if theory.type_three is not None:
        for fact in ("types II and III", "mostly type III"):
            yield Row(fact, "theory, stationary impacts", name, _to_percent(exact("types", "", theory.type_three)))
    low, high = curve.tilt_deg[0], curve.tilt_deg[-1]
    if low <= STATED_SPEED_TILT_DEG <= high:
        speed, sd = (float(np.interp(STATED_SPEED_TILT_DEG, curve.tilt_deg, of)) for of in (curve.speed, curve.sd))
        yield Row("speed at 10 deg", label, name, Quantity("speed", "mm_s", speed, sd))
        needed = FACTS["speed at 10 deg"].value / speed * theory.impact_speed_factor
        factor = Quantity("impact_speed", "", needed, needed * sd / speed)
        yield Row("impact speed", f"{label}: for 60 mm/s at 10 deg", name, factor)
    # Errors of restitution and masses are common to both and cancel in a ratio: no error is given.
    for fact, (over, under) in RATIOS.items():
        if low <= under and over <= high:
            ends = np.interp([over, under], curve.tilt_deg, curve.speed)
            yield Row(fact, label, name, exact("ratio", "", float(ends[0] / ends[1])))


def _peak_rows(model: str, name: str, top: Top) -> Iterator[Row]:
    for fact in ("peak tilt", "maximum below") if model.startswith("theory") else ("peak tilt",):
        yield Row(fact, model, name, top.place)
    yield Row("peak speed", model, name, top.height)


def _predicted_peak(curve: Curve) -> Top:
    """Top of a predicted curve; none at an end of the curve, beyond which it may rise on."""
    at = int(curve.speed.argmax())
    if at in (0, len(curve.speed) - 1):
        return curves.NO_TOP
    grid = float(curve.tilt_deg[1] - curve.tilt_deg[0]) / math.sqrt(12.0)
    height = Quantity("speed", "mm_s", float(curve.speed[at]), float(curve.sd[at]))
    return Top(Quantity("tilt", "deg", float(curve.tilt_deg[at]), grid), height)


def _tilt_rows(series: Sequence[Point]) -> Iterator[Row]:
    model, name = series[0].model, series[0].assumption.name
    if model == "space, braced":
        yield Row("braced", model, name, max((point.speed for point in series), key=curves.size))
        return
    yield from _peak_rows(model, name, curves.find_peak(series))
    for fact, (over, under) in RATIOS.items():
        yield Row(fact, model, name, curves.speed_ratio(series, over, under))
    yield Row("impact speed", f"{model}, landings, over tilts", name, curves.impact_speed(series))
    at = {point.tilt_deg: point.speed for point in series}
    yield Row("speed at 10 deg", model, name, at.get(STATED_SPEED_TILT_DEG, Quantity("speed", "mm_s", None)))
    for count_name, counting, both, third in COUNTING_ROWS:
        if model != PAPER_MODEL and "rest" in third:
            continue  # elastic feet never land at exactly no slip
        for fact, kind in (("types II and III", both), ("mostly type III", third)):
            yield Row(fact, f"{model}, {count_name}", name, _to_percent(curves.smallest_share(series, counting, kind)))


def _running_row(series: Sequence[Point]) -> Row:
    """Row on proportionality from the drive of figure 2 up, where a walker in space runs."""
    assumption = series[0].assumption
    drive = assumption.scene.drive
    model = f"{series[0].model}, from {drive.peak_gamma:.2g} g"
    return Row(
        "proportional", model, assumption.name, curves.proportionality(curves.running_points(series, drive.peak_speed))
    )


def _plane_rows(runs: Runs) -> Iterator[Row]:
    """Rows of figure 6's facts about a tilt."""
    tilt, growth = f"{runs.tilt_deg:g}", runs.growth
    exponents = {
        f"ballistic at {tilt}": growth.smallest,
        f"superdiffusive at {tilt}": growth.first,
        f"diffusive at {tilt}": growth.late,
        f"crossover at {tilt}": growth.crossover,
    }
    for fact, exponent in exponents.items():
        if fact in FACTS:
            yield Row(fact, "space", runs.assumption, exponent)
