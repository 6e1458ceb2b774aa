"""Kinds of points, such as a walker alone or a crowd: the module of each kind, imported on first use.

Such a module lists the groups of numbers of its points, their columns in a table, and the numbers
that pictures show. It also evaluates a point. The kind ALONE has several models, each other kind one.
"""

from collections.abc import Sequence
from importlib import import_module
from typing import NamedTuple, Protocol, cast

from walkergen.core.errors import InputError, WalkergenError
from walkergen.core.printing.printers import Printer
from walkergen.points.point import ALONE, PREDICTION, SPACE, Point, Record, refused_record

MODELS = (PREDICTION, SPACE)
"""Models of a walker alone; any other model is a kind of its own."""

KIND_MODULES = {ALONE: "walkergen.points.single_walker", "crowd": "walkergen.guests.crowd.points"}
"""Modules of the kinds."""

ALL_MODELS = (*MODELS, *(kind for kind in KIND_MODULES if kind != ALONE))
"""Models that a point may have."""

KIND_KEY_PREFIXES = {"crowd": "scene.crowd."}
"""Beginnings of keys that apply to one kind only."""


class Picture(NamedTuple):
    """Number of a table that a picture shows, by its columns."""

    name: str
    """Name of the picture's files."""
    value: str
    low: str
    high: str
    """Bounds of 95 %."""
    label: str
    """Name of the number, with its unit."""

    @property
    def name_and_unit(self) -> tuple[str, str]:
        """Name and unit of the number, from its label."""
        name, _, unit = self.label.partition(" (")
        return name, unit.rstrip(")")


class Kind(Protocol):
    """Interface of the module of a kind of points."""

    GROUPS: tuple[str, ...]
    """Groups of numbers that a point can have."""
    KEPT: tuple[str, ...]
    """Groups of a table by default."""
    SCENE: str
    """Default template of the scene."""
    RUNS: int | None
    """Default number of runs; None for that of the scene."""
    MEETS_ERRORS: bool
    """Whether runs may be added until an error is met, or a time is spent."""

    def check(self, keep: Sequence[str], model: str, printer: Printer | None) -> None:
        """Raise InputError if a group of numbers in `keep` is not available for the model or without a printer."""

    def title(self, model: str) -> str:
        """Return words for a table's title that say how the model obtained its numbers."""

    def columns(self, model: str, keep: Sequence[str]) -> tuple[str, ...]:
        """Return the names of the columns of records with the groups in `keep`, without the status."""

    def pictures(self, keep: Sequence[str]) -> tuple[Picture, ...]:
        """Return the numbers of a table with the groups in `keep` that pictures show."""

    def cost(self, point: Point) -> float:
        """Estimate the CPU seconds to evaluate a point. Raises WalkergenError for an invalid point."""

    def evaluate(self, point: Point) -> Record:
        """Return the numbers of a point by column. Raises WalkergenError if it cannot be built or simulated."""


def kind_of(model: str) -> str:
    """Return the kind of points, a key of KIND_MODULES, of a model. Raises InputError for an unknown model."""
    if model not in ALL_MODELS:
        raise InputError(f"‹model=›{model[:30]!r}: must be one of {', '.join(ALL_MODELS)}")
    return ALONE if model in MODELS else model


def kind_of_key(key: str) -> str:
    """Return the kind of points to which a key of scene or design is restricted; "" if it applies to all kinds."""
    return next((kind for kind, start in KIND_KEY_PREFIXES.items() if key.startswith(start)), "")


def load_kind(kind: str) -> Kind:
    """Import the module of a kind. Raises InputError if it is not installed."""
    try:
        return cast(Kind, import_module(KIND_MODULES[kind]))
    except ModuleNotFoundError as error:
        raise InputError(f"‹model=›{kind}: {error.name} is not installed: pip install 'walkergen[{kind}]'") from error


def check(keep: Sequence[str], model: str, printer: Printer | None) -> None:
    """Raise InputError for an unknown model or group of numbers, or a group in `keep` that the model does not have."""
    kind = load_kind(kind_of(model))
    for name in keep:
        if name not in kind.GROUPS:
            raise InputError(f"‹keep=›{name[:30]!r}: must be one of {', '.join(kind.GROUPS)}")
    kind.check(keep, model, printer)


def evaluate(point: Point) -> Record:
    """Return the numbers of a point by column; only status and reason if the point cannot be built or simulated."""
    try:
        return load_kind(point.kind).evaluate(point)
    except WalkergenError as error:
        return refused_record(error)
