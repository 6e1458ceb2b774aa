"""Texts of a page for users of a mouse: speeds in sentences, without keys of files and flags of a shell."""

import re
from collections.abc import Mapping
from functools import cache
from typing import Any, Literal, NamedTuple

from walkergen.core.files import config
from walkergen.core.files import formatting as words
from walkergen.core.printing.printers import Printer
from walkergen.core.scene import Scene
from walkergen.core.theory import prediction
from walkergen.core.theory.prediction import Prediction
from walkergen.core.walker.design import Design
from walkergen.core.walker.limbs import Leg
from walkergen.files import key_names

QUARTILE_RATIO = 0.6745
"""Distance of the quartiles of a normal distribution from its median, over the half-width of its 68 % interval."""

TITLES: Mapping[str, str] = {
    "koumakis2016": "the paper's walker",
    "name": "a name",
    "maker-large": "double size",
    "bristle": "a brush of legs",
    "bristlebot": "a brush with a motor",
    "coinbot": "with a coin motor",
    "polar-disc": "a disc",
    "rotator": "a disc that turns",
    "spinner": "a disc that spins",
    "two-materials": "feet of rubber",
    "unequal-legs": "unlike legs",
    "lane-90hz": "the paper's plate, a lane",
    "lane-90hz-fitted": "the paper's lane, as its theory was fitted",
    "lane-90hz-walls": "the paper's plate, a lane between walls",
    "plane-90hz": "the paper's plate, open",
    "plane-noisy": "an open plate that is noisy, as in a laboratory",
    "table-motor": "a table; the walker has a motor",
}
"""Plain names of walkers and scenes, by the names of their files."""

MENU_NAMES: Mapping[str, str] = {
    'wall_generator = "classic"': "the perimeter generator (wall generator in Orca and Bambu) Classic",
    "set thin_walls = true": "switch on “Detect thin walls”",
    "thin_walls = true": "“Detect thin walls” on",
    "set brim_width_mm": "give it a brim",
    "turn the mesh by body.up": "choose another axis that points up",
}
"""Names of settings in the menus of slicers and in the page's form, by the keys in messages."""

Kind = Literal["forward", "backward", "stands", "falls", "unknown"]


class Speed(NamedTuple):
    """Speed of a walker in a sentence."""

    text: str
    kind: Kind
    sure: bool
    """False if the speed still requires a run."""


def format_speed(row: Prediction) -> Speed:
    """Format the speed of a prediction: its median, and the range of half of the prints.

    The quartiles follow from the 68 % interval, on either side as for a normal distribution.
    """
    ends = row.speed.interval(0.68)
    if ends is None and row.falls > 0.0:
        return Speed(f"falls over in {100.0 * row.falls:.0f} % of its runs.", "falls", True)
    if ends is None:
        return Speed("Simulate it to see how fast it runs.", "unknown", False)
    if prediction.is_standing(row):
        bounds = "" if row.speed_by == "statics" else f", with bounds {_format_range(*ends)}"
        return Speed(f"stands{bounds}.", "stands", True)
    middle = row.speed.number
    quarter, most = (middle + QUARTILE_RATIO * (end - middle) for end in ends)
    return Speed(
        f"{_format_velocity(middle)}; half of the prints run {_format_range(quarter, most)}.", _direction(middle), True
    )


def _direction(value: float) -> Kind:
    return "forward" if value >= 0.0 else "backward"


def _format_velocity(value: float) -> str:
    if value < 0.0:
        return f"runs backward, about {_format_size(value)} mm/s to the left"
    return f"about {_format_size(value)} mm/s to the right"


def _format_size(value: float) -> str:
    return words.format_fixed(abs(value), 0 if abs(value) >= 9.95 else 1)


def _format_range(low: float, high: float) -> str:
    """Format a range of speeds. Negative speeds are to the left."""
    if low >= 0.0:
        return f"between {_format_size(low)} and {_format_size(high)}"
    if high <= 0.0:
        return f"between {_format_size(high)} and {_format_size(low)} to the left"
    return f"between {_format_size(low)} to the left and {_format_size(high)} to the right"


def format_runs(facts: Mapping[str, Any]) -> str:
    """Describe the runs of a walker in a sentence, from the facts of `simulate`."""
    value, error = facts["speed_mm_s"], facts["speed_se_mm_s"]
    if value is None:
        return "No run ended with a speed."
    low, high = facts["speed_low_95_mm_s"], facts["speed_high_95_mm_s"]
    way = "to the right" if value >= 0.0 else "to the left, backward"
    speed = words.format_with_error(abs(value), error) if error else _format_size(value)
    bounds = (
        "" if low is None or high is None else f"; with the error of the simulator {_format_range(low, high)} (95 %)"
    )
    return f"As designed it ran {speed} mm/s {way}{bounds}."


def format_name(key: str) -> str:
    """Return the name of an unknown input without its unit; `key` is its key, or words."""
    words = re.sub(r" \([^)]*\)$", "", key_names.format_key(key)) if "." in key else key
    return re.sub(r"^(.+?) sd\b", r"deviation of \1", words)


def format_setting(key: str, value: float) -> str:
    """Format the value of a key of a walker or, after "printer.", of the printer, in words."""
    return f"{format_name(key)}: {value:g} {key_names.UNITS_BY_SUFFIX.get(_unit_ending(key), '')}".strip()


def format_title(name: str) -> str:
    """Return the plain name of a template followed by its own, or only its own."""
    return f"{TITLES[name]} ({name})" if name in TITLES else name


def to_plain_text(text: str) -> str:
    """Remove keys of files and flags of a shell from a text: keys become words, clauses with a flag are dropped."""
    clauses = re.split(r"(?<=[;:,.]) ", text)
    kept = [clause for clause in clauses if not re.search(r"(?<![\w-])--?[a-z][\w-]+|[`‹]|walkergen ", clause)]
    text = re.sub(r"[;:,]$", "", " ".join(kept or clauses))
    for key, menu in MENU_NAMES.items():
        text = text.replace(key, menu)
    text = re.sub(r"(?<!\w)\[{1,2}([a-z_]+)\]{1,2}", r"\1", text)  # tables
    text = re.sub(r">= (\S+) and <= (\S+)", r"between \1 and \2", text)
    text = re.sub(r"([\w.\[\]]+) = (true|false)\b", lambda key: f"{key[1]}: {_yes_or_no(key[2])}", text)
    return re.sub(r"[A-Za-z_]\w*(?:\[\d+\])?(?:\.[A-Za-z_]\w*(?:\[\d+\])?)*", _format_key, text)


def _yes_or_no(word: str) -> str:
    return "yes" if word == "true" else "no"


def _format_key(key: re.Match[str]) -> str:
    """Return a key in words without its unit, and other words unchanged."""
    known = key[0].removeprefix("scene.").removeprefix("printer.")
    if known.isidentifier() and known != key[0]:  # a table
        return known
    if ("." not in known and "_" not in known) or re.sub(r"\[\d+\]", "", known) not in _file_keys():
        return key[0]
    return format_name(known) if "." in known else known.removesuffix(_unit_ending(known)).replace("_", " ")


def _unit_ending(key: str) -> str:
    return next((end for end in key_names.UNITS_BY_SUFFIX if key.endswith(end)), "")


@cache
def _file_keys() -> frozenset[str]:
    """Return all keys of files, and their last parts that contain an underscore."""
    paths = [".".join(path) for model in (Design, Scene, Printer) for path in config.key_paths(model)]
    paths += [f"legs.{name}" for name in Leg.model_fields]
    return frozenset([*paths, *(name for path in paths if "_" in (name := path.rpartition(".")[2]))])
