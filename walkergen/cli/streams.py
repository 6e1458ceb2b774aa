"""Safe standard streams for a command line: open, in any locale, with reported errors.

A closed stream is replaced by one that refuses output, so that no file takes its
number. Letters outside a stream's encoding are replaced. Standard error, which reports every
mistake, accepts any text. Lost output is known at the end.
"""

import _thread
import atexit
import io
import os
import signal
import sys
import threading
import time
from typing import Any, NoReturn


class _StandardOutput(io.FileIO):
    """Standard output whose errors name it."""

    def write(self, data: Any, /) -> int:
        """Write what can be written. Raises OSError."""
        try:
            return super().write(data)
        except OSError as error:
            error.filename = "standard output"
            raise


class _StandardError(io.FileIO):
    """Standard error that drops what it cannot write, and remembers it."""

    lost = False

    def write(self, data: Any, /) -> int:
        """Write as much as possible; all text counts as written."""
        try:
            return super().write(data)
        except OSError:
            self.lost = True
            return len(data)


def prepare() -> _StandardError:
    """Make the standard streams safe to write to; returns the standard error, which records lost errors.

    Streams that replace Python's own are left unchanged.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDONLY)  # takes the number; nothing can be written there
    heard = _StandardError(2, "w", closefd=False)
    if sys.platform == "win32":  # a console takes letters by other means than files do
        return heard
    encoding = next((stream.encoding for stream in (sys.stdout, sys.stderr, sys.stdin) if stream), "utf-8")
    if sys.stdout is sys.__stdout__:
        sys.stdout = _text_stream(_StandardOutput(1, "w", closefd=False), encoding, "replace")
    if sys.stderr is sys.__stderr__:
        sys.stderr = _text_stream(heard, encoding, "backslashreplace", lines=True)
    return heard


def _text_stream(raw: io.FileIO, encoding: str, errors: str, lines: bool = False) -> io.TextIOWrapper:
    buffered = io.BufferedWriter(raw)
    return io.TextIOWrapper(buffered, encoding, errors, line_buffering=lines or raw.isatty())


def catch_interrupts() -> threading.Event:
    """Let Ctrl-C end the command at any time; returns an event that is set by a lost Ctrl-C.

    Python prints and forgets a Ctrl-C while an object is destroyed, or while a library calls back: the
    command would go on and end well. A library in C may print what stops its start, and raise an error of its own.
    """
    before, told, lost = sys.unraisablehook, sys.excepthook, threading.Event()

    def interrupt_again() -> None:
        lost.set()
        over = threading.Event()
        threading.Thread(target=_interrupt_after, args=(over,), daemon=True).start()
        over.set()

    def handle_unraisable(what: Any) -> None:
        if isinstance(what.exc_value, KeyboardInterrupt):
            interrupt_again()
        else:
            before(what)

    def handle_uncaught(kind: type[BaseException], error: BaseException, trace: Any) -> None:
        if issubclass(kind, KeyboardInterrupt):
            interrupt_again()
        else:
            told(kind, error, trace)

    sys.unraisablehook, sys.excepthook = handle_unraisable, handle_uncaught
    return lost


INTERRUPT_DELAY_S = 0.02
"""Time for the main thread to leave the code that loses interrupts, s."""


def _interrupt_after(over: threading.Event) -> None:
    """Interrupt the main thread after an event, if possible also while it waits for the system."""
    over.wait()
    time.sleep(INTERRUPT_DELAY_S)
    if sys.platform == "win32":
        _thread.interrupt_main()
    else:
        signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)


def discard_output() -> None:
    """Discard the remaining standard output, so that Python ends without a message."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.close(nowhere)


def exit_now(code: int) -> NoReturn:
    """End a process now. Python's own exit waits for threads, or may die of a signal without an exit code."""
    atexit._run_exitfuncs()
    os._exit(code)
