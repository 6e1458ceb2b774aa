"""Settings of a fit, and the values that it holds, NAME=VALUE, checked."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from walkergen.core.drive import MOTOR_FREQUENCY_RANGE_HZ
from walkergen.core.errors import InputError
from walkergen.core.files import formatting
from walkergen.core.scene import MIN_RESTITUTION, Scene
from walkergen.core.walker.design import Design
from walkergen.guests.lab.fit.least_squares import RANGES
from walkergen.guests.lab.fit.parameters import FLAT_RANGES, MIN_TABLE_FRICTION, PRIORS

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


class Job(NamedTuple):
    """Choices of a fit, as entered."""

    design: Design
    scene: Scene
    model: Any = "prediction"
    """Model, as its request has checked it with prior and mode."""
    fix: Sequence[str] = ()
    """Parameters to hold, NAME=VALUE."""
    prior: Any = None
    """One of PRIORS; None is the first."""
    ahead: Sequence[float] | None = None
    """Tilts to predict, deg; None for those of the design's family."""
    mode: Any = "coulomb"
    """Mode of the theory."""
    pictures: bool = True

    @property
    def held(self) -> dict[str, float]:
        """Held parameters, by name. Raises InputError for names and values out of range."""
        of = "" if self.model == "theory" else f" (model {self.model})"
        ranges, values = _ranges(self.model), {}
        for text in self.fix:
            name, _, number = (word.strip(" ") for word in text.partition("="))
            if name not in ranges:
                raise InputError(f"‹fix› {text[:60]!r}: write NAME=VALUE, NAME one of {', '.join(ranges)}{of}")
            value, (low, high) = formatting.parse_number(number), ranges[name]
            if value is None:
                raise InputError(f"‹fix› {text[:60]!r}: {number[:30]!r} is not a number")
            if not low <= value <= high:
                raise InputError(f"‹fix› {text[:60]!r}: must lie in {low:g}..{high:g}{of}")
            values[name] = value
        return values

    @property
    def caption(self) -> str:
        """Statement of the assumptions on which a fit rests."""
        parts = [f"walker {self.design.name}"]
        if self.model == "theory":
            parts.append(f"mode {self.mode}")
        else:
            parts += [f"model {self.model}", f"prior {self.prior}"]
        held = ", ".join(f"{name} = {value:g}" for name, value in self.held.items())
        return ", ".join([*parts, *([f"given {held}"] if held else [])])


def with_default_prior(job: Job) -> Job:
    """Return the job with its default prior; a fit of the theory has none."""
    return job if job.model == "theory" or job.prior is not None else job._replace(prior=PRIORS[0])


def _ranges(model: str) -> Mapping[str, tuple[float, float]]:
    """Ranges of the parameters that a fit by a model may hold."""
    if model == "theory":
        return RANGES
    ranges = dict(MODEL_RANGES)
    if model == "prediction":
        del ranges["damping_ratio"]
        ranges["friction"] = (MIN_TABLE_FRICTION, FLAT_RANGES["friction"][1])
    return ranges
