"""Output of the commands: JSON, tables, progress."""

import json
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from typing import TYPE_CHECKING, Any

from walkergen.files import plain

if TYPE_CHECKING:
    from rich.table import Table

    from walkergen.files.report import Report


def _as_json(data: dict[str, Any]) -> None:
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

    from walkergen.files import tables

    tables.show(content, Console(highlight=False, width=width))


def report(result: "Report", json: bool, quiet: bool, width: int | None = None) -> None:
    """Print what a job found: as JSON, or its caption, tables and lines, and where it lies.

    Its warnings come first, on the error stream, even when the command is quiet. `width` of the
    tables, letters; None: the terminal's.
    """
    for warning in result.warnings:
        print(f"warning: {warning}", file=sys.stderr)
    folder = {} if result.folder is None else {"folder": str(result.folder)}
    if json:
        _as_json({**result.facts, **folder})
    elif not quiet:
        if result.caption:
            text(result.caption)
        for shown in result.shown():
            table(shown.rich(), width)
            for line in shown.below():
                text(line)
        for line in result.lines:
            text(line)
        for path in result.files:
            print(path)
        if folder:
            print(f"written into {result.folder}/")
    for error in result.errors:
        print(f"error: {error}", file=sys.stderr)


def notes(lines: Sequence[str]) -> None:
    """Print what was read, on the error stream, a line each."""
    for line in lines:
        print(f"note: {plain.plain(line)}", file=sys.stderr)


def text(line: str) -> None:
    """Print a paragraph, broken between words where the terminal ends."""
    from rich.console import Console

    Console(highlight=False).print(plain.plain(line), markup=False)


FIRST_S, NEXT_S = 5.0, 15.0
"""Time (s) after which a job first says how far it is, and then again, where there is no bar."""


@contextmanager
def progress(title: str, wanted: bool, about_s: float | None = None) -> Iterator[Callable[[str, int, int], None]]:
    """Show how far a job is on the error stream, if `wanted`: a bar on a terminal, or lines.

    Long work says at once about how long it takes, s.
    """
    if wanted and about_s is not None:
        print(f"{title}: {_about(about_s)}", file=sys.stderr, flush=True)
    if not wanted:
        from walkergen import caches

        with caches.unannounced():
            yield lambda what, done, total: None
    else:
        with _bar(title) if sys.stderr.isatty() else lines(title) as update:
            yield update


@contextmanager
def lines(title: str) -> Iterator[Callable[[str, int, int], None]]:
    """Say how far a job is in a line now and then, also while it says nothing itself."""
    begun, ended = time.monotonic(), threading.Event()
    state: list[tuple[str, int, int]] = []
    start: list[tuple[float, float]] = []  # when something was done first, and which share: before, it got ready

    def tell() -> None:
        pause = FIRST_S
        while not ended.wait(pause):
            if state:
                pause = NEXT_S
                what, done, total = state[0]
                part = f"{done} %" if total == 100 else f"{done} of {total}"
                share = f", {part}" if done else ""
                left = _left(*start[0], time.monotonic(), done / total) if start else None
                rest = f"{time.monotonic() - begun:.0f} s so far" if left is None else f"{_about(left)} left"
                try:
                    print(plain.line(f"{title}: {what}{share}, {rest}"), file=sys.stderr, flush=True)
                except OSError:  # nobody reads it
                    return

    def update(what: str, done: int, total: int) -> None:
        state[:] = [(what, done, total)]
        if done and not start:
            start.append((time.monotonic(), done / total))

    thread = threading.Thread(target=tell, daemon=True)
    thread.start()
    try:
        yield update
    finally:
        ended.set()
        thread.join()


HONEST = 0.05
"""Share that must be done before the time left is told."""


def _left(begun: float, before: float, now: float, share: float) -> float | None:
    """Time that is left at the pace since a share was done `before`, s; None while too little was done to tell."""
    gone = share - before
    return (now - begun) * (1.0 - share) / gone if gone > HONEST else None


def _about(seconds: float) -> str:
    return f"about {seconds:.0f} s" if seconds < 100.0 else f"about {seconds / 60.0:.0f} min"


@contextmanager
def _bar(title: str) -> Iterator[Callable[[str, int, int], None]]:
    """Show a bar from the first time on that a job says how far it is."""
    with ExitStack() as stack:
        shown: list[Callable[[str, int, int], None]] = []

        def update(what: str, done: int, total: int) -> None:
            if not shown:
                shown.append(_drawn_bar(title, stack))
            shown[0](what, done, total)

        yield update


def _drawn_bar(title: str, stack: ExitStack) -> Callable[[str, int, int], None]:
    """Bar that is drawn until a stack ends."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    bar = stack.enter_context(Progress(*columns, console=Console(stderr=True), transient=True))
    task = bar.add_task(plain.line(title))

    def update(what: str, done: int, total: int) -> None:
        bar.update(task, description=plain.line(f"{title}: {what}"), completed=done, total=total)

    return update
