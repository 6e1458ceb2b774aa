"""Child process of the server that simulates a walker, for its prediction or with all runs of its scene.

A prediction takes runs of seconds. Before all runs come a first number and a run to be played.
"""

import contextlib
import sys
import time
from typing import TYPE_CHECKING, Any

from walkergen.app import children, sentences
from walkergen.app.document import SOURCE, Document
from walkergen.command_table import for_shell
from walkergen.core.errors import WalkergenError
from walkergen.core.files.progress import stretch

if TYPE_CHECKING:
    from walkergen.core.files.progress import Progress
    from walkergen.core.scene import Scene
    from walkergen.core.walker.design import Design

FIRST_S, FIRST_RUNS = 1.0, 4
"""Length (s) and number of the runs that give the first number."""

PLAYED_S = 3.0
"""Length of the run that is played, s."""

PAUSE_S = 0.2
"""Time between two events that say how far it is, s."""


def main() -> int:
    """Simulate the document that the server sent, `short` only what its prediction needs; returns the exit code."""
    sent = children.listen()
    document = Document(**sent["document"])
    try:
        if sent["short"]:
            _predict(document.design(), document.ground())
        else:
            _simulate(document.design(), document.ground())
    except WalkergenError as error:
        for line in for_shell(error.text).splitlines():
            print(f"error: {line.removeprefix(f'{SOURCE}: ')}", file=sys.stderr)
        return 2
    return 0


def _predict(design: "Design", scene: "Scene") -> None:
    """Predict a walker that nothing knows without runs, which the store then has for whoever asks again."""
    from walkergen.commands.predict import make

    make.predict(design, [design], scene, "coulomb", progress=_teller())
    children.say({"predicted": True})


def _simulate(design: "Design", scene: "Scene") -> None:
    from walkergen.guests.movie import play

    run, tell = scene.run, _teller()
    seconds, runs = min(FIRST_S, run.seconds), min(FIRST_RUNS, run.runs)
    before, rest = seconds * runs, run.seconds * run.runs  # simulated time of both, by which one bar grows
    if not rest > 2.0 * before:
        before = 0.0
    shares = before / (before + PLAYED_S + rest), (before + PLAYED_S) / (before + PLAYED_S + rest)
    if before:
        few = run.model_copy(update={"seconds": seconds, "runs": runs})
        first = scene.model_copy(update={"run": few})
        children.say(_measured(design, first, stretch(tell, 0.0, shares[0])) | {"first": True})
    with contextlib.suppress(WalkergenError):  # it moves in a plane, or falls at once, which the runs tell
        children.say({"played": play.run(design, scene, PLAYED_S)})
    children.say(_measured(design, scene, stretch(tell, shares[1], 1.0)) | {"first": False})


def _measured(design: "Design", scene: "Scene", progress: "Progress") -> dict[str, Any]:
    """Simulate a walker, and return the facts of `simulate` with a sentence."""
    from walkergen.commands.simulate import make, report
    from walkergen.core.walker import solids

    facts = report.of(make.measure(make.asked(scene, design, solids.mass_of(design)), progress)).facts
    return {"facts": facts, "text": sentences.run(facts)}


def _teller() -> "Progress":
    """Progress that the page hears of, not too often."""
    said = 0.0

    def tell(what: str, done: int, total: int) -> None:
        nonlocal said
        if time.monotonic() - said > PAUSE_S:
            said = time.monotonic()
            children.say({"progress": [what, done, total]})

    return tell


if __name__ == "__main__":
    sys.exit(main())
