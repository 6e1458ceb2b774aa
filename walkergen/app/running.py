"""Child of the server that simulates a walker: a first number soon, a run to be played, then all that was asked for."""

import contextlib
import sys
import time
from typing import TYPE_CHECKING, Any

from walkergen.app import children, sentences
from walkergen.app.document import SOURCE, Document
from walkergen.errors import WalkergenError

if TYPE_CHECKING:
    from walkergen.scene import Scene
    from walkergen.walker.design import Design

FIRST_S, FIRST_RUNS = 1.0, 4
"""Length (s) and number of the runs that give the first number."""

PLAYED_S = 3.0
"""Length of the run that is played, s."""

PAUSE_S = 0.2
"""Time between two events that say how far it is, s."""


def main() -> int:
    """Simulate the document that the server sent, in `short` only the first number; returns the exit code."""
    sent = children.listen()
    document = Document(**sent["document"])
    try:
        _simulate(document.design(), document.ground(), bool(sent["short"]))
    except WalkergenError as error:
        for line in str(error).splitlines():
            print(f"error: {line.removeprefix(f'{SOURCE}: ')}", file=sys.stderr)
        return 2
    return 0


def _simulate(design: "Design", scene: "Scene", short: bool) -> None:
    from walkergen.jobs.make.family import play

    run = scene.run
    seconds, runs = min(FIRST_S, run.seconds), min(FIRST_RUNS, run.runs)
    if short or run.seconds * run.runs > 2.0 * seconds * runs:
        few = run.model_copy(update={"seconds": seconds, "runs": runs})
        children.say(_measured(design, scene.model_copy(update={"run": few})) | {"first": True})
    if short:
        return
    with contextlib.suppress(WalkergenError):  # it moves in a plane, or falls at once, which the runs tell
        children.say({"played": play.run(design, scene, seconds=PLAYED_S)})
    children.say(_measured(design, scene) | {"first": False})


def _measured(design: "Design", scene: "Scene") -> dict[str, Any]:
    """What `simulate` says of a walker, and in a sentence."""
    from walkergen.jobs.run.simulate import make, report
    from walkergen.walker import solids

    said = 0.0

    def tell(what: str, done: int, total: int) -> None:
        nonlocal said
        if time.monotonic() - said > PAUSE_S:
            said = time.monotonic()
            children.say({"progress": [what, done, total]})

    facts = report.of(make.measure(make.asked(scene, design, solids.mass_of(design)), tell)).facts
    return {"facts": facts, "text": sentences.run(facts)}


if __name__ == "__main__":
    sys.exit(main())
