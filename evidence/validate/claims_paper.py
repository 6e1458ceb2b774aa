"""Claims of the paper: what it states, beside the theory's bounds and the walker in space."""

import math
from collections.abc import Iterator

import numpy as np

from evidence.validate.claim import Claim, Effort, Outside
from evidence.validate.ensembles import exponent, in_space, paper_design, paper_model, rebound
from walkergen.analysis import curves
from walkergen.files import templates
from walkergen.jobs.trust.published import FACTS
from walkergen.numerics.quantity import Quantity, exact
from walkergen.scene import PAPER_CONTACT, Scene
from walkergen.theory import maximum, prediction
from walkergen.walker import solids

PAPER = "Koumakis et al. 2016"

MEASURED, LABEL = 0.8, PAPER_CONTACT.restitution
"""Restitution that the paper measured, and label of a foot with which its speeds come out."""

CONTACTS = ((MEASURED, "e = 0.8, measured"), (LABEL, f"label {LABEL:g}, inferred"))

TILTS = (5.0, 8.0, 10.0, 12.0, 15.0)
GAMMAS = (1.2, 1.4, 1.6, 1.8, 2.2, 2.6)
LIVELY = 1.8
"""Drive of figure 2, peak acceleration over g, from which walkers run."""

LATE_S = 0.5
"""Lag from which to twice it runs of some seconds tell how a walker wanders, s."""

INFERRED = "The contact was inferred from the paper's speeds."
BOUNCE = (
    "The reason is not proven. No label meets both the paper's speed and its rebound (rows below) on feet as stiff as "
    "their legs and at 1.8 g. On tips 40 to 50 times softer, or on a plate that shakes 8 to 10 % less where walkers "
    "run, one label does (docs/causes.md)."
)
THRESHOLD = (
    "In our model a walker that rebounds little sits on the plate until that falls away, and friction wipes out there "
    "what a landing gave: it runs from about 1.6 g on. A noisy plate runs it below, and so do softer tips with the "
    "measured restitution (docs/causes.md)."
)

REBOUND = (
    "What a whole walker keeps depends on its tilt more than on the label: legs that "
    "slide lose the work of friction. The paper names no tilt, height or first roll."
)
FROM_REST = "At 35 deg landings of that model start from rest, the limit of type III for slow slip."
OTHER_TYPES = (
    "Others of our landings slide forward throughout (type I, at 10 deg) or backward "
    "(IV, at 35 deg): corners on springs land slowly and one after another. The paper "
    "counted impacts of its own model, in which legs relax at once."
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


def _of_fact(key: str, circumstances: str, ours: Quantity, why: str = "", fitted: bool = False) -> Claim:
    """Claim on one of the paper's facts."""
    fact = FACTS[key]
    quantity = f"{QUANTITIES.get(key, fact.quantity)}: {circumstances}"
    theirs = exact(key, fact.unit, fact.value)
    below, above = fact.value - fact.low, fact.high - fact.value
    source = f"{PAPER}, {fact.where}"
    return Claim(quantity, ours._replace(unit=fact.unit), theirs, below, above, fact.margin, source, why, fitted)


def drive(effort: Effort) -> Iterator[Claim]:
    """Claim on the plate's peak speed, which frequency and acceleration give."""
    speed = exact("plate", "mm_s", templates.load("plane-90hz", "scenes", Scene).drive.peak_speed)
    why = "The paper's three numbers do not meet: 32 mm/s at 90 Hz are 1.85 g. We keep its frequency and acceleration."
    yield _of_fact("plate speed", "1.8 g at 90 Hz", speed, why)


def predicted(effort: Effort) -> Iterator[Claim]:
    """Claim of the predicted speed at 10 deg, in two of the shipped scenes."""
    for name in ("lane-90hz", "plane-90hz"):
        scene = templates.load(name, "scenes", Scene)
        design = paper_design(10.0)
        row = prediction.predict(design, solids.mass_of(design), scene)
        ours = Quantity(
            "speed", "mm_s", row.speed_mm_s, 0.5 * ((row.speed_high_68_mm_s or 0.0) - (row.speed_low_68_mm_s or 0.0))
        )
        circumstances = f"predicted, with half of its 68 % bounds, {name}"
        yield _of_fact("speed at 10 deg", circumstances, ours, INFERRED, fitted=True)


def theory_maximum(effort: Effort) -> Iterator[Claim]:
    """Claim of the theory on the tilt of its largest speed, over realistic contacts."""
    largest = exact("tilt", "deg", maximum.tilts(paper_design(10.0), "coulomb").high_deg)
    yield _of_fact("maximum below", "theory, e 0.5 to 1, μ 0.05 to 0.4", largest)


def speeds(effort: Effort) -> Iterator[Claim]:
    """Claim of the model in space on speed at 10 deg, by contact."""
    for restitution, contact in CONTACTS:
        ensemble, fitted = in_space(10.0, effort, restitution), restitution == LABEL
        why = INFERRED if fitted else BOUNCE
        yield _of_fact("speed at 10 deg", f"in space, {contact}", ensemble.speed, why, fitted)


def bounces(effort: Effort) -> Iterator[Claim]:
    """Claim of the model in space on the bounce of a whole structure, which the paper measured with an error."""
    fact = FACTS["restitution"]
    stated = Quantity("restitution", "", fact.value, fact.high - fact.value)
    outside = Outside(f"{PAPER}, {fact.where}", why=REBOUND)
    for label, contact in CONTACTS:
        for tilt in (10.0, 35.0):
            quantity = f"rebound of a walker dropped level by 1 mm at {tilt:g} deg, {contact}"
            yield outside.beside(quantity, rebound(tilt, label, effort.runs), stated)


def shape(effort: Effort) -> Iterator[Claim]:
    """Claim of the model in space on the shape of the curve of speed against tilt."""
    for restitution, contact in CONTACTS:
        curve = [in_space(tilt, effort, restitution).speed for tilt in TILTS]
        high, middle = curve[TILTS.index(10.0)], curve[-1]
        low = in_space(35.0, effort, restitution).speed
        yield _of_fact("peak tilt", contact, curves.top(np.array(TILTS), curve).place)
        yield _of_fact("15 below 10", contact, middle.over(high))
        yield _of_fact("35 below 15", contact, low.over(middle))


def braced(effort: Effort) -> Iterator[Claim]:
    """Claim of the model in space on braced walkers."""
    for tilt in (10.0, 20.0):
        yield _of_fact(
            "braced", f"in space at {tilt:g} deg, e = 0.8", in_space(tilt, effort, MEASURED, kind="braced").speed
        )


def proportional(effort: Effort) -> Iterator[Claim]:
    """Claim of the model in space on speed against the plate's speed at 15 deg."""
    series = [in_space(15.0, effort, LABEL, gamma).speed for gamma in GAMMAS]
    for start, why in ((0, THRESHOLD), (GAMMAS.index(LIVELY), "")):
        circumstances = f"in space, label {LABEL:g}, from {GAMMAS[start]:g} g"
        yield _of_fact("proportional", circumstances, curves.off_line(np.array(GAMMAS[start:]), series[start:]), why)


def types(effort: Effort) -> Iterator[Claim]:
    """Claim on the types of landings, by the paper's model and in space, and on their speed."""
    fact = FACTS["impact speed"]
    yield _of_fact("types II and III", "the paper's model at 10 deg", paper_model(10.0, effort).types, FROM_REST)
    for restitution, contact in CONTACTS:
        for tilt in (10.0, 35.0):
            shares = in_space(tilt, effort, restitution).types
            yield _of_fact("types II and III", f"in space at {tilt:g} deg, {contact}", shares, OTHER_TYPES)
    ours = exact("log", "", math.log10(in_space(10.0, effort, LABEL).landing_speed))
    quantity = f"log10 of {fact.quantity}, landings in space at 10 deg"
    yield Claim(quantity, ours, exact("log", "", 0.0), 0.5, 0.5, fact.margin, f"{PAPER}, {fact.where}")


def motion(effort: Effort) -> Iterator[Claim]:
    """Claim of the model in space on how walkers wander: local exponents of their displacement."""
    early, late = (f"in space, label {LABEL:g}, {lags}" for lags in ("40 to 80 ms", "0.5 to 1 s"))
    for tilt in (10.0, 15.0):
        yield _of_fact(f"ballistic at {tilt:g}", late, exponent(tilt, effort, LABEL, LATE_S))
    yield _of_fact("superdiffusive at 35", early, exponent(35.0, effort, LABEL, 0.04))
    why = "The paper has this beyond 1 s, where runs of some seconds say too little."
    yield _of_fact("diffusive at 35", late, exponent(35.0, effort, LABEL, LATE_S), why)


TESTS = (drive, predicted, theory_maximum, speeds, bounces, shape, braced, proportional, types, motion)
