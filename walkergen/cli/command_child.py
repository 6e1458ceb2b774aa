"""Command lines as a child of the page's server: it ends with it, and says how far it is.

A line of JSON for each thing that it says: {"progress": [what, done, total]} or {"output": text}.
"""

import io
import json
import signal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stdout
from typing import Any

from walkergen import cli
from walkergen.app import child_processes
from walkergen.cli import console
from walkergen.core.files.progress import Progress, part_progress

EVENT_INTERVAL_S = 0.2
"""Time (s) between two lines that say how far a job is."""


def main() -> int:
    """Run the command lines that the server sent, one after another; returns the exit code."""
    lines, stream = child_processes.receive_and_watch(), sys.stdout
    tell = _make_progress(stream)
    for number, words in enumerate(lines):
        signal.signal(signal.SIGINT, signal.default_int_handler)  # a command leaves it ignored at its end
        console.line_progress = _make_lines(part_progress(tell, number, len(lines)))  # type: ignore[assignment]
        sys.argv = ["walkergen", *words]
        with redirect_stdout(io.StringIO()) as output:
            code = _run_main()
        if code:
            return code
        _send_event(stream, {"output": output.getvalue()})
    return 0


def _run_main() -> int:
    try:
        cli.main()
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else int(end.code is not None)
    return 0


def _send_event(stream: Any, event: dict[str, Any]) -> None:
    print(json.dumps(event), file=stream, flush=True)


def _make_progress(stream: Any) -> Progress:
    """Progress that is said as events, not too often."""
    said = [0.0]

    def tell(what: str, done: int, total: int) -> None:
        if time.monotonic() - said[0] > EVENT_INTERVAL_S:
            said[0] = time.monotonic()
            _send_event(stream, {"progress": [what, done, total]})

    return tell


def _make_lines(tell: Progress) -> Callable[[str], Any]:
    """Return what replaces the lines of progress on a terminal: it reports to `tell`."""

    @contextmanager
    def lines(title: str) -> Iterator[Progress]:
        yield tell

    return lines


if __name__ == "__main__":
    sys.exit(main())
