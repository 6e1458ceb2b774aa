"""Parameters that a fit holds, NAME=VALUE, and the statement of its assumptions."""

from collections.abc import Mapping

from walkergen.core.drive import MOTOR_FREQUENCY_RANGE_HZ
from walkergen.core.errors import InputError
from walkergen.core.files import formatting
from walkergen.core.scene import MIN_RESTITUTION
from walkergen.guests.lab.fit.fields import FitFields
from walkergen.guests.lab.fit.least_squares import RANGES
from walkergen.guests.lab.fit.parameters import DEFAULT_PRIOR, FLAT_RANGES, MIN_TABLE_FRICTION

MODEL_RANGES = {
    "restitution": (MIN_RESTITUTION, 1.0),
    "friction": (0.0, 5.0),
    "tip_radius_um": (1e-3, 1e6),
    "thickness_mm": (1e-3, 100.0),
    "youngs_modulus_gpa": (1e-3, 1e4),
    "damping_ratio": (0.0, 10.0),
    "frequency_hz": MOTOR_FREQUENCY_RANGE_HZ,
    "eccentric_g_mm": (1e-6, 1e6),
}
"""Ranges of the parameters that a fit of simulated speeds may hold."""


def parse_held(request: FitFields) -> dict[str, float]:
    """Parse `request.fix` to values by parameter name. Raises InputError for unknown names and values out of range."""
    model_note = "" if request.model == "theory" else f" (model {request.model})"
    ranges, held = _held_ranges(request.model), {}
    for text in request.fix:
        name, _, number = (word.strip(" ") for word in text.partition("="))
        if name not in ranges:
            raise InputError(f"‹fix› {text[:60]!r}: write NAME=VALUE, NAME one of {', '.join(ranges)}{model_note}")
        value, (low, high) = formatting.parse_number(number), ranges[name]
        if value is None:
            raise InputError(f"‹fix› {text[:60]!r}: {number[:30]!r} is not a number")
        if not low <= value <= high:
            raise InputError(f"‹fix› {text[:60]!r}: must lie in {low:g}..{high:g}{model_note}")
        held[name] = value
    return held


def describe_assumptions(request: FitFields, walker: str, held: Mapping[str, float]) -> str:
    """Describe the assumptions of a fit in words: name of the walker, model, prior, and the held parameters."""
    parts = [f"walker {walker}"]
    if request.model == "theory":
        parts.append(f"mode {request.mode}")
    else:
        parts += [f"model {request.model}", f"prior {request.prior or DEFAULT_PRIOR}"]
    given = ", ".join(f"{name} = {value:g}" for name, value in held.items())
    return ", ".join([*parts, *([f"given {given}"] if given else [])])


def _held_ranges(model: str) -> Mapping[str, tuple[float, float]]:
    """Return the ranges of the parameters that a fit of a model may hold."""
    if model == "theory":
        return RANGES
    ranges = dict(MODEL_RANGES)
    if model == "prediction":
        del ranges["damping_ratio"]
        ranges["friction"] = (MIN_TABLE_FRICTION, FLAT_RANGES["friction"][1])
    return ranges
