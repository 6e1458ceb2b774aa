"""What a page says in words for people who click: speeds in a sentence, no keys of files, no flags of a shell."""

import re
from collections.abc import Mapping
from functools import cache
from typing import Any, Literal, NamedTuple

from walkergen.core.files import config, words
from walkergen.core.printing.printers import Printer
from walkergen.core.scene import Scene
from walkergen.core.theory import prediction
from walkergen.core.theory.prediction import Prediction
from walkergen.core.walker.design import Design
from walkergen.core.walker.limbs import Leg
from walkergen.files import key_names

QUARTILE = 0.6745
"""Distance of the quartiles of a normal distribution from its middle, over that of the ends of 68 %."""

TITLES: Mapping[str, str] = {
    "koumakis2016": "the paper's walker",
    "name": "a name",
    "maker-large": "twice as large",
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
"""Plain names of walkers and scenes, by those of their files."""

MENUS: Mapping[str, str] = {
    'wall_generator = "classic"': "the perimeter generator (wall generator in Orca and Bambu) Classic",
    "set thin_walls = true": "switch on “Detect thin walls”",
    "thin_walls = true": "“Detect thin walls” on",
    "set brim_width_mm": "give it a brim",
    "turn the mesh by body.up": "choose another axis that points up",
}
"""What the menus of slicers and the page's form call settings that messages name by their keys."""

Kind = Literal["forward", "backward", "stands", "falls", "unknown"]


class Speed(NamedTuple):
    """Speed of a walker in a sentence."""

    text: str
    kind: Kind
    sure: bool
    """False where a run has yet to tell it."""


def speed(row: Prediction) -> Speed:
    """Speed of a prediction: its median, and what half of the prints do.

    The quartiles follow from the ends of 68 %, to either side as of a normal distribution.
    """
    middle, low, high = row.speed_mm_s, row.speed_low_68_mm_s, row.speed_high_68_mm_s
    if middle is None and row.falls > 0.0:
        return Speed(f"falls over in {100.0 * row.falls:.0f} % of its runs.", "falls", True)
    if middle is None or low is None or high is None:
        return Speed("Runs of seconds tell how fast.", "unknown", False)
    if prediction.stands(row):
        bounds = "" if row.speed_by == "statics" else f", as far as can be told: {_between(low, high)}"
        return Speed(f"stands{bounds}.", "stands", True)
    quarter, most = (middle + QUARTILE * (end - middle) for end in (low, high))
    return Speed(f"{_ahead(middle)}; half of the prints run {_between(quarter, most)}.", _kind(middle), True)


def _kind(value: float) -> Kind:
    return "forward" if value >= 0.0 else "backward"


def _ahead(value: float) -> str:
    if value < 0.0:
        return f"runs backward, about {_size(value)} mm/s to the left"
    return f"about {_size(value)} mm/s to the right"


def _size(value: float) -> str:
    return words.fixed(abs(value), 0 if abs(value) >= 9.95 else 1)


def _between(low: float, high: float) -> str:
    """Format a range of speeds; those below zero are to the left."""
    if low >= 0.0:
        return f"between {_size(low)} and {_size(high)}"
    if high <= 0.0:
        return f"between {_size(high)} and {_size(low)} to the left"
    return f"between {_size(low)} to the left and {_size(high)} to the right"


def run(facts: Mapping[str, Any]) -> str:
    """Describe the runs of a walker in a sentence, from the facts of `simulate`."""
    value, error = facts["speed_mm_s"], facts["speed_se_mm_s"]
    if value is None:
        return "It came to no end that has a speed."
    low, high = facts["speed_low_95_mm_s"], facts["speed_high_95_mm_s"]
    way = "to the right" if value >= 0.0 else "to the left, backward"
    told = words.with_error(abs(value), error) if error else _size(value)
    bounds = "" if low is None or high is None else f"; with the error of the simulator {_between(low, high)} (95 %)"
    return f"As drawn it ran {told} mm/s {way}{bounds}."


def name(key: str) -> str:
    """Return the name of an unknown input without its unit; `key` is its key, or words."""
    words = re.sub(r" \([^)]*\)$", "", key_names.label(key)) if "." in key else key
    return re.sub(r"^(.+?) sd\b", r"deviation of \1", words)


def setting(key: str, value: float) -> str:
    """Value of a key of a walker or, after "printer.", of the printer, in words."""
    return f"{name(key)}: {value:g} {key_names.UNITS.get(_ending(key), '')}".strip()


def title(name: str) -> str:
    """Plain name of a template beside its own, or the name."""
    return f"{TITLES[name]} ({name})" if name in TITLES else name


def plain(text: str) -> str:
    """Text without keys of files and flags of a shell: keys in words, clauses with a flag left out."""
    clauses = re.split(r"(?<=[;:,.]) ", text)
    kept = [clause for clause in clauses if not re.search(r"(?<![\w-])--?[a-z][\w-]+|[`‹]|walkergen ", clause)]
    text = re.sub(r"[;:,]$", "", " ".join(kept or clauses))
    for key, menu in MENUS.items():
        text = text.replace(key, menu)
    text = re.sub(r"(?<!\w)\[{1,2}([a-z_]+)\]{1,2}", r"\1", text)  # tables
    text = re.sub(r">= (\S+) and <= (\S+)", r"between \1 and \2", text)
    text = re.sub(r"([\w.\[\]]+) = (true|false)\b", lambda key: f"{key[1]}: {_yes(key[2])}", text)
    return re.sub(r"[A-Za-z_]\w*(?:\[\d+\])?(?:\.[A-Za-z_]\w*(?:\[\d+\])?)*", _in_words, text)


def _yes(word: str) -> str:
    return "yes" if word == "true" else "no"


def _in_words(key: re.Match[str]) -> str:
    """Key in words without its unit; other words as they are."""
    known = key[0].removeprefix("scene.").removeprefix("printer.")
    if known.isidentifier() and known != key[0]:  # a table
        return known
    if ("." not in known and "_" not in known) or re.sub(r"\[\d+\]", "", known) not in _keys():
        return key[0]
    return name(known) if "." in known else known.removesuffix(_ending(known)).replace("_", " ")


def _ending(key: str) -> str:
    return next((end for end in key_names.UNITS if key.endswith(end)), "")


@cache
def _keys() -> frozenset[str]:
    """All keys of files, and their last names where these are more than a word."""
    paths = [".".join(path) for model in (Design, Scene, Printer) for path in config.keys(model)]
    paths += [f"legs.{name}" for name in Leg.model_fields]
    return frozenset([*paths, *(name for path in paths if "_" in (name := path.rpartition(".")[2]))])
