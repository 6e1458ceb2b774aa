"""Child process of the server that simulates a walker: short runs for a prediction, or all runs of its scene.

Before all runs it sends a first estimate, and one run for playback.
"""

import contextlib
import sys
from typing import TYPE_CHECKING, Any

from walkergen.app import child_processes, sentences
from walkergen.app.document import SOURCE, Document
from walkergen.command_table import for_shell
from walkergen.core.errors import WalkergenError
from walkergen.core.files.progress import range_progress

if TYPE_CHECKING:
    from walkergen.core.files.progress import Progress
    from walkergen.core.scene import Scene
    from walkergen.core.walker.design import Design

FIRST_S, FIRST_RUNS = 1.0, 4
"""Length (s) and number of the runs of the first estimate."""

PLAYBACK_S = 3.0
"""Length of the run for playback, s."""


def main() -> int:
    """Simulate the walker in the document that the server sent, or only predict its speed. Return the exit code."""
    sent = child_processes.receive_and_watch_server()
    document = Document(**sent["document"])
    try:
        if sent["short"]:
            _predict(document.load_design(), document.load_scene())
        else:
            _simulate(document.load_design(), document.load_scene())
    except WalkergenError as error:
        for line in for_shell(error.text).splitlines():
            print(f"error: {line.removeprefix(f'{SOURCE}: ')}", file=sys.stderr)
        return 2
    return 0


def _predict(design: "Design", scene: "Scene") -> None:
    """Predict a walker with short runs, cache its speed for later requests, and send the event "predicted"."""
    from walkergen.commands.predict import make

    make.predict(design, [design], scene, "coulomb", progress=child_processes.progress_sender())
    child_processes.send_event({"predicted": True})


def _simulate(design: "Design", scene: "Scene") -> None:
    """Send the server a first estimate from short runs, a run for playback, and the result of all runs."""
    from walkergen.guests.movie import viewer_run

    run, progress = scene.run, child_processes.progress_sender()
    seconds, runs = min(FIRST_S, run.seconds), min(FIRST_RUNS, run.runs)
    first_s, all_s = seconds * runs, run.seconds * run.runs  # simulated time of both, for one common progress bar
    if not all_s > 2.0 * first_s:
        first_s = 0.0
    shares = first_s / (first_s + PLAYBACK_S + all_s), (first_s + PLAYBACK_S) / (first_s + PLAYBACK_S + all_s)
    if first_s:
        first_run = run.model_copy(update={"seconds": seconds, "runs": runs})
        first_scene = scene.model_copy(update={"run": first_run})
        child_processes.send_event(
            _measure_walker(design, first_scene, range_progress(progress, 0.0, shares[0])) | {"first": True}
        )
    with contextlib.suppress(WalkergenError):  # no playback in a plane or after an immediate fall: the runs report it
        child_processes.send_event({"played": viewer_run.record_run(design, scene, PLAYBACK_S)})
    child_processes.send_event(
        _measure_walker(design, scene, range_progress(progress, shares[1], 1.0)) | {"first": False}
    )


def _measure_walker(design: "Design", scene: "Scene", progress: "Progress") -> dict[str, Any]:
    """Simulate a walker. Return the JSON output of `simulate` as `facts`, and a sentence on its speed as `text`."""
    from walkergen.commands.simulate import make, report
    from walkergen.core.walker import solids

    facts = report.make_report(make.measure(make.make_walker(scene, design, solids.mass_of(design)), progress)).facts
    return {"facts": facts, "text": sentences.format_runs(facts)}


if __name__ == "__main__":
    sys.exit(main())
