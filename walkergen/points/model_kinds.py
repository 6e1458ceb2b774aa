"""Kinds of experiments that points may be: which module knows each, imported when it is asked for.

Such a module says which groups of numbers its points have, in which columns of a table, and which of
them pictures show; and it evaluates a point. `alone` is of a walker alone, by any model of it.
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
"""Beginnings of keys that say something of one kind only."""


class Picture(NamedTuple):
    """Number of a table that a picture shows, by its columns."""

    name: str
    """Name of the picture's files."""
    value: str
    low: str
    high: str
    """Bounds of 95 %."""
    label: str
    """Number in words, with its unit."""


class Kind(Protocol):
    """Module of a kind."""

    GROUPS: tuple[str, ...]
    """Groups of numbers that a point may be asked for."""
    KEPT: tuple[str, ...]
    """Those of a table unless others are asked for."""
    SCENE: str
    """Template of the scene where none is named."""
    RUNS: int | None
    """Number of runs unless it is set; None for that of the scene."""
    MEETS_ERRORS: bool
    """Whether runs may be added until an error is met, or a time is spent."""

    def check(self, keep: Sequence[str], model: str, printer: Printer | None) -> None:
        """Refuse groups that do not go with a model. Raises InputError."""

    def title(self, model: str) -> str:
        """By what the numbers come, in words."""

    def columns(self, model: str, keep: Sequence[str]) -> tuple[str, ...]:
        """Columns of records that keep these groups, without the status."""

    def pictures(self, keep: Sequence[str]) -> tuple[Picture, ...]:
        """Return the pictures of a table."""

    def cost(self, point: Point) -> float:
        """CPU seconds that a point takes, found out in less. Raises WalkergenError for one that cannot be built."""

    def evaluate(self, point: Point) -> Record:
        """Numbers of a point. Raises WalkergenError for one that cannot be built, or simulated."""


def kind_of(model: str) -> str:
    """Kind of the points of a model. Raises InputError for a model that is not known."""
    if model not in ALL_MODELS:
        raise InputError(f"‹model=›{model[:30]!r}: must be one of {', '.join(ALL_MODELS)}")
    return ALONE if model in MODELS else model


def kind_of_key(key: str) -> str:
    """Kind that a key says something of alone; "" for one that all kinds read."""
    return next((kind for kind, start in KIND_KEY_PREFIXES.items() if key.startswith(start)), "")


def load_kind(kind: str) -> Kind:
    """Import the module of a kind. Raises InputError if it is not installed."""
    try:
        return cast(Kind, import_module(KIND_MODULES[kind]))
    except ModuleNotFoundError as error:
        raise InputError(f"‹model=›{kind}: {error.name} is not installed: pip install 'walkergen[{kind}]'") from error


def check(keep: Sequence[str], model: str, printer: Printer | None) -> None:
    """Refuse groups and models that are not known, or do not go together. Raises InputError."""
    kind = load_kind(kind_of(model))
    for name in keep:
        if name not in kind.GROUPS:
            raise InputError(f"‹keep=›{name[:30]!r}: must be one of {', '.join(kind.GROUPS)}")
    kind.check(keep, model, printer)


def evaluate(point: Point) -> Record:
    """Numbers of a point; one that cannot be built, or simulated, says so in its status."""
    try:
        return load_kind(point.kind).evaluate(point)
    except WalkergenError as error:
        return refused_record(error)
