"""A point: a design in a scene, the requested numbers, and its key."""

import functools
import hashlib
import json
from enum import StrEnum
from pathlib import Path
from typing import NamedTuple

from walkergen.core.errors import WalkergenError
from walkergen.core.printing.printers import Printer
from walkergen.core.scene import Scene
from walkergen.core.theory import networks
from walkergen.core.tolerance import Tolerance
from walkergen.core.walker.design import Design
from walkergen.points import experiments

ALONE = "alone"
"""Kind of a point that is one walker alone."""

PREDICTION, SPACE = "prediction", "space"
"""Models of a point that is predicted, whose record names the source of its speed, and of one that is simulated."""

Value = float | int | str | None
Record = dict[str, Value]
"""Numbers of a point by the names of their columns, with units; None for a missing one."""


class PointStatus(StrEnum):
    """Outcome of the evaluation of a point."""

    OK = "ok"
    REFUSED = "refused"
    """The point cannot be built, or simulated."""
    NO_SPEED = "no speed"
    RUNS_ENDED_BADLY = "some runs ended badly"
    WALKERS_ENDED_BADLY = "some walkers ended badly"
    UNBALANCED = "energy error"
    NOT_MET = "error not met"
    """The error of its speed is larger than requested, or unknown."""


WENT_KEY, STATUS_KEY, REASON_KEY = "went", "status", "reason"
"""Keys of a record in addition to its numbers: the outcome, its text for the table, and the reason of a refusal."""


class Point(NamedTuple):
    """Point that can be evaluated, in this process or in another."""

    design: Design
    scene: Scene
    """Scene, with the runs to simulate."""
    simulated: bool = False
    """True to simulate it; False for the prediction alone."""
    keep: tuple[str, ...] = ("speed",)
    """Requested groups of numbers. Without any, a simulated point has only the numbers of its runs: its key
    then does not depend on how speeds are predicted."""
    wanted: Tolerance | None = None
    """Requested error that ends the adding of runs; None for the runs of the scene."""
    printer: Printer | None = None
    """Printer of the group "printability"."""
    kind: str = ALONE
    """Kind of the experiment, of `model_kinds.KIND_MODULES`. Any but ALONE has all numbers, regardless of `keep`."""

    @property
    def predicted(self) -> bool:
        """Whether the point's numbers include a predicted speed."""
        return bool(self.keep) or not self.simulated


def status_record(status: PointStatus, text: str = "") -> Record:
    """Return the entries of a record for a point's status and its text for the table, by default the status itself."""
    return {WENT_KEY: status, STATUS_KEY: text or status.value}


def refused_record(error: WalkergenError) -> Record:
    """Return the record of a point that cannot be built or simulated: only status and reason."""
    reason = " ".join(error.text.split())[:300]
    return status_record(PointStatus.REFUSED, f"{PointStatus.REFUSED}: {reason}") | {REASON_KEY: reason}


def point_key(point: Point) -> str:
    """Return a hash of all inputs of a point's numbers and of the program's sources, 32 hexadecimal digits."""
    printer = point.printer.model_dump(exclude={"name", "description"}) if point.printer else None
    prediction_facts = [point.scene.prediction.model_dump(), networks.digest()]
    facts = [
        *experiments.key_facts(point.scene, point.design),
        *(prediction_facts if point.predicted else []),
        point.simulated,
        sorted(point.keep),
        point.wanted,
        printer,
        point.kind,
        digest(),
    ]
    return hashlib.sha256(json.dumps(facts, sort_keys=True).encode()).hexdigest()[:32]


@functools.cache
def digest() -> str:
    """Return a hash of the program's sources that compute points: 16 hexadecimal digits.

    Sources of pictures and commands are left out: they change no number of a point.
    """
    package, hasher = Path(__file__).parent.parent, hashlib.sha256()
    counted = ("*.py", "analysis/*.py", "core/**/*.py", "guests/crowd/**/*.py", "points/*.py", "readers/**/*.py")
    for source in sorted(path for pattern in counted for path in package.glob(pattern)):
        hasher.update(source.read_bytes())
    return hasher.hexdigest()[:16]
