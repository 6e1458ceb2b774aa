"""Tables of simulated walkers: what the model is, how they move, how they land."""

import functools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from walkergen.analysis.estimates import IN_A_LANE, LEVEL, with_error
from walkergen.analysis.landings import CORNERS, TOGETHER_S, Landings
from walkergen.analysis.motion import Motion
from walkergen.files import words
from walkergen.jobs.run.simulate.make import Simulated
from walkergen.jobs.run.simulate.orbit import Orbit
from walkergen.points import speeds
from walkergen.scene import Scene
from walkergen.simulation import observables, resolution
from walkergen.simulation.observables import POWER_ROWS

MOVED = {
    "lane_speed": ("along x", "mm/s"),
    "sideways_speed": ("sideways drift", "mm/s to the left"),
    "turning_bias": ("turning", "rad/s to the left"),
    "turning_scatter": ("turning scatter", "rad/s between runs"),
    "self_alignment": ("self-alignment", "/mm (> 0: turns the way that the slope takes it)"),
    "slope_turning": ("turned by slope", "rad/s toward the descent, at 90 deg to it"),
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


BY_MOTOR = {"from_plate": "from_motor", f"{observables.POWERS}.from_plate": f"{observables.POWERS}.from_motor"}
"""Names of the power that a motor gives, by those of a plate's."""


def of_drive(data: Any, scene: Scene) -> Any:
    """Data or a name, in which power comes from the motor where a motor drives: the tally's row of
    the plate's work holds a motor's.
    """
    if scene.drive.kind == "plate":
        return data
    if isinstance(data, Mapping):
        return {of_drive(key, scene): of_drive(value, scene) for key, value in data.items()}
    if isinstance(data, list):
        return [of_drive(entry, scene) for entry in data]
    return BY_MOTOR.get(data, data) if isinstance(data, str) else data


def plate_in_words(scene: Scene) -> str:
    """Frequency, peak acceleration and peak speed of the plate, or the motor over a still one."""
    drive = scene.drive
    return drive.motor_in_words or f"{drive.frequency:g} Hz, {drive.peak_gamma:g} g, {drive.peak_speed:.1f} mm/s"


def model_in_words(simulated: Simulated, scene: Scene) -> str:
    """Model of a simulation, and what it assumes of the contact."""
    contact, model = scene.contact, simulated.point.model
    law = feet_in_words(scene) if model == "space" else f"law of impact {contact.law}"
    return f"{model}, {law}, restitution {contact.restitution:g}, friction {contact.friction:g}"


def feet_in_words(scene: Scene) -> str:
    """Tips of the feet, as reports name them."""
    return "rigid tips" if scene.feet.rigid_tips else f"tips of {scene.feet.tip_radius_um:g} um"


def model_as_dict(simulated: Simulated, scene: Scene) -> dict[str, Any]:
    """Model, method and contact law of a simulation for JSON."""
    named = {"model": simulated.point.model, "method": simulated.point.method}
    contact = scene.contact
    if simulated.point.model != "space":
        return named | {"law": contact.law}
    radius = None if scene.feet.rigid_tips else scene.feet.tip_radius_um
    return named | {"tip_radius_um": radius, "restitution": contact.restitution, "friction": contact.friction}


def motion_rows(simulated: Simulated) -> Iterator[tuple[str, str]]:
    """Rows of a summary on how walkers in space move, each number with its error or a reason."""
    if simulated.untold:
        yield "motion", f"unknown: {simulated.untold}"
    if simulated.motion is None:
        return
    before = ""
    in_lane = simulated.motion.estimates["sideways_speed"].refused == IN_A_LANE
    for name, (title, unit) in MOVED.items():
        estimate = simulated.motion.estimates[name]
        if in_lane and name == "lane_speed":
            continue  # the summary's mean speed
        if estimate.refused not in (IN_A_LANE, LEVEL) and (estimate.value is not None or estimate.refused != before):
            value = with_error(estimate)
            text = f"{value} {unit}"
            if name == "rotational_diffusion" and estimate.value:
                text += f" (1/D_r = {words.number(1.0 / estimate.value)} s)"
            yield title, value if estimate.value is None else text
        before = estimate.refused
    yield "msd exponent", _exponents(simulated.motion)
    for note in (simulated.motion.method, *simulated.motion.doubts):
        yield "note", note


def _exponents(motion: Motion) -> str:
    """Local exponents of the squared displacement at the known lags nearest to 0.1 s and 1 s."""
    defined = [
        (at, value, se)
        for at, value, se in zip(*motion.exponent, strict=True)
        if value == value and se == se  # not NaN
    ]
    if not defined:
        return "runs are too short"
    nearest = [min(defined, key=lambda pair: abs(pair[0] / lag - 1.0)) for lag in (0.1, 1.0)]
    return ", ".join(
        f"{words.with_error(value, se)} at {words.number(at, 2)} s" for at, value, se in dict.fromkeys(nearest)
    )


def speed_by_step(simulated: Simulated) -> str:
    """Addition to the mean speed and its statistical error: what the step may do to it."""
    error, reason = simulated.point.step_errors[observables.SPEED]
    if error is None:
        return f" {_marks(simulated)[reason]}"
    return f" ± {words.number(error, 2)} by the step (95 %)" if error else ""


def bound_rows(simulated: Simulated) -> Iterator[tuple[str, str]]:
    """Row of a summary with the bounds of the mean speed; of prints where runs share an orbit."""
    if simulated.orbit is not None:
        yield "prints", over_prints(simulated.orbit)
        return
    summary = simulated.point.summary
    low, high = summary.speed_low_95_mm_s, summary.speed_high_95_mm_s
    if low is not None and high is not None:
        yield ("this simulation", f"{low:.1f} to {high:.1f} mm/s (95 %), by runs and step")
    yield "your print", _of_prints(simulated)


def _of_prints(simulated: Simulated) -> str:
    """Bounds of the speed of a print, by what nobody knows of it, as `predict` has them."""
    walker = simulated.point.walker
    row = speeds.predict(walker.design, walker.mass, walker.scene, model="known")
    low, high = row.speed_low_95_mm_s, row.speed_high_95_mm_s
    if low is None or high is None:
        return "predict tells, or --uncertain"
    return f"{low:.1f} to {high:.1f} mm/s (95 %), by what is not known of contact and print"


def over_prints(orbit: Orbit) -> str:
    """Statement of how speeds differ from print to print, where runs share an orbit."""
    if orbit.bounds_mm_s is None:
        return f"unknown how they differ: {orbit.reason}"
    low2, low1, high1, high2 = orbit.bounds_mm_s
    return (
        f"{low1:.1f} to {high1:.1f} mm/s (68 %), {low2:.1f} to {high2:.1f} (95 %), by "
        f"{orbit.draws} draws of what design and scene do not know; --uncertain tells which does it"
    )


def statistic_rows(simulated: Simulated) -> Iterator[tuple[str, str]]:
    """Rows of a summary on impacts, contact and powers; ± is of the runs and the step together."""
    in_words = functools.partial(_told, simulated)
    yield "impacts", in_words(observables.IMPACTS, unit=" per second")
    yield "by impulse", _shares(simulated, observables.BY_IMPULSE)
    yield "by number", _shares(simulated, observables.BY_NUMBER)
    if simulated.landings:
        yield from _landing_rows(simulated)
    yield "in contact", in_words(observables.CONTACT, 100.0, " % of the time")
    powers = (
        f"{of_drive(name, simulated.scene)} {in_words(f'{observables.POWERS}.{name}', 1e-6)}" for name in POWER_ROWS
    )
    unaccounted = 100 * simulated.point.summary.energy_error
    yield "power, uW", f"{', '.join(powers)}; unaccounted {words.number(unaccounted, 2)} %"
    for reason, mark in _marks(simulated).items():
        yield "note" if reason == resolution.TURNING else mark, reason


def _told(simulated: Simulated, name: str, scale: float = 1.0, unit: str = "") -> str:
    """An observable with its error, or with the mark of the reason why it has none."""
    step, value = simulated.point.step_errors[name], scale * simulated.point.values[name]
    if step.error is None:
        return f"{words.number(value, 4)}{unit} {_marks(simulated)[step.reason]}"
    if simulated.orbit is not None:
        return f"{words.number(value, 4)}{unit}"
    error = simulated.errors[name]
    both = f"{words.number(value, 4)} ± ?" if error is None else words.with_error(value, scale * error)
    return f"{both}{unit}"


def _marks(simulated: Simulated) -> dict[str, str]:
    """Marks (a), (b) ... of the reasons why observables are not resolved."""
    reasons = dict.fromkeys(step.reason for step in simulated.point.step_errors.values() if step.reason)
    return {reason: f"({letter})" for reason, letter in zip(reasons, "abc", strict=False)}


def _shares(simulated: Simulated, table: str) -> str:
    """Shares of the types that are not rare, in percent; a reason common to all comes once."""
    own = (name for name in simulated.point.values if name.startswith(f"{table}."))
    names = [name for name in own if simulated.point.values[name] >= RARE]
    short = [name.partition(".")[2] for name in names]
    reason = simulated.point.step_errors[f"{table}.I"].reason
    if reason:
        shares = (f"{100 * simulated.point.values[name]:.1f} %" for name in names)
        rows = ", ".join(f"{name_of} {share}" for name_of, share in zip(short, shares, strict=True))
        return f"{rows} {_marks(simulated)[reason]}" if rows else "none"
    text = (f"{name_of} {_told(simulated, name, 100.0, ' %')}" for name_of, name in zip(short, names, strict=True))
    return ", ".join(text) or "none"


def counted(legs: Sequence[str]) -> dict[str, tuple[bool, Callable[[Landings], int]]]:
    """Numbers of landings, and of groups of them, by name; True for those of single corners."""
    counters: dict[str, tuple[bool, Callable[[Landings], int]]] = {}
    for foot, leg in enumerate(_keys(legs)):
        for side, name in enumerate(("left", "right")):
            number = CORNERS * foot + side
            counters[f"{leg}_{name}"] = True, functools.partial(_corner, number)
    for foot, leg in enumerate(_keys(legs)):
        counters[f"{leg}_edge"] = False, functools.partial(_edge, foot)
    counters[_together(legs)] = False, lambda landings: landings.pairs
    counters["alone"] = False, lambda landings: landings.alone
    return counters


def _corner(number: int, landings: Landings) -> int:
    return int(landings.corners[number])


def _edge(foot: int, landings: Landings) -> int:
    return int(landings.edges[foot])


def _keys(legs: Sequence[str]) -> list[str]:
    """Names of legs as keys."""
    return [leg.replace(" ", "_") for leg in legs]


def _together(legs: Sequence[str]) -> str:
    """Name of groups in which more than one foot landed."""
    return "both_feet" if len(legs) == 2 else "several_feet"


def _landing_rows(simulated: Simulated) -> Iterator[tuple[str, str]]:
    """Rows of a summary on landings: numbers by corner, edge and foot."""
    rates, legs = _rates(simulated), simulated.legs
    per = {
        name: words.fixed(value, 1) if error is None else words.with_error(value, error)
        for name, (value, error) in rates.items()
    }
    if len(legs) <= MOST_LISTED:
        shown = zip(legs, _keys(legs), strict=True)
        yield (
            "by corner, /s",
            "; ".join(f"{leg} {per[f'{key}_left']} left, {per[f'{key}_right']} right" for leg, key in shown),
        )
        edges = ", ".join(f"{per[f'{key}_edge']} {leg}" for leg, key in zip(legs, _keys(legs), strict=True))
    else:
        sums = {
            leg: rates[f"{key}_left"][0] + rates[f"{key}_right"][0] for leg, key in zip(legs, _keys(legs), strict=True)
        }
        low, high = (pick(sums, key=sums.__getitem__) for pick in (min, max))
        text = f"{sums[low]:.1f} ({low}) to {sums[high]:.1f} ({high}); --json lists all"
        yield "by foot, /s", f"{len(legs)} feet: {text}"
        edges = f"{sum(rates[f'{key}_edge'][0] for key in _keys(legs)):.1f} of all feet"
    together = _together(legs)
    yield (
        f"in {1e6 * TOGETHER_S:.0f} us, /s",
        f"edges {edges}; {together.replace('_', ' ')} {per[together]}; one corner alone {per['alone']}",
    )


def _rates(simulated: Simulated) -> Mapping[str, tuple[float, float | None]]:
    """Landings per second, by corner, edge and foot, with errors; corners with z > 0 are right.

    ± is of the runs and the step together; None where either is unknown.
    """
    time = np.array([landings.duration for landings in simulated.landings])
    rates = {}
    for name, (single, count) in counted(simulated.legs).items():
        numbers = np.array([count(landings) for landings in simulated.landings], dtype=float)
        rate = observables.quotient(name, numbers, time)
        kind = resolution.LANDED if single else resolution.GROUPED
        step = simulated.point.step_errors[kind].error
        bounded = rate.se is not None and step is not None
        value = rate.value or 0.0
        error = math.hypot(rate.se or 0.0, 0.5 * value * (step or 0.0)) if bounded else None
        rates[name] = (value, error)
    return rates


def landings_as_dict(simulated: Simulated) -> dict[str, Any]:
    """Landings for JSON: rates per second, and their errors."""
    rates = {f"{name}_per_s": rate for name, rate in _rates(simulated).items()}
    values = {name: value for name, (value, _) in rates.items()}
    return values | {"errors": {name: error for name, (_, error) in rates.items()}}


def step_as_dict(simulated: Simulated) -> dict[str, Any]:
    """What the step leaves of each observable, for JSON: its error, or the reason of none."""
    errors = {name: simulated.point.step_errors[name].error for name in observables.NAMES}
    errors = {name: error for name, error in errors.items() if error is not None}
    reasons: dict[str, list[str]] = {}
    for name, step in simulated.point.step_errors.items():
        if step.reason:
            reasons.setdefault(step.reason, []).append(name)
    unresolved = [{"reason": reason, "names": names} for reason, names in reasons.items()]
    return {"errors_95": errors, "not_resolved": unresolved, "warnings": list(simulated.point.warnings)}


def orbit_as_dict(orbit: Orbit) -> dict[str, Any]:
    """Orbit that all runs share, for JSON; bounds of prints stand in the speed's own."""
    return {"kind": orbit.kind, "draws": orbit.draws, "note": over_prints(orbit)}
