"""Command lines as a child of the page's server. It ends with the server, and reports its progress.

Each report is a line of JSON: {"progress": [what, done, total]} or {"output": text}.
"""

import io
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stdout
from typing import Any

from walkergen import cli
from walkergen.app import child_processes
from walkergen.cli import console
from walkergen.core.files.progress import Progress, part_progress


def main() -> int:
    """Run the command lines that the server sent, one after another; returns the exit code."""
    lines, stream = child_processes.receive_and_watch(), sys.stdout
    tell = child_processes.teller(stream)
    for number, words in enumerate(lines):
        signal.signal(signal.SIGINT, signal.default_int_handler)  # a command leaves it ignored at its end
        console.line_progress = _make_lines(part_progress(tell, number, len(lines)))  # type: ignore[assignment]
        sys.argv = ["walkergen", *words]
        with redirect_stdout(io.StringIO()) as output:
            code = _run_main()
        if code:
            return code
        child_processes.send_event({"output": output.getvalue()}, stream)
    return 0


def _run_main() -> int:
    try:
        cli.main()
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else int(end.code is not None)
    return 0


def _make_lines(tell: Progress) -> Callable[[str], Any]:
    """Return the replacement for the lines of progress on a terminal: it reports to `tell`."""

    @contextmanager
    def forward_progress(title: str) -> Iterator[Progress]:
        yield tell

    return forward_progress


if __name__ == "__main__":
    sys.exit(main())
