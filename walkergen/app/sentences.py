"""Texts of the page: speeds as sentences, and messages without keys of files and flags of a shell."""

import json
import re
from collections.abc import Mapping
from functools import cache
from pathlib import Path
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

TITLES: Mapping[str, str] = json.loads(Path(__file__).with_name("assets").joinpath("titles.json").read_bytes())
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
    """Speed of a walker as a sentence."""

    text: str
    kind: Kind
    sure: bool
    """False if the speed is not known without a simulation."""


def format_speed(row: Prediction) -> Speed:
    """Format the predicted speed as a sentence: its median, and the range that contains half of the prints.

    The quartiles are computed from the 68 % interval, on either side as for a normal distribution.
    """
    ends = row.speed.interval(0.68)
    if ends is None and row.falls > 0.0:
        return Speed(f"falls over in {100.0 * row.falls:.0f} % of its runs.", "falls", True)
    if ends is None:
        return Speed("Its speed is not known yet.", "unknown", False)
    if prediction.is_standing(row):
        bounds = "" if row.speed_by == "statics" else f", with bounds {_format_range(*ends)}"
        return Speed(f"stands{bounds}.", "stands", True)
    middle = row.speed.number
    lower, upper = (middle + QUARTILE_RATIO * (end - middle) for end in ends)
    return Speed(
        f"{_format_velocity(middle)}; half of the prints run {_format_range(lower, upper)}.", _direction(middle), True
    )


def _direction(speed: float) -> Kind:
    return "forward" if speed >= 0.0 else "backward"


def _format_velocity(value: float) -> str:
    """Format a speed, mm/s, with its direction in words."""
    if value < 0.0:
        return f"runs backward, about {_format_size(value)} mm/s to the left"
    return f"about {_format_size(value)} mm/s to the right"


def _format_size(value: float) -> str:
    """Format the absolute value of a speed, with one decimal if it is small."""
    return words.format_fixed(abs(value), 0 if abs(value) >= 9.95 else 1)


def _format_range(low: float, high: float) -> str:
    """Format a range of speeds, mm/s. With a negative speed a walker runs to the left."""
    if low >= 0.0:
        return f"between {_format_size(low)} and {_format_size(high)}"
    if high <= 0.0:
        return f"between {_format_size(high)} and {_format_size(low)} to the left"
    return f"between {_format_size(low)} to the left and {_format_size(high)} to the right"


def format_runs(facts: Mapping[str, Any]) -> str:
    """Return a sentence on the simulated speed. `facts`: JSON output of `simulate`."""
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
    """Return an uncertain input's name in words, without its unit. `key`: dotted key of a file, or words."""
    words = re.sub(r" \([^)]*\)$", "", key_names.format_key(key)) if "." in key else key
    return re.sub(r"^(.+?) sd\b", r"deviation of \1", words)


def format_setting(key: str, value: float) -> str:
    """Return an instruction to set a dotted key: its name in words, its value and its unit."""
    return f"Set the {format_name(key)} to {value:g} {key_names.UNITS_BY_SUFFIX.get(_unit_ending(key), '')}".strip()


def format_title(name: str) -> str:
    """Return the plain name of a template followed by its file's name; only the latter if it has no plain name."""
    return f"{TITLES[name]} ({name})" if name in TITLES else name


def to_plain_text(text: str) -> str:
    """Return a message in words for users of the page: keys become names, clauses with a shell flag are dropped."""
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


def _format_key(match: re.Match[str]) -> str:
    """Return the replacement for a matched word: the name in words for a file's key, else the word itself."""
    key = match[0].removeprefix("scene.").removeprefix("printer.")
    if key.isidentifier() and key != match[0]:  # a table, as scene.drive
        return key
    if ("." not in key and "_" not in key) or re.sub(r"\[\d+\]", "", key) not in _file_keys():
        return match[0]
    return format_name(key) if "." in key else key.removesuffix(_unit_ending(key)).replace("_", " ")


def _unit_ending(key: str) -> str:
    """Return the suffix of a key that states its unit, such as "_mm"; "" without one."""
    return next((end for end in key_names.UNITS_BY_SUFFIX if key.endswith(end)), "")


@cache
def _file_keys() -> frozenset[str]:
    """Return all dotted keys of walkers, scenes and printers, and their last parts that contain an underscore."""
    paths = [".".join(path) for model in (Design, Scene, Printer) for path in config.key_paths(model)]
    paths += [f"legs.{name}" for name in Leg.model_fields]
    return frozenset([*paths, *(name for path in paths if "_" in (name := path.rpartition(".")[2]))])
