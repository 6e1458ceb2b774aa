"""Comparison of the paper's facts with our numbers: each number, and the verdict on it."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.analysis.values import Top, Value
from walkergen.jobs.trust.published import FACTS, Verdict, judge
from walkergen.jobs.trust.reproduce import curves
from walkergen.jobs.trust.reproduce.mechanisms import Mechanism
from walkergen.jobs.trust.reproduce.plane import Runs
from walkergen.jobs.trust.reproduce.sweeps import COUNTINGS, Assumption, Point
from walkergen.jobs.trust.reproduce.theory import Curve
from walkergen.scene import Scene
from walkergen.theory.impact import Kind, Law, impact
from walkergen.theory.maximum import Range
from walkergen.theory.speed import Mode, factor
from walkergen.theory.tensors import feet
from walkergen.walker import solids
from walkergen.walker.design import Design

Array = npt.NDArray[np.float64]

FITTED = "fitted"
"""Name of the assumption whose contact is the paper's best fit."""

LOW = "low restitution"
"""Name of the assumption whose restitution is chosen for the experiment's speeds."""

TEN = 10.0
"""Tilt at which the paper states a speed, deg."""

COUNTED = (
    *((counting, counting, "II+III", "III") for counting in COUNTINGS),
    ("landings, rest as III", "landings", "II+III+rest", "III+rest"),
)
"""Name of each way to count, its counting, and its shares for types II and III, and for III."""

RATIOS = {"15 below 10": (15.0, 10.0), "35 below 15": (35.0, 15.0)}
"""Tilts of the speeds that a fact compares, as numerator and denominator of a ratio, deg."""


class Theory(NamedTuple):
    """Predicted curve of speed against tilt."""

    assumption: str
    mode: Mode
    curve: Curve
    impact_speed_factor: float
    """Impact speed over the plate's peak speed that the curve assumes."""
    type_three: float | None
    """Share of type III among impacts at the stationary speed, over tilts above 0 and both feet;
    None in mode paper, which assumes it."""

    @property
    def label(self) -> str:
        """Name of the curve in tables and legends."""
        return f"theory, {'eq. 15' if self.mode == 'paper' else 'feet may stick'}"


class Findings(NamedTuple):
    """Theories and simulations with which the paper's facts are compared."""

    assumptions: Sequence[Assumption]
    theories: Sequence[Theory]
    peaks: Sequence[Range]
    tilts: Sequence[Point]
    """Ensembles along the tilt, of all series but that on a noisy plate."""
    labels: Mapping[float, Sequence[Point]]
    """Ensembles along the tilt in space, with the measured friction, by restitution."""
    drives: Sequence[Point]
    """Ensembles along the plate's speed, of all series of flexible legs."""
    plane: Sequence[Runs]
    """Runs on a plane at the tilts of figure 6."""
    mechanisms: Sequence[Mechanism] = ()
    """The three ways to run, with the measured contact."""


class Row(NamedTuple):
    """Verdict on one fact under one assumption."""

    fact: str
    model: str
    """Model or theory that gave our number."""
    assumption: str
    ours: float | None
    se: float | None
    """Standard error; of the theory a standard deviation (restitution, friction, masses)."""
    verdict: Verdict


def rows(findings: Findings) -> list[Row]:
    """Compare every fact with each theory and simulation that has a number for it."""
    listed = [*_stated(findings)]
    for theory in findings.theories:
        listed += _of_theory(theory)
    for series in curves.series_of(findings.tilts):
        listed += _of_tilts(series)
    for series in curves.series_of(findings.drives):
        value = curves.proportionality(series)
        listed.append(_row("proportional", series[0].model, series[0].assumption, value, 100.0))
        if series[0].model == "space":
            listed.append(_of_lively(series, findings))
    listed += [row for runs in findings.plane for row in _of_plane(runs)]
    order = list(FACTS)
    return sorted(listed, key=lambda row: order.index(row.fact))


def _row(fact: str, model: str, assumption: str, value: Value | None, scale: float = 1.0) -> Row:
    ours = None if value is None else scale * value.mean
    se = None if value is None else scale * value.se
    return Row(fact, model, assumption, ours, se, judge(FACTS[fact], ours, se))


def _stated(findings: Findings) -> Iterator[Row]:
    """Rows of facts that need no model: the drive, and the friction that fitted best."""
    for assumption in findings.assumptions:
        speed = assumption.scene.drive.peak_speed
        yield _row("plate speed", "sinusoidal drive", assumption.name, Value(speed, 0.0))
        if assumption.name == FITTED:
            friction = assumption.scene.contact.friction
            yield _row("friction", "the paper's best fit", assumption.name, Value(friction, 0.0))
    if findings.labels:
        model = "space, measured friction"
        yield _row(
            "restitution",
            model,
            findings.assumptions[0].name,
            curves.restitution_of_peak(findings.labels, FACTS["peak speed"].value),
        )


def stationary_type_three(design: Design, scene: Scene, tilts_deg: Sequence[float], mode: Mode) -> float | None:
    """Share of type III among impacts at the stationary speed (see `Theory`)."""
    if mode == "paper":
        return None
    e, mu, law = scene.contact.restitution, scene.contact.friction, Law[scene.contact.law.upper()]
    kinds = []
    for tilt in tilts_deg:
        if tilt > 0.0:
            variant = design.variant(tilt_deg=tilt)
            for H in feet(solids.mass_of(variant)):
                v_x = float(factor(H, e, mu, mode, scene.contact.law))
                hit = impact(float(H.xx), float(H.xy), float(H.yy), v_x, -1.0, e, mu, law)
                kinds.append(hit.kind)
    return kinds.count(Kind.III) / len(kinds)


def _of_theory(theory: Theory) -> Iterator[Row]:
    name, curve = theory.assumption, theory.curve
    top = _predicted_peak(curve)
    for fact in ("peak tilt", "maximum below"):
        yield _row(fact, theory.label, name, None if top is None else top.place)
    yield _row("peak speed", theory.label, name, None if top is None else top.height)
    if theory.type_three is not None:
        for fact in ("types II and III", "mostly type III"):
            share = Value(theory.type_three, 0.0)
            yield _row(fact, "theory, stationary impacts", name, share, 100.0)
    if curve.tilt_deg[0] <= TEN <= curve.tilt_deg[-1]:
        at = [float(np.interp(TEN, curve.tilt_deg, of)) for of in (curve.speed, curve.sd)]
        yield _row("speed at 10 deg", theory.label, name, Value(*at))
        needed = FACTS["speed at 10 deg"].value / at[0] * theory.impact_speed_factor
        factor_needed = Value(needed, needed * at[1] / at[0])
        yield _row("impact speed", f"{theory.label}: for 60 mm/s at 10 deg", name, factor_needed)
    # Errors of restitution and masses are common to both and cancel in a ratio: no error is given.
    for fact, (over, under) in RATIOS.items():
        if curve.tilt_deg[0] <= under and over <= curve.tilt_deg[-1]:
            ratio = np.interp([over, under], curve.tilt_deg, curve.speed)
            yield _row(fact, theory.label, name, Value(float(ratio[0] / ratio[1]), 0.0))


def _predicted_peak(curve: Curve) -> Top | None:
    """Top of a predicted curve; None at an end of the curve, beyond which it may rise on."""
    at = int(curve.speed.argmax())
    if at in (0, len(curve.speed) - 1):
        return None
    grid = float(curve.tilt_deg[1] - curve.tilt_deg[0]) / math.sqrt(12.0)
    speed = Value(float(curve.speed[at]), float(curve.sd[at]))
    return Top(Value(float(curve.tilt_deg[at]), grid), speed)


def _of_tilts(series: Sequence[Point]) -> Iterator[Row]:
    model, name = series[0].model, series[0].assumption
    if model in ("rigid", "space, braced"):
        yield _row("braced", model, name, curves.largest(series))
        return
    top = curves.peak(series)
    yield _row("peak tilt", model, name, None if top is None else top.place)
    yield _row("peak speed", model, name, None if top is None else top.height)
    for fact, (over, under) in RATIOS.items():
        yield _row(fact, model, name, curves.ratio(series, over, under))
    yield _row("impact speed", f"{model}, landings, over tilts", name, curves.impact_speed(series))
    speed = {point.tilt_deg: point.speed for point in series}.get(TEN)
    yield _row("speed at 10 deg", model, name, speed)
    for count_name, counting, both, third in COUNTED:
        if model == "space" and "rest" in third:
            continue  # elastic feet never land at exactly no slip
        for fact, kind in (("types II and III", both), ("mostly type III", third)):
            share = curves.smallest(series, counting, kind)
            yield _row(fact, f"{model}, {count_name}", name, share, 100.0)


def _of_lively(series: Sequence[Point], findings: Findings) -> Row:
    """Row on proportionality from the drive of figure 2 up, where a walker in space runs."""
    name = series[0].assumption
    (drive,) = (assumption.scene.drive for assumption in findings.assumptions if assumption.name == name)
    lively = curves.lively(series, drive.peak_speed)
    model = f"{series[0].model}, from {drive.peak_gamma:.2g} g"
    return _row("proportional", model, name, curves.proportionality(lively), 100.0)


def _of_plane(runs: Runs) -> Iterator[Row]:
    """Rows of figure 6's facts about a tilt."""
    tilt, growth = f"{runs.tilt_deg:g}", runs.growth
    values = {
        f"ballistic at {tilt}": growth.smallest,
        f"superdiffusive at {tilt}": growth.first,
        f"diffusive at {tilt}": growth.late,
        f"crossover at {tilt}": growth.crossover,
    }
    for fact, value in values.items():
        if fact in FACTS:
            yield _row(fact, "space", runs.assumption, value)
