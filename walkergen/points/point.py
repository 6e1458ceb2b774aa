"""A point: a design in a scene, what shall be known of it, and its key."""

import functools
import hashlib
import json
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from walkergen.errors import InputError
from walkergen.points.tolerance import Tolerance
from walkergen.printing.printers import Printer
from walkergen.scene import Scene
from walkergen.simulation import experiments
from walkergen.theory import surrogate
from walkergen.walker.design import Design

KEPT = ("speed", "spread", "persistence", "impacts", "masses", "printability")
"""Groups of numbers that a point may be asked for."""

PREDICTION = "prediction"
"""Model of a point that is not simulated: its record's model says by what it is predicted."""

MODELS = (PREDICTION, "rigid", "relaxed", "compliant", "space", "auto")

CROWD = "crowd"
"""Model of a point that is a crowd in space, of as many walkers as its scene says."""

Value = float | int | str | None
Record = dict[str, Value]
"""Numbers of a point by the names of their columns, with units; None where there is none."""

STATUS = "status"
"""Name of the column that says how a point went: OK, or what is wrong with its numbers."""
OK = "ok"


class Point(NamedTuple):
    """Point that can be evaluated, in this process or in another."""

    design: Design
    scene: Scene
    """Scene, with the model and the runs that shall be simulated."""
    simulated: bool = False
    """False for the prediction alone."""
    keep: tuple[str, ...] = ("speed",)
    """Groups of KEPT that shall be known. Without any, a simulated point is its runs alone: its key
    then does not depend on how speeds are predicted."""
    wanted: Tolerance | None = None
    """Error up to which runs are added; None for the runs of the scene."""
    printer: Printer | None = None
    """Printer of the group "printability"."""
    crowd: bool = False
    """True for many walkers that meet. Its numbers are all that crowds have, whatever is kept."""

    @property
    def predicted(self) -> bool:
        """Whether its numbers hold a predicted speed."""
        return bool(self.keep) or not self.simulated


def check(keep: Sequence[str], model: str, printer: Printer | None) -> None:
    """Refuse groups and models that are not known, or do not go together. Raises InputError."""
    if model not in (*MODELS, CROWD):
        every = ", ".join((*MODELS, CROWD))
        raise InputError(f"--model {model[:30]!r}: must be one of {every}")
    groups = kept(model)
    for name in keep:
        if name not in groups:
            raise InputError(f"--keep {name[:30]!r}: must be one of {', '.join(groups)}")
    if model == CROWD:
        return
    for name in ("persistence", "impacts"):
        if name in keep and model == PREDICTION:
            raise InputError(f"--keep {name}: needs a simulation: --model compliant, or space")
    if "persistence" in keep and model not in ("space", "auto"):
        raise InputError(f"--keep persistence: model {model} cannot turn: --model space")
    if "printability" in keep and printer is None:
        raise InputError("--keep printability: needs a printer: --printer prusa-mk3s")


def kept(model: str) -> tuple[str, ...]:
    """Groups of numbers that a model has: of a walker alone KEPT, of a crowd its statistics."""
    if model != CROWD:
        return KEPT
    from walkergen.crowd.statistics.measuring import UNITS

    return tuple(UNITS)


def key(point: Point) -> str:
    """Hash of all that a point's numbers depend on, the program's sources too, 32 digits."""
    printer = point.printer.model_dump(exclude={"name", "description"}) if point.printer else None
    table = [point.scene.prediction.model_dump(), *surrogate.digests(point.scene)]
    facts = [
        *experiments.facts(point.scene, point.design),
        *(table if point.predicted else []),
        point.simulated,
        sorted(point.keep),
        point.wanted,
        printer,
        point.crowd,
        digest(),
    ]
    return hashlib.sha256(json.dumps(facts, sort_keys=True).encode()).hexdigest()[:32]


@functools.cache
def digest() -> str:
    """Hash of the program's sources that numbers come from, 16 hexadecimal digits.

    Pictures, commands and jobs do not count: they change no number of a point.
    """
    package, hasher = Path(__file__).parent.parent, hashlib.sha256()
    counted = (
        "*.py",
        "analysis/*.py",
        "crowd/**/*.py",
        "points/*.py",
        "numerics/*.py",
        "printing/*.py",
        "shapes/*.py",
        "simulation/**/*.py",
        "theory/*.py",
        "walker/*.py",
    )
    for source in sorted(path for pattern in counted for path in package.glob(pattern)):
        hasher.update(source.read_bytes())
    return hasher.hexdigest()[:16]
