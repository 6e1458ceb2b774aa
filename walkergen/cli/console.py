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
    """Print JSON, refusing NaN and infinity, which JSON does not have.

    Letters that the stream's encoding has not are escaped, not replaced: no name is lost.
    """
    text = json.dumps(data, indent=2, ensure_ascii=False, allow_nan=False)
    try:
        text.encode(sys.stdout.encoding or "ascii")
    except UnicodeEncodeError:
        text = json.dumps(data, indent=2)
    print(text)


def table(content: "Table", width: int | None = None) -> None:
    """Print a table with all its numbers whole, at any width (letters); None: the terminal's."""
    from rich.console import Console

    from walkergen.core.files import tables

    tables.print_table(content, Console(highlight=False, width=width))


def report(result: "Report", json: bool, quiet: bool, width: int | None = None) -> None:
    """Print what a job found: as JSON, or its caption, tables and lines, and where it lies.

    Its warnings come first, on the error stream, even when the command is quiet. `width` of the
    tables, letters; None: the terminal's.
    """
    for warning in result.warnings:
        print(f"warning: {spell(warning)}", file=sys.stderr)
    folder = {} if result.folder is None else {"folder": str(result.folder)}
    if json:
        _print_json({**spell_all(result.facts), **folder})
    elif not quiet:
        if result.caption:
            text(result.caption)
        for shown in result.visible_tables():
            table(shown.rich(), width)
            for line in shown.footer_lines():
                text(line)
        for line in result.lines:
            text(line)
        for path in result.files:
            print(path)
        if folder:
            print(f"written into {result.folder}/")
    for error in result.errors:
        print(f"error: {spell(error)}", file=sys.stderr)


def notes(lines: Sequence[str]) -> None:
    """Print what was read, on the error stream, a line each."""
    for line in lines:
        print(f"note: {safe_text.escape_hidden(spell(line))}", file=sys.stderr)


def text(line: str) -> None:
    """Print a paragraph, broken between words where the terminal ends."""
    from rich.console import Console

    Console(highlight=False).print(safe_text.escape_hidden(spell(line)), markup=False)


FIRST_LINE_S, NEXT_LINE_S = 5.0, 15.0
"""Time (s) after which a job first says how far it is, and then again, where there is no bar."""
MIN_ANNOUNCED_S = 2.0
"""Time (s) below which a job is over before anybody has read how long it will take."""

MIN_PACE_SHARE = 0.05
"""Share that must be done before the time left is told by the pace."""


class Clock:
    """Time that a job has taken, and what is left of it: by what it expected, and after that by its pace."""

    def __init__(self, title: str) -> None:
        """Clock of a job with a title, which begins now."""
        self.title, self._begun, self._ends = title, time.monotonic(), 0.0
        self._start: tuple[float, float] | None = None
        """Time when something was done first, and its share: before, the job got ready."""

    def print_expected(self, find: "Callable[[], Expected | None]") -> None:
        """Print how long a job will take, the first time that it knows."""
        if self._ends or (expected := find()) is None:
            return
        self._ends = time.monotonic() + expected.seconds
        if expected.seconds >= MIN_ANNOUNCED_S:
            note = f"; {spell(expected.note)}" if expected.note else ""
            print(f"{self.title}: {_format_duration(expected.seconds)}{note}", file=sys.stderr, flush=True)

    def record(self, done: int, total: int) -> None:
        """Note how many steps are done."""
        if done and self._start is None:
            self._start = time.monotonic(), done / total

    def format_remaining(self, done: int, total: int) -> str:
        """Time that is left where so many steps are done, in words."""
        now, share = time.monotonic(), done / total
        if now < self._ends:
            return f"{_format_duration(self._ends - now)} left"
        begun, before = self._start or (now, share)
        if share - before > MIN_PACE_SHARE:
            return f"{_format_duration((now - begun) * (1.0 - share) / (share - before))} left"
        return f"{now - self._begun:.0f} s so far"


@contextmanager
def progress(
    title: str, wanted: bool, hear: "Callable[[Expect], None] | None" = None
) -> Iterator[Callable[[str, int, int], None]]:
    """Show how far a job is on the error stream, if `wanted`: a bar on a terminal, or lines.

    What a job expects to take is printed as soon as it knows: `hear` is given whom it tells.
    """
    if not wanted:
        from walkergen.core import caches

        with caches.suppress_compile_notice():
            yield lambda what, done, total: None
    else:
        clock = Clock(title)
        if hear is not None:
            hear(clock.print_expected)
        with _bar_progress(clock) if sys.stderr.isatty() else line_progress(clock) as update:
            yield update


@contextmanager
def line_progress(clock: Clock) -> Iterator[Callable[[str, int, int], None]]:
    """Say how far a job is in a line now and then, also while it says nothing itself."""
    ended = threading.Event()
    state: list[tuple[str, int, int]] = []

    def tell() -> None:
        pause = FIRST_LINE_S
        while not ended.wait(pause):
            if state:
                pause = NEXT_LINE_S
                what, done, total = state[0]
                part = f"{done} %" if total == 100 else f"{done} of {total}"
                share = f", {part}" if done else ""
                try:
                    line = safe_text.shorten_line(
                        f"{clock.title}: {what}{share}, {clock.format_remaining(done, total)}"
                    )
                    print(line, file=sys.stderr, flush=True)
                except OSError:  # nobody reads it
                    return

    def update(what: str, done: int, total: int) -> None:
        state[:] = [(what, done, total)]
        clock.record(done, total)

    thread = threading.Thread(target=tell, daemon=True)
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
    """Show a bar from the first time on that a job says how far it is."""
    with ExitStack() as stack:
        shown: list[Callable[[str, int, int], None]] = []

        def update(what: str, done: int, total: int) -> None:
            if not shown:
                shown.append(_start_bar(clock, stack))
            shown[0](what, done, total)

        yield update


def _start_bar(clock: Clock, stack: ExitStack) -> Callable[[str, int, int], None]:
    """Bar that is drawn until a stack ends."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TextColumn("{task.fields[left]}"))
    bar = stack.enter_context(Progress(*columns, console=Console(stderr=True), transient=True))
    task = bar.add_task(safe_text.shorten_line(clock.title), left="")

    def update(what: str, done: int, total: int) -> None:
        clock.record(done, total)
        described = safe_text.shorten_line(f"{clock.title}: {what}")
        bar.update(task, description=described, completed=done, total=total, left=clock.format_remaining(done, total))

    return update
