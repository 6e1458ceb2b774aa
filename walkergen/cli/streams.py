"""Safe standard streams for a command line: always open, in any locale, with reported errors.

A closed stream is replaced by one that refuses output, so that no file gets its file
descriptor. Letters outside a stream's encoding are replaced. Standard error, which reports every
mistake, accepts any text, and records that output was lost.
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
    """Standard output whose errors contain the name "standard output"."""

    def write(self, data: Any, /) -> int:
        """Write data. Raises OSError with the name "standard output"."""
        try:
            return super().write(data)
        except OSError as error:
            error.filename = "standard output"
            raise


class _StandardError(io.FileIO):
    """Standard error that drops text that it cannot write, and records the loss."""

    lost = False

    def write(self, data: Any, /) -> int:
        """Write data and return the number of bytes. After an error set `lost`, and return as if all were written."""
        try:
            return super().write(data)
        except OSError:
            self.lost = True
            return len(data)


def prepare() -> _StandardError:
    """Make the standard streams safe to write to. Return the error stream, whose `lost` records lost output.

    Streams that already replace Python's own are left unchanged.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDONLY)  # takes the number; nothing can be written there
    error_stream = _StandardError(2, "w", closefd=False)
    if sys.platform == "win32":  # a console takes letters by other means than files do
        return error_stream
    encoding = next((stream.encoding for stream in (sys.stdout, sys.stderr, sys.stdin) if stream), "utf-8")
    if sys.stdout is sys.__stdout__:
        sys.stdout = _text_stream(_StandardOutput(1, "w", closefd=False), encoding, "replace")
    if sys.stderr is sys.__stderr__:
        sys.stderr = _text_stream(error_stream, encoding, "backslashreplace", lines=True)
    return error_stream


def _text_stream(raw: io.FileIO, encoding: str, errors: str, lines: bool = False) -> io.TextIOWrapper:
    """Return a text stream on a raw one. `errors`: name of a codec error handler. `lines`: True to flush every line."""
    buffered = io.BufferedWriter(raw)
    return io.TextIOWrapper(buffered, encoding, errors, line_buffering=lines or raw.isatty())


def catch_interrupts() -> threading.Event:
    """Install hooks that repeat a Ctrl-C that Python or a library ignored. Return an event that is then set.

    Python ignores KeyboardInterrupt while an object is destroyed, or while a library calls back. A library in C may
    also print it and raise another error.
    """
    unraisable_hook, except_hook, lost = sys.unraisablehook, sys.excepthook, threading.Event()

    def interrupt_again() -> None:
        """Set `lost`, and interrupt the main thread again a moment later."""
        lost.set()
        ready = threading.Event()
        threading.Thread(target=_interrupt_after, args=(ready,), daemon=True).start()
        ready.set()

    def handle_unraisable(what: Any) -> None:
        if isinstance(what.exc_value, KeyboardInterrupt):
            interrupt_again()
        else:
            unraisable_hook(what)

    def handle_uncaught(kind: type[BaseException], error: BaseException, trace: Any) -> None:
        if issubclass(kind, KeyboardInterrupt):
            interrupt_again()
        else:
            except_hook(kind, error, trace)

    sys.unraisablehook, sys.excepthook = handle_unraisable, handle_uncaught
    return lost


INTERRUPT_DELAY_S = 0.02
"""Time for the main thread to leave the code that loses interrupts, s."""


def _interrupt_after(ready: threading.Event) -> None:
    """Wait for the event and INTERRUPT_DELAY_S, then interrupt the main thread as Ctrl-C does."""
    ready.wait()
    time.sleep(INTERRUPT_DELAY_S)
    if sys.platform == "win32":
        _thread.interrupt_main()
    else:
        signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)


def discard_output() -> None:
    """Redirect standard output to nowhere, so that Python exits without an error message."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.close(nowhere)


def exit_now(code: int) -> NoReturn:
    """Run the exit functions and end the process with an exit code, without waiting for threads."""
    atexit._run_exitfuncs()
    os._exit(code)
