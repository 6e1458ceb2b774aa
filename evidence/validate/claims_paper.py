"""Claims of the paper: what it states, compared with the theory's bounds and the walker in space."""

import math
from collections.abc import Iterator, Sequence

import numpy as np

from evidence import curves
from evidence.published import FACTS
from evidence.quantities import ratio
from evidence.reproduce import maximum
from evidence.validate.claim import Claim, Effort, Outside
from evidence.validate.ensembles import exponent, measure_in_space, measure_paper_types, paper_design, rebound
from walkergen.core.numerics.quantity import Quantity, exact
from walkergen.core.scene import GRAVITY, Scene
from walkergen.core.theory import prediction
from walkergen.core.walker import solids
from walkergen.files import templates

PAPER = "Koumakis et al. 2016"

CONTACT = "contact as measured"
"""Restitution and friction as the paper measured them, the default; only the tips' radius is inferred."""

TILTS = (5.0, 8.0, 10.0, 12.0, 15.0)
GAMMAS = (1.2, 1.4, 1.6, 1.8, 2.2, 2.6)
MIN_RUNNING_GAMMA = 1.4
"""Least peak acceleration over g at which the speed is proportional to the plate's at 15 deg."""
FREQUENCIES_HZ = (60.0, 90.0, 120.0, 200.0)
MAX_CHANGES = 10.0, 8.0
"""Largest change of the speed over the plate's peak speed, %, from LIVELY on and over FREQUENCIES_HZ."""

LATE_LAG_S = 0.5
"""Lag of the late exponents, s: they are measured from it to twice it."""

INFERRED = "The effective radius of the tips was inferred from this number."
THRESHOLD = (
    "Below 1.4 g at 15 deg our walker is slower than the line through zero. The plate hardly throws it, so "
    "friction takes what a landing gave. With 10 % of noise on the plate, 1.3 g is back on the line."
)
REBOUND = (
    "Legs that slide lose the work of friction, so a whole walker's rebound depends on its tilt. The paper names "
    "no tilt, height or roll."
)
BALLISTIC = (
    "The paper's legs touch at random points along their width. Our feet have two corners, and soft tips let both "
    "touch together. More points along a foot lower the exponent to 1.5 (docs/validation.md)."
)
FROM_REST = "At 35 deg landings of that model start from rest. This is the limit of type III for slow slip."
OTHER_TYPES = (
    "Our other landings slide forward throughout (type I, at 10 deg) or backward (IV, at 35 deg). Corners on "
    "springs land slowly and one after another. The paper counted impacts of its own model, whose legs relax "
    "immediately."
)

QUANTITIES = {
    "types II and III": "types II and III among landings",
    "braced": "speed of braced walkers",
    "proportional": "distance from a line through zero, rms over mean",
    "maximum below": "tilt of the largest speed",
    "ballistic at 10": "exponent of squared displacement at 10 deg",
    "ballistic at 15": "exponent of squared displacement at 15 deg",
    "superdiffusive at 35": "exponent of squared displacement at 35 deg",
    "diffusive at 35": "exponent of squared displacement at 35 deg",
}
"""Shorter names of quantities of facts."""


def _claim_on_fact(key: str, circumstances: str, ours: Quantity, why: str = "", fitted: bool = False) -> Claim:
    """Claim on one of the paper's facts."""
    fact = FACTS[key]
    quantity = f"{QUANTITIES.get(key, fact.quantity)}: {circumstances}"
    theirs = exact(key, fact.unit, fact.value)
    below, above = fact.value - fact.low, fact.high - fact.value
    source = f"{PAPER}, {fact.where}"
    return Claim(quantity, ours._replace(unit=fact.unit), theirs, below, above, fact.margin, source, why, fitted)


def plate_speed(effort: Effort) -> Iterator[Claim]:
    """Claim on the plate's peak speed, which frequency and acceleration give."""
    speed = exact("plate", "mm_s", templates.load("plane-90hz", "scenes", Scene).drive.peak_speed)
    why = "The paper's three numbers disagree: 32 mm/s at 90 Hz is 1.85 g. We use its frequency and acceleration."
    yield _claim_on_fact("plate speed", "1.8 g at 90 Hz", speed, why)


def predicted_speed(effort: Effort) -> Iterator[Claim]:
    """Claim of the predicted speed at 10 deg, in two of the shipped scenes."""
    for name in ("lane-90hz", "plane-90hz"):
        scene = templates.load(name, "scenes", Scene)
        design = paper_design(10.0)
        row = prediction.predict(design, solids.mass_of(design), scene)
        ours = Quantity("speed", "mm_s", row.speed.value, row.speed.half_width(0.68))
        circumstances = f"predicted, with half of its 68 % bounds, {name}"
        yield _claim_on_fact("speed at 10 deg", circumstances, ours, INFERRED, fitted=True)


def theory_maximum(effort: Effort) -> Iterator[Claim]:
    """Claim of the theory on the tilt of its largest speed, over realistic contacts."""
    largest = exact("tilt", "deg", maximum.find_tilts(paper_design(10.0), "coulomb").high_deg)
    yield _claim_on_fact("maximum below", "theory, e 0.5 to 1, μ 0.05 to 0.4", largest)


def speed_in_space(effort: Effort) -> Iterator[Claim]:
    """Claim of the model in space on speed at 10 deg."""
    yield _claim_on_fact(
        "speed at 10 deg", f"in space, {CONTACT}", measure_in_space(10.0, effort).speed, INFERRED, fitted=True
    )


def rebound_in_space(effort: Effort) -> Iterator[Claim]:
    """Claim of the model in space on the bounce of a whole structure, which the paper measured with an error."""
    fact = FACTS["restitution"]
    stated = Quantity("restitution", "", fact.value, fact.high - fact.value)
    outside = Outside(f"{PAPER}, {fact.where}", why=REBOUND)
    for tilt in (0.0, 10.0, 15.0, 35.0):
        quantity = f"rebound of a walker dropped level by 1 mm at {tilt:g} deg, {CONTACT}"
        yield outside.compare(quantity, rebound(tilt, effort.runs), stated)


def speed_against_tilt(effort: Effort) -> Iterator[Claim]:
    """Claim of the model in space on the shape of the curve of speed against tilt."""
    curve = [measure_in_space(tilt, effort).speed for tilt in TILTS]
    high, middle = curve[TILTS.index(10.0)], curve[-1]
    low = measure_in_space(35.0, effort).speed
    yield _claim_on_fact("peak tilt", CONTACT, curves.top(np.array(TILTS), curve).place)
    yield _claim_on_fact("15 below 10", CONTACT, ratio(middle, high))
    yield _claim_on_fact("35 below 15", CONTACT, ratio(low, middle))


def braced_speed(effort: Effort) -> Iterator[Claim]:
    """Claim of the model in space on braced walkers."""
    for tilt in (10.0, 20.0):
        yield _claim_on_fact("braced", f"in space at {tilt:g} deg", measure_in_space(tilt, effort, kind="braced").speed)


def proportionality(effort: Effort) -> Iterator[Claim]:
    """Claim of the model in space on speed against the plate's speed, by acceleration and by frequency."""
    series = [measure_in_space(15.0, effort, gamma).speed for gamma in GAMMAS]
    for start, why in ((0, THRESHOLD), (GAMMAS.index(MIN_RUNNING_GAMMA), "")):
        circumstances = f"in space at 15 deg, from {GAMMAS[start]:g} g"
        yield _claim_on_fact(
            "proportional", circumstances, curves.distance_from_line(np.array(GAMMAS[start:]), series[start:]), why
        )
    start = GAMMAS.index(MIN_RUNNING_GAMMA)
    by_acceleration = [_ratio_to_plate_speed(speed, 90.0, gamma) for gamma, speed in zip(GAMMAS, series, strict=True)][
        start:
    ]
    frequencies = [measure_in_space(10.0, effort, frequency_hz=frequency).speed for frequency in FREQUENCIES_HZ]
    by_frequency = [
        _ratio_to_plate_speed(speed, frequency, 1.8)
        for frequency, speed in zip(FREQUENCIES_HZ, frequencies, strict=True)
    ]
    for ratios, share, circumstances in (
        (by_acceleration, MAX_CHANGES[0], f"15 deg, {GAMMAS[start]:g} to {GAMMAS[-1]:g} g"),
        (by_frequency, MAX_CHANGES[1], f"10 deg, {FREQUENCIES_HZ[0]:g} to {FREQUENCIES_HZ[-1]:g} Hz"),
    ):
        quantity = f"largest distance of speed over plate speed from its mean: in space, {circumstances}"
        reason = f"our reading of 'good linear behaviour': {share:g} %"
        theirs = exact("distance", "%", share)
        source = f"{PAPER}, {FACTS['proportional'].where}"
        yield Claim(quantity, _largest_deviation(ratios), theirs, math.inf, 0.0, reason, source)


def _ratio_to_plate_speed(speed: Quantity, frequency_hz: float, gamma: float) -> Quantity:
    """Return a speed over the plate's peak speed."""
    plate = gamma * GRAVITY / (2.0 * math.pi * frequency_hz)
    return ratio(speed, exact("plate", "mm_s", plate))


def _largest_deviation(ratios: Sequence[Quantity]) -> Quantity:
    """Return the largest distance of a ratio from the mean of all, in per cent of that mean, with its error."""
    values = np.array([ratio.value for ratio in ratios], dtype=float)
    errors = np.array([ratio.se or 0.0 for ratio in ratios])
    far = int(np.argmax(np.abs(values - values.mean())))
    share = 100.0 * abs(values[far] / values.mean() - 1.0)
    weights = np.full(len(values), -1.0 / len(values))
    weights[far] += 1.0
    error = 100.0 * float(np.sqrt(((weights * errors) ** 2).sum())) / float(values.mean())
    return Quantity("distance", "%", float(share), error, (len(values) - 1) * 3)


def landing_types(effort: Effort) -> Iterator[Claim]:
    """Claim on the types of landings, by the paper's model and in space, and on their speed."""
    fact = FACTS["impact speed"]
    yield _claim_on_fact(
        "types II and III", "the paper's model at 10 deg", measure_paper_types(10.0, effort), FROM_REST
    )
    for tilt in (10.0, 35.0):
        yield _claim_on_fact(
            "types II and III", f"in space at {tilt:g} deg", measure_in_space(tilt, effort).types, OTHER_TYPES
        )
    ours = exact("log", "", math.log10(measure_in_space(10.0, effort).landing_speed))
    quantity = f"log10 of {fact.quantity}, landings in space at 10 deg"
    yield Claim(quantity, ours, exact("log", "", 0.0), 0.5, 0.5, fact.margin, f"{PAPER}, {fact.where}")


def displacement_growth(effort: Effort) -> Iterator[Claim]:
    """Claim of the model in space on how walkers wander: local exponents of their displacement."""
    early, late = (f"in space, {lags}" for lags in ("40 to 80 ms", "0.5 to 1 s"))
    for tilt in (10.0, 15.0):
        yield _claim_on_fact(f"ballistic at {tilt:g}", late, exponent(tilt, effort, LATE_LAG_S))
    yield _claim_on_fact("superdiffusive at 35", early, exponent(35.0, effort, 0.04))
    yield _claim_on_fact("diffusive at 35", late, exponent(35.0, effort, LATE_LAG_S), BALLISTIC)


TESTS = (
    plate_speed,
    predicted_speed,
    theory_maximum,
    speed_in_space,
    rebound_in_space,
    speed_against_tilt,
    braced_speed,
    proportionality,
    landing_types,
    displacement_growth,
)
