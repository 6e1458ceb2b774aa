"""Description of a simulation's model, its bounds in words, and its parts for JSON."""

from collections.abc import Iterator
from typing import Any

from walkergen.commands.simulate import quantities as numbers
from walkergen.commands.simulate.make import Simulation
from walkergen.commands.simulate.orbit import Orbit
from walkergen.core.files import formatting
from walkergen.core.scene import Scene
from walkergen.core.simulation import observables
from walkergen.points import speed_prediction, step_errors


def format_drive(scene: Scene) -> str:
    """Format frequency, peak acceleration and peak speed of the plate, or the motor over a still plate."""
    drive = scene.drive
    return drive.motor_in_words or f"{drive.frequency:g} Hz, {drive.peak_gamma:g} g, {drive.peak_speed:.1f} mm/s"


def format_contact(scene: Scene) -> str:
    """Return the assumptions on the contact."""
    tips = "rigid tips" if scene.feet.rigid_tips else f"tips of {scene.feet.tip_radius_um:g} um"
    return f"{tips}, restitution {scene.contact.restitution:g}, friction {scene.contact.friction:g}"


def contact_as_dict(scene: Scene) -> dict[str, Any]:
    """Return the same for JSON."""
    radius, contact = None if scene.feet.rigid_tips else scene.feet.tip_radius_um, scene.contact
    return {"tip_radius_um": radius, "restitution": contact.restitution, "friction": contact.friction}


def format_step_error(simulated: Simulation) -> str:
    """Format the possible error from the step, in addition to the mean speed and its statistical error."""
    speed = simulated.point.summary.speed
    error = step_errors.step_bias(speed)
    if error is None:
        return f"; {speed.refused}"
    return f" ± {formatting.format_number(error, 2)} by the step (95 %)" if error else ""


def bound_rows(simulated: Simulation) -> Iterator[tuple[str, str]]:
    """Yield the summary row with the bounds of the mean speed, or of prints if the runs share an orbit."""
    if simulated.orbit is not None:
        yield "prints", format_orbit_bounds(simulated.orbit)
        return
    if ends := simulated.point.summary.speed.interval():
        yield ("this simulation", f"{ends[0]:.1f} to {ends[1]:.1f} mm/s (95 %), by runs and step")
    yield "your print", _format_print_bounds(simulated)


def _format_print_bounds(simulated: Simulation) -> str:
    """Format the bounds of the speed of a print from its unknown properties, as `predict` computes them."""
    walker = simulated.point.walker
    row = speed_prediction.predict(walker.design, walker.mass, walker.scene, model="known")
    if (ends := row.speed.interval()) is None:
        return "predict tells, or ‹uncertain›"
    return f"{ends[0]:.1f} to {ends[1]:.1f} mm/s (95 %), by what is not known of contact and print"


def format_orbit_bounds(orbit: Orbit) -> str:
    """Describe how speeds differ from print to print if the runs share an orbit."""
    if orbit.prints.ends is None:
        return f"unknown how they differ: {orbit.reason}"
    low2, low1, high1, high2 = orbit.prints.ends
    return (
        f"{low1:.1f} to {high1:.1f} mm/s (68 %), {low2:.1f} to {high2:.1f} (95 %), by "
        f"{orbit.draws} draws of what design and scene do not know; ‹uncertain› tells which does it"
    )


def landings_as_dict(simulated: Simulation) -> dict[str, Any]:
    """Return landings for JSON: rates per second, and their errors."""
    rates = numbers.landing_rates(simulated)
    return {rate.column: rate.value for rate in rates} | {"errors": {rate.column: rate.se for rate in rates}}


def step_errors_as_dict(simulated: Simulation) -> dict[str, Any]:
    """Return the step's error of each observable for JSON, or the reason why there is none."""
    numbers = simulated.point.summary.numbers
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
    return {"errors_95": errors, "not_resolved": unresolved, "warnings": list(simulated.point.warnings)}


def orbit_as_dict(orbit: Orbit) -> dict[str, Any]:
    """Return the orbit that all runs share, for JSON. The bounds of prints are in the table of the speed."""
    return {"kind": orbit.kind, "draws": orbit.draws, "note": format_orbit_bounds(orbit)}
