"""Designs, scenes and printers as a command line asks for them: files, with keys set anew.

Whatever sets a key goes one way: a flag of its own (--gamma) and --set scene.drive.gamma=2 both
become a dotted key with a value, and the file is read as if that stood in it.
"""

import sys
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from walkergen.cli import variants
from walkergen.errors import InputError
from walkergen.files.key_names import KINDS, TILTS

if TYPE_CHECKING:
    from pathlib import Path

    from walkergen.files.config import Model
    from walkergen.printing.printers import Printer
    from walkergen.scene import Scene
    from walkergen.theory.speed import Mode
    from walkergen.walker.design import Design
    from walkergen.walker.weights import Weighings

FLAGS = {
    "restitution": "scene.contact.restitution",
    "friction": "scene.contact.friction",
    "law": "scene.contact.law",
    "gamma": "scene.drive.gamma",
    "frequency": "scene.drive.frequency_hz",
    "seconds": "scene.run.seconds",
    "runs": "scene.run.runs",
    "seed": "scene.run.seed",
    "step": "scene.run.step_us",
    "model": "scene.legs.model",
    "count": "scene.crowd.count",
    "packing": "scene.crowd.packing",
    "arena": "scene.crowd.arena_mm",
}
"""Keys that flags set, by the flags' names."""

FAMILY_TILTS, FAMILY_KINDS = ("family.tilt_deg",), ("family.legs",)
"""Keys of a design that --tilt and --legs set of a whole family."""


class Inputs(NamedTuple):
    """Values that a command line gives to keys of files."""

    values: Mapping[str, Any]
    """Values by dotted keys; those of a scene and a printer begin with these words."""
    flags: Mapping[str, str]
    """Names of the flags that gave them, by key."""

    def design(self, name: str) -> "Design":
        """Load the design with a template's name or at a file's path."""
        from walkergen.walker.design import Design

        return self._read(name, "walkers", Design, "design")

    def scene(self, name: str, **otherwise: Any) -> "Scene":
        """Load the scene with a template's name or at a file's path.

        What a command has of its own for a flag, `otherwise`, holds where the command line does not
        set it.
        """
        from walkergen.scene import Scene

        own = {FLAGS[flag]: value for flag, value in otherwise.items()}
        own = {key: value for key, value in own.items() if not _set_by(self.values, key)}
        return self._replace(values={**self.values, **own})._read(name, "scenes", Scene, "scene")

    def printer(self, name: str) -> "Printer":
        """Load the printer with a template's name or at a file's path."""
        from walkergen.printing.printers import Printer

        return self._read(name, "printers", Printer, "printer")

    def printers(self, text: str) -> "list[Printer]":
        """Load the printers of a comma-separated list. Raises InputError for a repeated name."""
        printers = [self.printer(name.strip()) for name in text.split(",")]
        names = [printer.name for printer in printers]
        for name in names:
            if names.count(name) > 1:
                raise InputError(f"--printer {text[:60]!r}: two printers are called {name}")
        return printers

    def _read(self, name: str, kind: str, model: "type[Model]", what: str) -> "Model":
        """Read the file of a thing with the values of its keys."""
        from walkergen.files import assignments, templates

        prefix = "" if what == "design" else f"{what}."
        own = {key.removeprefix(prefix): self.values[key] for key in self.of(what)}
        path = templates.path_of(name, kind)
        return assignments.read(path, model, own, "command line", prefix)

    def of(self, what: str) -> list[str]:
        """Keys of a design, a scene or a printer that are set."""
        return [key for key in self.values if _thing(key) == what]

    def one(self, name: str, tilt: float | None, legs: str | None) -> "Design":
        """Load the single walker of --tilt and --legs. Raises InputError for two kinds."""
        self._refuse_twice(tilt, legs, whole=False)
        return variants.one_of(self.design(name), tilt, legs)

    def members(self, design: "Design", tilt: str | None, legs: str | None, whole: bool) -> "list[Design]":
        """List the variants of --tilt and --legs, as `variants.members_of` does."""
        self._refuse_twice(tilt, legs, whole)
        return variants.members_of(design, tilt, legs, whole)

    def batch(
        self, design: "Design", tilt: str | None, legs: str | None, copies: str | None, whole: bool
    ) -> "tuple[list[Design], list[int]]":
        """List the variants of --tilt and --legs, and the copies of each, as `variants.batch_of`
        does.
        """
        self._refuse_twice(tilt, legs, whole)
        if copies is not None and ":" in copies:
            self.refuse(TILTS + FAMILY_TILTS, "--copies names the tilts: leave one of them out")
        return variants.batch_of(design, tilt, legs, copies, whole)

    def _refuse_twice(self, tilt: object, legs: object, whole: bool) -> None:
        """Refuse keys that --tilt and --legs set too, and of a family those that it replaces."""
        if whole:
            advice = "a family has the tilts of family.tilt_deg: --tilt 12, or --set"
            self.refuse(TILTS, f"{advice} 'family.tilt_deg=[12]'")
            advice = "a family has the kinds of family.legs: --legs braced, or --set"
            self.refuse(KINDS, f"{advice} 'family.legs=[\"braced\"]'")
        for flag, value, keys in (
            ("--tilt", tilt, FAMILY_TILTS if whole else TILTS),
            ("--legs", legs, FAMILY_KINDS if whole else KINDS),
        ):
            if value is not None:
                self.refuse(keys, f"{flag} {value} sets it too: leave one of them out")

    def refuse(self, keys: Sequence[str], why: str) -> None:
        """Raise InputError for the first of some keys that is set."""
        for key in keys:
            if words := _set_by(self.values, key):
                raise InputError(f"{self.flags[words]}: {why}")


def inputs(texts: Sequence[str] | None, things: str, **flags: Any) -> Inputs:
    """Values by --set, of KEY=VALUE each, and by flags of their own, of which None gives none.

    `things` are those whose keys a command takes: some of design, scene, printer. Raises InputError
    for keys of others, for a key with two values, and for one within another.
    """
    from walkergen.files import assignments

    values: dict[str, Any] = {}
    names: dict[str, str] = {}
    for flag, value in flags.items():
        if value is not None:
            values[FLAGS[flag]], names[FLAGS[flag]] = value, f"--{flag} {value}"
    for text in texts or ():
        key, word = assignments.split(text)
        if _thing(key) not in things.split():
            raise InputError(
                f"--set {key[:60]}: this command takes no {_thing(key)}; "
                f"it has keys of the {' and the '.join(things.split())}"
            )
        told, value = f"--set {text[:60]!r}", assignments.value_of(word)
        for other, name in names.items():
            same = other == key and name.startswith("--set") and repr(values[key]) == repr(value)
            if not same and (other == key or _within(key, other) or _within(other, key)):
                raise InputError(f"{told}: {name} sets it too: leave one of them out")
        values[key], names[key] = value, told
    return Inputs(values, names)


def _thing(key: str) -> str:
    """Thing that a key belongs to: design, scene or printer."""
    first, dot, _ = key.partition(".")
    return first if dot and first in ("scene", "printer") else "design"


def _within(key: str, table: str) -> bool:
    """True for a key in a table, or in an entry of a list."""
    return key.startswith((f"{table}.", f"{table}["))


def _set_by(values: Mapping[str, Any], key: str) -> str:
    """Key that sets a key: itself, or a table given as a whole that has it; "" for none."""
    for other, value in values.items():
        rest = key.removeprefix(f"{other}.")
        inside = isinstance(value, Mapping) and rest != key and rest in value
        if other == key or inside:
            return other
    return ""


def weighed(path: "Path | None", members: "Sequence[Design]", quiet: bool) -> "dict[str, Weighings]":
    """Read masses of members from a balance; name other walkers' rows on the error stream."""
    if path is None:
        return {}
    from walkergen.walker import weights

    weighings, unused = weights.read(path, members), weights.unused(path, members)
    if unused and not quiet:
        few = ", ".join(unused[:2]) + (" ..." if len(unused) > 2 else "")
        print(f"{path}: {len(unused)} walkers beside those asked for: {few}", file=sys.stderr)
    return weighings


def mode_of(mode: str, scene: "Scene") -> "Mode":
    """Check a mode's name. Raises InputError; so does mode paper unless the law is Poisson's."""
    from walkergen.theory.speed import MODES

    if mode not in MODES:
        raise InputError(f"--mode {mode!r}: must be one of {', '.join(MODES)}")
    if mode == "paper" and scene.contact.law != "poisson":
        raise InputError(
            f"--mode paper (eq. 15) is derived for law poisson only, seen {scene.contact.law}: use --mode coulomb"
        )
    return mode
