"""Commands: the heading of each in the help, the module of its request, and examples.

It also defines the spelling of fields in texts for commands and for Python: --mm-per-px and mm_per_px.
"""

import re
from collections.abc import Mapping
from importlib import import_module
from inspect import getdoc
from typing import Any, NamedTuple

from walkergen.core.errors import COMMAND_LINE_SOURCE, FIELD_PATTERN, spell_for_python


class Command(NamedTuple):
    """Command NAME, made of `NameRequest` in `request.py` of a folder; so is the function of Python, `wg.NAME`."""

    heading: str
    folder: str
    """Folder below walkergen, dotted; "" of `templates`, which has commands below it."""
    example: str
    """Words after `walkergen`; files in them are the user's own."""
    other: str
    """Words of a second example."""


COMMANDS = {
    "app": Command("Design", "app", "app", "app my.toml --port 0"),
    "family": Command("Make", "commands.family", "family --page", "family maker-large --tilt 5:20:5 --copies 4"),
    "export": Command(
        "Make", "commands.export", "export --tilt 12 --format stl,3mf", "export my.toml --tilt 10 --format mjcf"
    ),
    "check": Command("Make", "commands.check", "check my.toml --tilt 5,10 --printer ender3", "check part.stl"),
    "plate": Command(
        "Make", "commands.plate", "plate --tilt 5,10,15 --copies 8", "plate --orders orders.csv --how-many"
    ),
    "predict": Command(
        "Predict", "commands.predict", "predict --tilt 5:30:5", "predict my.toml --tilt 10 --weights weights.csv"
    ),
    "sweep": Command(
        "Predict",
        "guests.sweep",
        "sweep --set legs.tilt_deg=0:40:2",
        "sweep --set legs.tilt_deg=2:40:1 --set legs.flexible_thickness_mm=0.4,0.5 --wish 40",
    ),
    "simulate": Command("Simulate", "commands.simulate", "simulate --tilt 10", "simulate --tilt 10 --error 5%"),
    "crowd": Command(
        "Simulate", "guests.crowd", "crowd --count 30 --arena disc:120 --seconds 20", "crowd koumakis2016 --card"
    ),
    "movie": Command("Simulate", "guests.movie", "movie --tilt 10", "movie --tilt 5,10,15 --scene plane-90hz"),
    "explain": Command("Simulate", "commands.explain", "explain --tilt 10", "explain --scene plane-noisy --no-cost"),
    "track": Command(
        "Measure",
        "guests.track.film",
        "track film.mp4 --mm-per-px 0.1",
        "track film.mp4 --length 28 --heading mark --fps 240",
    ),
    "analyse": Command(
        "Measure",
        "guests.track.analyse",
        "analyse film.csv --fps 50 --mm-per-px 0.1",
        "analyse first.csv --run second.csv --dish disc:120 --body 24x8",
    ),
    "fit": Command("Measure", "guests.lab.fit", "fit speeds.csv", "fit speeds.csv --predict 8,12"),
    "calibrate": Command(
        "Measure",
        "guests.lab.calibrate",
        "calibrate plate --printer ender3",
        "calibrate drop --measured 0.5 --measured-sd 0.02 --tries 10",
    ),
    "accuracy": Command("Trust", "commands.accuracy", "accuracy --tilt 10", "accuracy --tilt 10 --budget 2min"),
    "selftest": Command("Trust", "commands.selftest", "selftest", "selftest --only 6.4"),
    "templates": Command("Files", "", "templates", "templates copy koumakis2016 my.toml"),
}
"""Commands by their names, in the order of the help."""


def load_request(name: str) -> Any:
    """Import and return the request class of a command, a subclass of `walkergen.request.Request`."""
    module = import_module(f"walkergen.{COMMANDS[name].folder}.request")
    return getattr(module, f"{name.capitalize()}Request")


def split_docstring(request: type) -> tuple[str, str]:
    """Split a request's docstring into its text, for the command's help, and its numpydoc sections."""
    text, *sections = re.split(r"\n\n(?=[A-Z][a-z]+\n---)", str(getdoc(request)))
    return text, "\n\n".join(sections)


KEY_PATTERN = re.compile(rf"{COMMAND_LINE_SOURCE}: ([\w.]+) = ")


def for_shell(text: str, names: Mapping[str, str] | None = None) -> str:
    """Replace fields such as ‹mm_per_px=› in a text by flags such as --mm-per-px.

    `names`: flags that are not the field's name with dashes, by field.
    """

    def replacement(match: re.Match[str]) -> str:
        name, value = match.groups()
        if value == "=False":
            return f"--no-{name.replace('_', '-')}"
        return (names or {}).get(name, f"--{name.replace('_', '-')}") + (" " if value else "")

    return FIELD_PATTERN.sub(replacement, text.replace(COMMAND_LINE_SOURCE, COMMAND_LINE_SOURCE[1:-1]))  # without ‹›


def for_call(text: str, sets: Mapping[str, str]) -> str:
    """Replace fields such as ‹mm_per_px=› in a text by Python arguments.

    `sets`: names of given arguments by the key that they set. In the text they replace the key.
    """
    return spell_for_python(
        KEY_PATTERN.sub(lambda found: f"‹{sets[found[1]]}=›" if found[1] in sets else found[0], text)
    )
