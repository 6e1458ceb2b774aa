"""Results of the analysis of motion as JSON: numbers by keys that carry their unit."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from walkergen.analysis.estimates import UNITS
from walkergen.analysis.motion import Motion
from walkergen.core.numerics import Array
from walkergen.core.numerics.quantity import Quantity, column_values

WALKER_ESTIMATES = ("speed", "turning_bias")
"""Estimates for each single walker, by the names of UNITS."""

UNBOUNDED_REASON = "the data set no finite bounds: film for longer"
"""Reason why a number with an error has no bounds."""


def from_motion(motion: Motion) -> dict[str, Any]:
    """Return all results for JSON: values, errors and reasons by keys that carry their unit."""
    facts: dict[str, Any] = {}
    for name, unit in UNITS.items():
        estimate = motion.estimates[name]
        facts |= _estimate_facts(name, estimate)
        facts[f"{name}_scale_se_{unit}"] = scale_se(estimate, motion)
        if estimate.value is not None and name in motion.counted:
            facts[f"{name}_walkers"] = motion.counted[name]
    facts |= {
        "refused": {
            column: reason
            for estimate in map(motion.estimates.__getitem__, UNITS)
            for column, reason in _null_reasons(estimate).items()
        },
        "walkers": [
            {"particle": walker.particle, "seen_s": walker.seconds}
            | {
                key: value
                for name in WALKER_ESTIMATES
                for key, value in _estimate_facts(name, walker.mean(name)).items()
            }
            | ({"refused": walker.mean("speed").refused} if walker.mean("speed").refused else {})
            for walker in motion.walkers
        ],
        "particles": motion.particles,
        "samples": motion.samples,
        "scale_se_share": motion.scale_se,
        "tracked_s": motion.tracked_s,
        "lag_s": motion.lag_s,
        "method": motion.method,
        "msd_fit": _fit_facts(motion),
        "msd": _point_facts(
            (*motion.msd, scale_errors(motion), *motion.exponent[1:]),
            "lag_s",
            "msd_mm2",
            "msd_se_mm2",
            "msd_scale_se_mm2",
            "exponent",
            "exponent_se",
        ),
        "correlation": _point_facts(motion.correlation, "lag_s", "value", "se"),
        "parallel": _point_facts(motion.parallel, "mm", "density_per_mm", "density_se_per_mm"),
        "orthogonal": _point_facts(motion.orthogonal, "mm", "density_per_mm", "density_se_per_mm"),
    }
    if motion.walls is not None:
        rate, length_mm, width_mm = motion.walls.contacts, *motion.walls.extent
        shared = motion.walls.shared
        facts["walls"] = {
            "found": shared and shared.dish.words,
            "passes": shared and shared.passes,
            "contacts_per_s": rate.value,
            "contacts_se_per_s": rate.se,
            "along_share": motion.walls.along,
            "length_mm": length_mm,
            "width_mm": width_mm,
        }
    if motion.by_plate_speed:
        facts["by_plate_speed"] = [
            {
                "plate_speed_mm_s": plate,
                "speed_mm_s": speed.value,
                "speed_se_mm_s": speed.se,
                "speed_scale_se_mm_s": scale_se(speed, motion),
            }
            | ({"refused": speed.refused} if speed.refused else {})
            | ({"speed_walkers": count} if count and speed.value is not None else {})
            for plate, speed, count in motion.by_plate_speed
        ]
        facts["speed_over_plate_speed"] = column_values(motion.line) if motion.line else None
    return facts


def _estimate_facts(name: str, estimate: Quantity) -> dict[str, float | None]:
    """Return an estimate's value, error and 95 % bounds under keys with its name and unit."""
    bounds = {f"{name}_low_95_{UNITS[name]}": estimate.low_95, f"{name}_high_95_{UNITS[name]}": estimate.high_95}
    return {f"{name}_{UNITS[name]}": estimate.value, f"{name}_se_{UNITS[name]}": estimate.se} | bounds


def _null_reasons(estimate: Quantity) -> dict[str, str]:
    """Return the reasons why a value or its bounds are null in JSON, by their keys; {} if none is."""
    if estimate.refused:
        return {estimate.column: estimate.refused}
    if estimate.interval() is not None:
        return {}
    return {f"{estimate.key}_{end}_95_{estimate.unit}": UNBOUNDED_REASON for end in ("low", "high")}


def _fit_facts(motion: Motion) -> dict[str, float | None] | None:
    """Return the parameters and the goodness of the fit of the squared displacement; None without a fit."""
    fit = motion.msd_fit
    if fit is None:
        return None
    units = ("mm2_s2", "per_s", "mm2_s", "mm2", "rad_s", "mm2_s2", "per_s")
    spread = zip(fit.spreads[0]._asdict().items(), units, strict=True)
    values = {f"{name}_{unit}": value for (name, value), unit in spread}
    values |= {"misfit": fit.misfit, "p_value": fit.p_value}
    return {name: value if math.isfinite(value) else None for name, value in values.items()}


def _point_facts(curve: Sequence[Array], *names: str) -> list[dict[str, float | None]]:
    """Return the points of a curve as mappings; `names` are the keys of its arrays."""
    return [dict(zip(names, values, strict=True)) for values in curve_points(curve)]


def curve_points(arrays: Sequence[Array]) -> list[tuple[float | None, ...]]:
    """Return the points of a curve, given as an array for each coordinate; None for a number that is not finite."""
    return [
        tuple(float(value) if math.isfinite(value) else None for value in point) for point in zip(*arrays, strict=True)
    ]


def scale_se(number: Quantity, motion: Motion) -> float | None:
    """Return the part of a number's error that is due to the film's scale; 0 for a number without a length.

    To first order: a length to a power has so many times the scale's relative error. None if the value or the scale's
    error is unknown.
    """
    power = 2 if number.unit.startswith("mm2") else 1 if number.unit.startswith("mm") else 0
    if number.value is None or (power and motion.scale_se is None):
        return None
    return abs(number.value) * power * (motion.scale_se or 0.0)


def scale_errors(motion: Motion) -> Array:
    """Return the part of the errors of the mean squared displacement due to the film's scale, mm^2; NaN if unknown."""
    share = math.nan if motion.scale_se is None else motion.scale_se
    return np.asarray(2.0 * share * np.abs(motion.msd.value))
