"""Output of the commands: JSON, tables, progress."""

import json
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from typing import TYPE_CHECKING, Any

from walkergen.core.errors import spell, spell_all
from walkergen.core.files import safe_text

if TYPE_CHECKING:
    from rich.table import Table

    from walkergen.core.files.progress import Expect, Expected
    from walkergen.files.report import Report


def _print_json(data: dict[str, Any]) -> None:
    """Print data as JSON, and escape letters outside the stream's encoding. Raises ValueError for NaN and infinity."""
    text = json.dumps(data, indent=2, ensure_ascii=False, allow_nan=False)
    try:
        text.encode(sys.stdout.encoding or "ascii")
    except UnicodeEncodeError:
        text = json.dumps(data, indent=2)
    print(text)


def print_table(content: "Table", width: int | None = None) -> None:
    """Print a table without cutting its cells. `width`: width in letters; None for that of the terminal."""
    from rich.console import Console

    from walkergen.files import rich_tables

    rich_tables.print_table(content, Console(highlight=False, width=width))


def print_report(result: "Report", json: bool, quiet: bool, width: int | None = None) -> None:
    """Print a report: its results as JSON if `json`, nothing if `quiet`, otherwise text from headline to next step.

    Warnings and errors are printed on the error stream in any case. `width`: width of tables in letters; None for that
    of the terminal.
    """
    for warning in result.warnings:
        print(f"warning: {spell(warning)}", file=sys.stderr)
    folder = {} if result.folder is None else {"folder": str(result.folder)}
    if json:
        _print_json({**spell_all(result.facts), **folder})
    elif not quiet:
        for opening in filter(None, (result.headline, result.caption)):
            print_paragraph(opening)
        for shown in result.visible_tables():
            print_table(shown.rich(), width)
            for line in shown.footer_lines():
                print_paragraph(line)
        for line in result.lines:
            print_paragraph(line)
        for path in result.files:
            print(path)
        if folder:
            print(f"written into {result.folder}/")
        if result.next_step:
            print(result.next_step)
    for error in result.errors:
        print(f"error: {spell(error)}", file=sys.stderr)


def print_notes(lines: Sequence[str]) -> None:
    """Print notes on the input files on the error stream, one line each."""
    for line in lines:
        print(f"note: {safe_text.escape_hidden(spell(line))}", file=sys.stderr)


def print_paragraph(line: str) -> None:
    """Print a paragraph, wrapped between words at the width of the terminal."""
    from rich.console import Console

    Console(highlight=False).print(safe_text.escape_hidden(spell(line)), markup=False)


FIRST_LINE_S, NEXT_LINE_S, SAME_STAGE_LINE_S = 5.0, 15.0, 60.0
"""Time (s) from the start of a job to its first progress line, and from one line to the next, for a new stage and for
the same stage."""
MIN_ANNOUNCED_S = 2.0
"""Expected time (s) below which a job does not announce its duration."""

MIN_PACE_SHARE = 0.1
"""Share of the work after which the remaining time is computed from the pace."""


class Clock:
    """Elapsed and remaining time of a job. The remaining time comes from the expected time, then from the pace."""

    def __init__(self, title: str) -> None:
        """Start the clock of a job with a title."""
        self.title, self._begun, self._ends = title, time.monotonic(), 0.0
        self._start: tuple[float, float] | None = None
        """Time and share of the first finished work. Before that, the job was preparing."""

    def print_expected(self, find: "Callable[[], Expected | None]") -> None:
        """Print the expected time of a job, only once. `find`: function that returns it, or None for a short job."""
        if self._ends or (expected := find()) is None:
            return
        self._ends = time.monotonic() + expected.seconds
        if expected.seconds >= MIN_ANNOUNCED_S:
            note = f"; {spell(expected.note)}" if expected.note else ""
            print(f"{self.title}: {_format_duration(expected.seconds)}{note}", file=sys.stderr, flush=True)

    def record(self, done: int, total: int) -> None:
        """Record when the first steps were finished. `done`: number of finished steps, of `total`."""
        if done and self._start is None:
            self._start = time.monotonic(), done / total

    def format_remaining(self, done: int, total: int) -> str:
        """Format the remaining time after `done` of `total` steps or, if it is unknown, the elapsed time."""
        now, share = time.monotonic(), done / total
        begun, first_share = self._start or (now, share)
        if share - first_share > MIN_PACE_SHARE:
            return f"{_format_duration((now - begun) * (1.0 - share) / (share - first_share))} left"
        if now < self._ends:
            return f"{_format_duration(self._ends - now)} left"
        return f"{now - self._begun:.0f} s so far"


@contextmanager
def progress(
    title: str, wanted: bool, on_expected: "Callable[[Expect], None] | None" = None
) -> Iterator[Callable[[str, int, int], None]]:
    """Show the progress of a job on the error stream, if `wanted`: a bar on a terminal, otherwise lines.

    Yields the function that the job calls with a step's name, the number done and the total. `on_expected`: receives
    the function that the job calls as soon as it can estimate its duration.
    """
    if not wanted:
        from walkergen.core import caches

        with caches.suppress_compile_notice():
            yield lambda what, done, total: None
    else:
        clock = Clock(title)
        if on_expected is not None:
            on_expected(clock.print_expected)
        with _bar_progress(clock) if sys.stderr.isatty() else line_progress(clock) as update:
            yield update


@contextmanager
def line_progress(clock: Clock) -> Iterator[Callable[[str, int, int], None]]:
    """Print progress lines from a thread. Yields the function that the job calls with its progress."""
    ended = threading.Event()
    latest: list[tuple[str, int, int]] = []  # arguments of the last `update`; empty before

    def print_lines() -> None:
        """Print a line for each long stage, and again if it lasts, until the job has ended."""
        pause, shown, next_same = FIRST_LINE_S, "", 0.0
        while not ended.wait(pause):
            if latest and (latest[0][0] != shown or time.monotonic() > next_same):
                pause, next_same = NEXT_LINE_S, time.monotonic() + SAME_STAGE_LINE_S
                shown, done, total = latest[0]
                share = f", {100 * done // total} %" if done else ""
                line = f"{clock.title}: {shown}{share}, {clock.format_remaining(done, total)}"
                try:
                    print(safe_text.shorten_line(line), file=sys.stderr, flush=True)
                except OSError:  # the error stream has no reader
                    return

    def update(what: str, done: int, total: int) -> None:
        latest[:] = [(what, done, total)]
        clock.record(done, total)

    thread = threading.Thread(target=print_lines, daemon=True)
    thread.start()
    try:
        yield update
    finally:
        ended.set()
        thread.join()


def _format_duration(seconds: float) -> str:
    return f"about {seconds:.0f} s" if seconds < 100.0 else f"about {seconds / 60.0:.0f} min"


@contextmanager
def _bar_progress(clock: Clock) -> Iterator[Callable[[str, int, int], None]]:
    """Show a progress bar once the job reports progress. Yields the function that the job calls with its progress."""
    with ExitStack() as stack:
        bar_updates: list[Callable[[str, int, int], None]] = []  # function of the bar; empty before the first report

        def update(what: str, done: int, total: int) -> None:
            if not bar_updates:
                bar_updates.append(_start_bar(clock, stack))
            bar_updates[0](what, done, total)

        yield update


def _start_bar(clock: Clock, stack: ExitStack) -> Callable[[str, int, int], None]:
    """Draw a progress bar until the exit stack is closed. Return the function that updates it."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn

    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TextColumn("{task.fields[left]}"))
    # The stream itself: that of rich's Console(stderr=True) escapes the bar's own control sequences.
    console = Console(file=getattr(sys.stderr, "rich_proxied_file", sys.stderr))
    bar = stack.enter_context(Progress(*columns, console=console, transient=True))
    task = bar.add_task(safe_text.shorten_line(clock.title), left="")

    def update(what: str, done: int, total: int) -> None:
        clock.record(done, total)
        described = safe_text.shorten_line(f"{clock.title}: {what}")
        bar.update(task, description=described, completed=done, total=total, left=clock.format_remaining(done, total))

    return update
