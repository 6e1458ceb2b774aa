"""Values of parameters that a fit is to hold, as people write them: NAME=VALUE."""

from collections.abc import Mapping, Sequence

from walkergen.analysis.fits import RANGES
from walkergen.drive import MOTOR_HZ
from walkergen.errors import InputError
from walkergen.files import words
from walkergen.lab.fit.parameters import FLAT, TABLED_FROM, ModelName
from walkergen.scene import LEAST_LABEL

Ranges = Mapping[str, tuple[float, float]]


def of_theory(texts: Sequence[str]) -> dict[str, float]:
    """Parse values that the theory's fit is to hold. Raises InputError."""
    return _parsed(texts, RANGES, "")


def of_model(texts: Sequence[str], model: ModelName) -> dict[str, float]:
    """Parse values that a fit of a model's speeds is to hold. Raises InputError."""
    least = 0.0 if model == "compliant" else LEAST_LABEL
    ranges = {
        "restitution": (least, 1.0),
        "friction": (0.0, 5.0),
        "thickness_mm": (1e-3, 100.0),
        "youngs_modulus_gpa": (1e-3, 1e4),
        "damping_ratio": (0.0, 10.0),
        "frequency_hz": MOTOR_HZ,
        "eccentric_g_mm": (1e-6, 1e6),
    }
    if model == "prediction":
        del ranges["damping_ratio"]
        ranges["friction"] = (TABLED_FROM, FLAT["friction"][1])
    return _parsed(texts, ranges, f" (model {model})")


def _parsed(texts: Sequence[str], ranges: Ranges, of: str) -> dict[str, float]:
    """Values by name. Raises InputError for names and values out of range."""
    values: dict[str, float] = {}
    for text in texts:
        name, _, number = (word.strip(" ") for word in text.partition("="))
        if name not in ranges:
            raise InputError(f"--fix {text[:60]!r}: write NAME=VALUE, NAME one of {', '.join(ranges)}{of}")
        low, high = ranges[name]
        value = words.value(number)
        if value is None:
            raise InputError(f"--fix {text[:60]!r}: {number[:30]!r} is not a number")
        if not low <= value <= high:
            raise InputError(f"--fix {text[:60]!r}: must lie in {low:g}..{high:g}{of}")
        values[name] = value
    return values
