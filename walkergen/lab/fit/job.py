"""What a person asks of a fit, and the values that it is to hold, NAME=VALUE, checked."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from walkergen.drive import MOTOR_HZ
from walkergen.errors import InputError
from walkergen.files import words
from walkergen.lab.fit.least_squares import RANGES
from walkergen.lab.fit.parameters import FLAT, PRIORS, TABLED_FROM
from walkergen.scene import LEAST_LABEL, Scene
from walkergen.theory.speed import MODES
from walkergen.walker.design import Design

MODELS = ("prediction", "theory", "compliant", "space")

OF_MODEL = {
    "restitution": (LEAST_LABEL, 1.0),
    "friction": (0.0, 5.0),
    "thickness_mm": (1e-3, 100.0),
    "youngs_modulus_gpa": (1e-3, 1e4),
    "damping_ratio": (0.0, 10.0),
    "frequency_hz": MOTOR_HZ,
    "eccentric_g_mm": (1e-6, 1e6),
}
"""Ranges of the parameters that a fit of simulated speeds may hold."""


class Job(NamedTuple):
    """Choices of a fit, as people write them."""

    design: Design
    scene: Scene
    model: Any = "prediction"
    """One of MODELS."""
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
        """Parameters that are held, by name. Raises InputError for names and values out of range."""
        of = "" if self.model == "theory" else f" (model {self.model})"
        ranges, values = _ranges(self.model), {}
        for text in self.fix:
            name, _, number = (word.strip(" ") for word in text.partition("="))
            if name not in ranges:
                raise InputError(f"--fix {text[:60]!r}: write NAME=VALUE, NAME one of {', '.join(ranges)}{of}")
            value, (low, high) = words.value(number), ranges[name]
            if value is None:
                raise InputError(f"--fix {text[:60]!r}: {number[:30]!r} is not a number")
            if not low <= value <= high:
                raise InputError(f"--fix {text[:60]!r}: must lie in {low:g}..{high:g}{of}")
            values[name] = value
        return values

    @property
    def caption(self) -> str:
        """Statement of the assumptions on which a fit rests."""
        contact, model = self.scene.contact, self.model
        parts = [f"walker {self.design.name}"]
        if model == "theory":
            parts += [f"mode {self.mode}", f"law {contact.law}"]
        else:
            parts.append(f"model {model}")
            parts += [f"{self.scene.feet.damping} feet"] if model == "space" else []
            parts += [f"law {contact.law}"] if model == "compliant" else []
            parts.append(f"prior {self.prior}")
        held = ", ".join(f"{name} = {value:g}" for name, value in self.held.items())
        return ", ".join([*parts, *([f"given {held}"] if held else [])])


def checked(job: Job) -> Job:
    """Job with its prior and with the scene of its model. Raises InputError for what does not go together."""
    model, prior, mode = job.model, job.prior, job.mode
    if model not in MODELS:
        raise InputError(f"--model {str(model)[:30]!r}: must be one of {', '.join(MODELS)}")
    if mode not in MODES:
        raise InputError(f"--mode {str(mode)[:30]!r}: must be one of {', '.join(MODES)}")
    if model == "theory":
        if (prior, job.ahead) != (None, None):
            name = "--predict" if prior is None else "--prior"
            raise InputError(f"{name}: the theory has none; leave out --model theory")
        return job
    if mode != "coulomb":
        raise InputError(f"--mode {mode!r}: a mode of the theory; --model {model} has none")
    scene = job.scene if model == "prediction" else job.scene.variant(**{"legs.model": model})
    prior = PRIORS[0] if prior is None else prior
    if prior not in PRIORS:
        raise InputError(f"--prior {str(prior)[:30]!r}: must be one of {', '.join(PRIORS)}")
    return job._replace(scene=scene, prior=prior)


def _ranges(model: str) -> Mapping[str, tuple[float, float]]:
    """Ranges of the parameters that a fit by a model may hold."""
    if model == "theory":
        return RANGES
    ranges = dict(OF_MODEL)
    if model == "compliant":
        ranges["restitution"] = (0.0, 1.0)
    if model == "prediction":
        del ranges["damping_ratio"]
        ranges["friction"] = (TABLED_FROM, FLAT["friction"][1])
    return ranges
