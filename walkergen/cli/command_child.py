"""Child process of the page's server that runs command lines. It ends with the server, and reports its progress.

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
    """Run the command lines that the server sent, one after another, and return the exit code."""
    lines, stream = child_processes.receive_and_watch_server(), sys.stdout
    send_progress = child_processes.progress_sender(stream)
    for number, words in enumerate(lines):
        signal.signal(signal.SIGINT, signal.default_int_handler)  # a command leaves it ignored at its end
        console.line_progress = _forward_to(part_progress(send_progress, number, len(lines)))  # type: ignore[assignment]
        sys.argv = ["walkergen", *words]
        with redirect_stdout(io.StringIO()) as output:
            code = _run_main()
        if code:
            return code
        child_processes.send_event({"output": output.getvalue()}, stream)
    return 0


def _run_main() -> int:
    """Run the command line in `sys.argv` and return its exit code."""
    try:
        cli.main()
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else int(end.code is not None)
    return 0


def _forward_to(callback: Progress) -> Callable[[str], Any]:
    """Return a replacement for `console.line_progress` that passes progress to a callback instead of printing it."""

    @contextmanager
    def forward_progress(title: str) -> Iterator[Progress]:
        yield callback

    return forward_progress


if __name__ == "__main__":
    sys.exit(main())
