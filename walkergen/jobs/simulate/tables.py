"""Tables of simulated walkers: what the model is, how they move, how they land."""

import functools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from walkergen.analysis.estimates import IN_A_LANE, with_error
from walkergen.analysis.landings import CORNERS, TOGETHER_S, Landings
from walkergen.analysis.motion import Motion
from walkergen.files import words
from walkergen.jobs.simulate.make import Simulated
from walkergen.jobs.simulate.orbit import Orbit
from walkergen.scene import Scene
from walkergen.simulation import observables, resolution
from walkergen.simulation.observables import POWER_ROWS

MOVED = {
    "lane_speed": ("along x", "mm/s"),
    "sideways_speed": ("sideways drift", "mm/s to the left"),
    "turning_bias": ("turning", "rad/s to the left"),
    "turning_scatter": ("turning scatter", "rad/s between runs"),
    "rotational_diffusion": ("rotational D_r", "rad²/s"),
    "persistence_time": ("persistence", "s"),
    "persistence_length": ("", "mm"),
    "diffusivity": ("diffusivity", "mm²/s"),
    "crossover_time": ("crossover", "s, ballistic to diffusive"),
}
"""Names and units of the estimates that a summary shows."""

RARE = 1e-3
"""Share of a type below which a summary leaves it out; JSON has it."""

MOST_LISTED = 6
"""Number of legs up to which a summary lists the landings of each; JSON has all."""


def plate_in_words(scene: Scene) -> str:
    """Frequency, peak acceleration and peak speed of the plate."""
    drive = scene.drive
    return f"{drive.frequency:g} Hz, {drive.peak_gamma:g} g, {drive.peak_speed:.1f} mm/s"


def model_in_words(found: Simulated, scene: Scene) -> str:
    """Model of a simulation, and what it assumes of the contact."""
    contact, model = scene.contact, found.point.model
    law = "elastic feet" if model == "space" else f"law of impact {contact.law}"
    return f"{model}, {law}, restitution {contact.restitution:g}, friction {contact.friction:g}"


def model_as_dict(found: Simulated, scene: Scene) -> dict[str, Any]:
    """Model, method and contact law of a simulation for JSON."""
    named = {"model": found.point.model, "method": found.point.method}
    contact = scene.contact
    if found.point.model != "space":
        return named | {"law": contact.law}
    label = {"label": contact.restitution, "friction": contact.friction}
    return named | {"feet": scene.feet.damping} | label


def motion_rows(found: Simulated) -> Iterator[tuple[str, str]]:
    """Rows of a summary on how walkers in space move, each number with its error or a reason."""
    if found.untold:
        yield "motion", f"unknown: {found.untold}"
    if found.motion is None:
        return
    before = ""
    in_lane = found.motion.estimates["sideways_speed"].reason == IN_A_LANE
    for name, (title, unit) in MOVED.items():
        one = found.motion.estimates[name]
        if in_lane and name == "lane_speed":
            continue  # the summary's mean speed
        if one.reason != IN_A_LANE and (one.value is not None or one.reason != before):
            value = with_error(one)
            told = f"{value} {unit}"
            if name == "rotational_diffusion" and one.value:
                told += f" (1/D_r = {words.number(1.0 / one.value)} s)"
            yield title, value if one.value is None else told
        before = one.reason
    yield "msd exponent", _exponents(found.motion)
    for note in (found.motion.method, *found.motion.doubts):
        yield "note", note


def _exponents(motion: Motion) -> str:
    """Local exponents of the squared displacement at the known lags nearest to 0.1 s and 1 s."""
    known = [
        (at, value, se)
        for at, value, se in zip(*motion.exponent, strict=True)
        if value == value and se == se  # not NaN
    ]
    if not known:
        return "runs are too short"
    nearest = [min(known, key=lambda one: abs(one[0] / lag - 1.0)) for lag in (0.1, 1.0)]
    return ", ".join(
        f"{words.with_error(value, se)} at {words.number(at, 2)} s"
        for at, value, se in dict.fromkeys(nearest)
    )


def speed_by_step(found: Simulated) -> str:
    """Addition to the mean speed and its statistical error: what the step may do to it."""
    verdict = found.verdicts[observables.SPEED]
    if verdict.error is None:
        return f" {_marks(found)[verdict.reason]}"
    return f" ± {words.number(verdict.error, 2)} by the step (95 %)" if verdict.error else ""


def bound_rows(simulated: Simulated) -> Iterator[tuple[str, str]]:
    """Row of a summary with the bounds of the mean speed; of prints where runs share an orbit."""
    if simulated.orbit is not None:
        yield "prints", over_prints(simulated.orbit)
        return
    found = simulated.point.summary
    low, high = found.speed_low_95_mm_s, found.speed_high_95_mm_s
    if low is not None and high is not None:
        yield (
            "95 % bounds",
            (
                f"{low:.1f} to {high:.1f} mm/s, by runs and step; --uncertain adds what design and "
                "scene do not know"
            ),
        )


def over_prints(orbit: Orbit) -> str:
    """Statement of how speeds differ from print to print, where runs share an orbit."""
    if orbit.bounds_mm_s is None:
        return f"unknown how they differ: {orbit.reason}"
    low2, low1, high1, high2 = orbit.bounds_mm_s
    return (
        f"{low1:.1f} to {high1:.1f} mm/s (68 %), {low2:.1f} to {high2:.1f} (95 %), by "
        f"{orbit.draws} draws of what design and scene do not know; --uncertain tells which does it"
    )


def statistic_rows(found: Simulated) -> Iterator[tuple[str, str]]:
    """Rows of a summary on impacts, contact and powers; ± is of the runs and the step together."""
    told = functools.partial(_told, found)
    yield "impacts", told(observables.IMPACTS, unit=" per second")
    yield "by impulse", _shares(found, observables.BY_IMPULSE)
    yield "by number", _shares(found, observables.BY_NUMBER)
    if found.landings:
        yield from _landing_rows(found)
    yield "in contact", told(observables.CONTACT, 100.0, " % of the time")
    powers = (f"{name} {told(f'{observables.POWERS}.{name}', 1e-6)}" for name in POWER_ROWS)
    unaccounted = 100 * found.point.summary.energy_error
    yield "power, uW", f"{', '.join(powers)}; unaccounted {words.number(unaccounted, 2)} %"
    for reason, mark in _marks(found).items():
        yield "note" if reason == resolution.TURNING else mark, reason


def _told(found: Simulated, name: str, scale: float = 1.0, unit: str = "") -> str:
    """An observable with its error, or with the mark of the reason why it has none."""
    verdict, value = found.verdicts[name], scale * found.values[name]
    if verdict.error is None:
        return f"{words.number(value, 4)}{unit} {_marks(found)[verdict.reason]}"
    if found.orbit is not None:
        return f"{words.number(value, 4)}{unit}"
    error = found.errors[name]
    both = (
        f"{words.number(value, 4)} ± ?" if error is None else words.with_error(value, scale * error)
    )
    return f"{both}{unit}"


def _marks(found: Simulated) -> dict[str, str]:
    """Marks (a), (b) ... of the reasons why observables are not resolved."""
    reasons = dict.fromkeys(one.reason for one in found.verdicts.values() if one.reason)
    return {reason: f"({letter})" for reason, letter in zip(reasons, "abc", strict=False)}


def _shares(found: Simulated, table: str) -> str:
    """Shares of the types that are not rare, in percent; a reason common to all comes once."""
    own = (name for name in found.values if name.startswith(f"{table}."))
    names = [name for name in own if found.values[name] >= RARE]
    short = [name.partition(".")[2] for name in names]
    reason = found.verdicts[f"{table}.I"].reason
    if reason:
        shares = (f"{100 * found.values[name]:.1f} %" for name in names)
        rows = ", ".join(f"{one} {share}" for one, share in zip(short, shares, strict=True))
        return f"{rows} {_marks(found)[reason]}" if rows else "none"
    told = (
        f"{one} {_told(found, name, 100.0, ' %')}" for one, name in zip(short, names, strict=True)
    )
    return ", ".join(told) or "none"


def counted(legs: Sequence[str]) -> dict[str, tuple[bool, Callable[[Landings], int]]]:
    """Numbers of landings, and of groups of them, by name; True for those of single corners."""
    found: dict[str, tuple[bool, Callable[[Landings], int]]] = {}
    for foot, leg in enumerate(_keys(legs)):
        for side, name in enumerate(("left", "right")):
            number = CORNERS * foot + side
            found[f"{leg}_{name}"] = True, functools.partial(_corner, number)
    for foot, leg in enumerate(_keys(legs)):
        found[f"{leg}_edge"] = False, functools.partial(_edge, foot)
    found[_together(legs)] = False, lambda one: one.pairs
    found["alone"] = False, lambda one: one.alone
    return found


def _corner(number: int, one: Landings) -> int:
    return int(one.corners[number])


def _edge(foot: int, one: Landings) -> int:
    return int(one.edges[foot])


def _keys(legs: Sequence[str]) -> list[str]:
    """Names of legs as keys."""
    return [leg.replace(" ", "_") for leg in legs]


def _together(legs: Sequence[str]) -> str:
    """Name of groups in which more than one foot landed."""
    return "both_feet" if len(legs) == 2 else "several_feet"


def _landing_rows(found: Simulated) -> Iterator[tuple[str, str]]:
    """Rows of a summary on landings: numbers by corner, edge and foot."""
    rates, legs = _rates(found), found.legs
    per = {
        name: words.fixed(value, 1) if error is None else words.with_error(value, error)
        for name, (value, error) in rates.items()
    }
    if len(legs) <= MOST_LISTED:
        shown = zip(legs, _keys(legs), strict=True)
        yield (
            "by corner, /s",
            "; ".join(f"{leg} {per[f'{key}_left']} left, {per[f'{key}_right']} right"
                      for leg, key in shown),
        )  # fmt: skip
        edges = ", ".join(
            f"{per[f'{key}_edge']} {leg}" for leg, key in zip(legs, _keys(legs), strict=True)
        )
    else:
        sums = {leg: rates[f"{key}_left"][0] + rates[f"{key}_right"][0]
                for leg, key in zip(legs, _keys(legs), strict=True)}  # fmt: skip
        low, high = (pick(sums, key=sums.__getitem__) for pick in (min, max))
        told = f"{sums[low]:.1f} ({low}) to {sums[high]:.1f} ({high}); --json lists all"
        yield "by foot, /s", f"{len(legs)} feet: {told}"
        edges = f"{sum(rates[f'{key}_edge'][0] for key in _keys(legs)):.1f} of all feet"
    together = _together(legs)
    yield (
        f"in {1e6 * TOGETHER_S:.0f} us, /s",
        f"edges {edges}; {together.replace('_', ' ')} {per[together]}; one corner alone "
        f"{per['alone']}",
    )


def _rates(found: Simulated) -> Mapping[str, tuple[float, float | None]]:
    """Landings per second, by corner, edge and foot, with errors; corners with z > 0 are right.

    ± is of the runs and the step together; None where either is unknown.
    """
    time = np.array([one.duration for one in found.landings])
    rates = {}
    for name, (single, count) in counted(found.legs).items():
        numbers = np.array([count(one) for one in found.landings], dtype=float)
        value, se = observables.quotient(numbers, time)
        kind = resolution.LANDED if single else resolution.GROUPED
        step = found.verdicts[kind].error
        known = se is not None and step is not None
        error = math.hypot(se or 0.0, 0.5 * value * (step or 0.0)) if known else None
        rates[name] = (value, error)
    return rates


def landings_as_dict(found: Simulated) -> dict[str, Any]:
    """Landings for JSON: rates per second, and their errors."""
    rates = {f"{name}_per_s": one for name, one in _rates(found).items()}
    values = {name: value for name, (value, _) in rates.items()}
    return values | {"errors": {name: error for name, (_, error) in rates.items()}}


def step_as_dict(found: Simulated) -> dict[str, Any]:
    """What the step leaves of each observable, for JSON: its error, or the reason of none."""
    known = {name: found.verdicts[name].error for name in observables.NAMES}
    known = {name: error for name, error in known.items() if error is not None}
    reasons: dict[str, list[str]] = {}
    for name, one in found.verdicts.items():
        if one.reason:
            reasons.setdefault(one.reason, []).append(name)
    unresolved = [{"reason": reason, "names": names} for reason, names in reasons.items()]
    return {"errors_95": known, "not_resolved": unresolved, "warnings": list(found.point.warnings)}


def orbit_as_dict(orbit: Orbit) -> dict[str, Any]:
    """Orbit that all runs share, for JSON; bounds of prints stand in the speed's own."""
    return {"kind": orbit.kind, "draws": orbit.draws, "note": over_prints(orbit)}
