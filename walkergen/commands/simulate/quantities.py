"""Results of a simulated walker as quantities, text and JSON: motion, impacts, powers, landings, bounds."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from walkergen.analysis.estimates import LANE_REASON, NO_SLOPE_REASON
from walkergen.analysis.landings import Landings
from walkergen.commands.simulate.make import Orbit, Simulation
from walkergen.core.files import formatting
from walkergen.core.numerics.quantity import Quantity
from walkergen.core.scene import Scene
from walkergen.core.simulation import observables
from walkergen.points import speed_prediction, step_errors

MOTION_NAMES = (
    *("lane_speed", "sideways_speed", "turning_bias", "turning_scatter", *("self_alignment", "slope_turning")),
    *("rotational_diffusion", "persistence_time", "persistence_length", "diffusivity", "crossover_time"),
)
"""Names of the estimates in a summary."""

OBSERVABLE_UNITS = {
    observables.IMPACTS: ("impacts", "per_s", 1.0),
    observables.BY_IMPULSE: ("impulse of type", "percent", 100.0),
    observables.BY_NUMBER: ("impacts of type", "percent", 100.0),
    observables.CONTACT: ("in contact", "percent", 100.0),
    observables.POWERS: ("power", "uW", 1e-3),
}
"""Names, units and scales of observables in printed text."""

MIN_SHARE = 1e-3
"""Smallest share of a type in a summary; JSON has all types."""

MAX_LISTED_LEGS = 6
"""Largest number of legs whose landings a summary lists individually; JSON has all."""


MOTOR_POWER_NAMES = {"from_plate": "from_motor", f"{observables.POWERS}.from_plate": f"{observables.POWERS}.from_motor"}
"""Names of the power from a motor, by the names of the power from a plate."""


def rename_motor_power(data: Any, scene: Scene) -> Any:
    """Rename `from_plate` to `from_motor` in a name or nested data, if a motor drives the walker."""
    if scene.drive.kind == "plate":
        return data
    if isinstance(data, Mapping):
        return {rename_motor_power(key, scene): rename_motor_power(value, scene) for key, value in data.items()}
    if isinstance(data, list):
        return [rename_motor_power(entry, scene) for entry in data]
    return MOTOR_POWER_NAMES.get(data, data) if isinstance(data, str) else data


def motion_numbers(simulated: Simulation) -> Iterator[Quantity]:
    """Yield the estimates of a walker's motion. A reason that successive missing estimates share is given once."""
    if simulated.motion is None:
        return
    last_reason, estimates = "", simulated.motion.estimates
    in_lane = estimates["sideways_speed"].refused == LANE_REASON
    for number in map(estimates.__getitem__, MOTION_NAMES):
        known = number.value is not None or number.refused != last_reason
        is_mean_speed = in_lane and number.key == "lane_speed"
        if known and not is_mean_speed and number.refused not in (LANE_REASON, NO_SLOPE_REASON):
            yield number._replace(refused=number.refused.replace("film for longer", "raise ‹seconds›"))
        last_reason = number.refused
    lags, values, errors = simulated.motion.exponent
    defined = np.flatnonzero(np.isfinite(values) & np.isfinite(errors))
    nearest = [defined[np.abs(lags[defined] / lag - 1.0).argmin()] for lag in (0.1, 1.0) if len(defined)]
    for index in dict.fromkeys(nearest):
        yield Quantity(f"msd exponent at {lags[index]:.2g} s", "", float(values[index]), float(errors[index]))


def observed_numbers(simulated: Simulation) -> Iterator[Quantity]:
    """Yield rate of impacts, shares of their types, contact and powers, with errors of runs and step together."""
    point = simulated.results
    for table, (title, unit, scale) in OBSERVABLE_UNITS.items():
        for name, number in point.summary.numbers.items():
            value = number.value or 0.0
            if name.partition(".")[0] != table or (unit == "percent" and value < MIN_SHARE and "." in name):
                continue
            reason, se = step_errors.reason(number), step_errors.total_error(number)
            if simulated.orbit is not None and not reason:
                se = 0.0  # runs that share an orbit have no statistical error
            key = f"{title} {rename_motor_power(name.partition('.')[2], simulated.scene)}".strip()
            yield Quantity(key, unit, scale * value, None if se is None else scale * se, refused=reason)
    yield Quantity("energy unaccounted", "percent", 100.0 * point.summary.energy_error, 0.0)


def landing_numbers(simulated: Simulation) -> Iterator[Quantity]:
    """Yield landings per second for printed text. With many legs, yield only those of all feet together."""
    if not simulated.landings:
        return
    first = 0 if len(simulated.legs) <= MAX_LISTED_LEGS else 3 * len(simulated.legs)  # two corners and an edge a leg
    for rate in landing_rates(simulated)[first:]:
        yield rate._replace(key=f"landings {rate.key}")


def landing_names(legs: Sequence[str]) -> list[str]:
    """Return names of kinds of landings: each corner, both corners of a leg, several feet, one corner only."""
    keys = [leg.replace(" ", "_") for leg in legs]
    corners = [f"{leg}_{side}" for leg in keys for side in ("left", "right")]
    return [*corners, *(f"{leg}_edge" for leg in keys), "both_feet" if len(legs) == 2 else "several_feet", "alone"]


def count_landings(landings: Landings) -> list[int]:
    """Return the numbers of landings of each kind, in the order of `landing_names`."""
    return [*landings.corners.tolist(), *landings.edges.tolist(), landings.pairs, landings.alone]


def landing_rates(simulated: Simulation) -> list[Quantity]:
    """Return landings per second of each kind, with errors of runs and step together. Right corners have z > 0."""
    time = np.array([landings.duration for landings in simulated.landings])
    counts = np.array([count_landings(landings) for landings in simulated.landings], dtype=float)
    rates = []
    for index, name in enumerate(landing_names(simulated.legs)):
        rate = observables.ratio_of_sums(name, counts[:, index], time)
        kind = step_errors.LANDING_RATE if index < 2 * len(simulated.legs) else step_errors.GROUP_RATE
        step = simulated.results.summary.numbers[kind]
        biased = rate._replace(bias=step.bias if step_errors.reason(step) else step.bias * rate.number)
        rates.append(Quantity(name, "per_s", rate.number, step_errors.total_error(biased)))
    return rates


def notes(simulated: Simulation) -> Iterator[str]:
    """Yield notes on the measurement of the motion, and on reasons to doubt it."""
    if simulated.motion is not None:
        yield from (simulated.motion.method, *simulated.motion.doubts)
    if simulated.results.summary.numbers[step_errors.MOTION].refused == step_errors.TURNING_REASON:
        yield step_errors.TURNING_REASON


def format_drive(scene: Scene) -> str:
    """Format frequency, peak acceleration and peak speed of the plate, or the motor if the plate is at rest."""
    drive = scene.drive
    return drive.motor_in_words or f"{drive.frequency:g} Hz, {drive.peak_gamma:g} g, {drive.peak_speed:.1f} mm/s"


def format_contact(scene: Scene) -> str:
    """Return the assumptions on the contact."""
    tips = "rigid tips" if scene.feet.rigid_tips else f"tips of {scene.feet.tip_radius_um:g} um"
    return f"{tips}, restitution {scene.contact.restitution:g}, friction {scene.contact.friction:g}"


def contact_as_dict(scene: Scene) -> dict[str, Any]:
    """Return the assumptions on the contact for JSON."""
    radius, contact = None if scene.feet.rigid_tips else scene.feet.tip_radius_um, scene.contact
    return {"tip_radius_um": radius, "restitution": contact.restitution, "friction": contact.friction}


def format_step_error(simulated: Simulation) -> str:
    """Return text on the error from the time step, which is printed after the mean speed and its statistical error."""
    speed = simulated.results.summary.speed
    error = step_errors.step_bias(speed)
    if error is None:
        return f"; {speed.refused}"
    return f" ± {formatting.format_number(error, 2)} from the {_error_sources(simulated)} (95 %)" if error else ""


def _error_sources(simulated: Simulation) -> str:
    """Return what causes the error of the mean speed besides the scatter of runs."""
    simple = simulated.simplest
    return "step and omitted effects" if simple is not None and simple.left_out else "step"


def bound_rows(simulated: Simulation) -> Iterator[tuple[str, str]]:
    """Yield the rows with the bounds of the mean speed and of a print; only those of prints if runs share an orbit."""
    if simulated.orbit is not None:
        yield "prints", format_orbit_bounds(simulated.orbit)
        return
    if bounds := simulated.results.summary.speed.interval():
        sources = _error_sources(simulated)
        yield "this simulation", f"{bounds[0]:.1f} to {bounds[1]:.1f} mm/s (95 %), from runs and {sources}"
    yield "your print", _format_print_bounds(simulated)


def _format_print_bounds(simulated: Simulation) -> str:
    """Format the bounds of the speed of a print, which has unknown properties, as `predict` computes them."""
    walker = simulated.results.walker
    row = speed_prediction.predict(walker.design, walker.mass, walker.scene, model="known")
    if (bounds := row.speed.interval()) is None:
        return "run `predict`, or add ‹uncertain›"
    return f"{bounds[0]:.1f} to {bounds[1]:.1f} mm/s (95 %), from the unknown contact and print"


def format_orbit_bounds(orbit: Orbit) -> str:
    """Describe how speeds differ from print to print if the runs share an orbit."""
    if orbit.prints.ends is None:
        return f"unknown scatter: {orbit.reason}"
    low2, low1, high1, high2 = orbit.prints.ends
    return (
        f"{low1:.1f} to {high1:.1f} mm/s (68 %), {low2:.1f} to {high2:.1f} (95 %), from "
        f"{orbit.draws} draws of the uncertain inputs; ‹uncertain› shows which of them matters"
    )


def landings_as_dict(simulated: Simulation) -> dict[str, Any]:
    """Return rates of landings for JSON, per second, and their errors, by name."""
    rates = landing_rates(simulated)
    return {rate.column: rate.value for rate in rates} | {"errors": {rate.column: rate.se for rate in rates}}


def step_errors_as_dict(simulated: Simulation) -> dict[str, Any]:
    """Return the error of each observable from the time step for JSON, or the reason why it is unknown."""
    numbers = simulated.results.summary.numbers
    errors = {
        name: numbers[name].bias
        for name in observables.OBSERVABLE_NAMES
        if step_errors.step_bias(numbers[name]) is not None
    }
    reasons: dict[str, list[str]] = {}
    for name, number in numbers.items():
        if reason := step_errors.reason(number):
            reasons.setdefault(reason, []).append(name)
    unresolved = [{"reason": reason, "names": names} for reason, names in reasons.items()]
    return {"errors_95": errors, "not_resolved": unresolved, "warnings": list(simulated.results.warnings)}


def orbit_as_dict(orbit: Orbit) -> dict[str, Any]:
    """Return the orbit that all runs share for JSON, without the bounds of prints, which the speed has."""
    return {"kind": orbit.kind, "draws": orbit.draws, "note": format_orbit_bounds(orbit)}
