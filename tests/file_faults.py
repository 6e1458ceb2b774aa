"""Faults on demand: system calls that fail or kill at their n-th use, and commands in a fork."""

import contextlib
import io
import json
import os
import signal
import sys
import tempfile
import warnings
from pathlib import Path

CALLS = ("open", "write", "fsync", "replace", "mkdir", "unlink")
"""System calls that write files, as `os` names them."""


@contextlib.contextmanager
def failing(folder, call, number, fault, after=False):
    """Replace the `number`-th `call` on something in a folder by `fault()`, in a context.

    With `after` the fault follows the call. Yields a list with an entry for every call.
    """
    true, seen, ours = {name: getattr(os, name) for name in CALLS}, [], set()

    def wrap(name):
        def replacement(first, *more, **options):
            inside = first in ours if isinstance(first, int) else _is_inside(first, folder)
            if inside and name == call:
                seen.append(first)
                if len(seen) == number and not after:
                    fault()
            try:
                found = true[name](first, *more, **options)
            finally:
                if inside and name == call and len(seen) == number and after:
                    fault()
            if name == "open":
                (ours.add if inside else ours.discard)(found)
            return found

        return replacement

    try:
        for name in CALLS:
            setattr(os, name, wrap(name))
        yield seen
    finally:
        for name, function in true.items():
            setattr(os, name, function)


def _is_inside(path, folder):
    return Path(os.path.abspath(os.fspath(path))).is_relative_to(folder)  # noqa: PTH100


def broken(number):
    """Fault that is an error of the system."""

    def fault():
        raise OSError(number, os.strerror(number))

    return fault


def interrupt():
    """Ctrl-C."""
    raise KeyboardInterrupt


def kill():
    """The end of the process, which it does not notice."""
    os.kill(os.getpid(), signal.SIGKILL)


def run_in_child(work, prepare=None, closed=()):
    """Exit code, output and errors of a function in a process of its own.

    `prepare` is called there first; streams of the numbers `closed` are closed. A signal that ended
    the process counts as its negative number.
    """
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        with warnings.catch_warnings(action="ignore"):  # on threads of this process
            child = os.fork()
        if child == 0:
            _child(work, prepare, closed, out, err)
        _, status = os.waitpid(child, 0)
        out.seek(0)
        err.seek(0)
        return (os.waitstatus_to_exitcode(status), out.read().decode("utf-8", "replace"), err.read().decode())


def _child(work, prepare, closed, out, err):
    """Do the work of a fork, and end it."""
    code = 70
    try:
        os.dup2(out.fileno(), 1)
        os.dup2(err.fileno(), 2)
        signal.signal(signal.SIGINT, signal.default_int_handler)
        if prepare is not None:
            prepare()
        for number in closed:
            os.close(number)
        sys.stdout, sys.stderr = (
            None if number in closed else io.TextIOWrapper(io.FileIO(number, "w", closefd=False)) for number in (1, 2)
        )
        sys.__stdout__, sys.__stderr__ = sys.stdout, sys.stderr
        try:
            work()
            code = 0
        except SystemExit as done:
            code = done.code or 0
        sys.stdout.flush()
        sys.stderr.flush()
    except BaseException:
        import traceback

        with contextlib.suppress(BaseException):
            os.write(2, traceback.format_exc().encode())
    finally:
        os._exit(code)


def command(*words):
    """Function that runs a command line as a person does."""

    def work():
        from walkergen.cli import main

        sys.argv = ["walkergen", *map(str, words)]
        main()

    return work


def tree(folder):
    """Bytes of all files below a folder by name; of manifests what no clock and no seal is in."""
    found = {}
    for path in sorted(folder.rglob("*")):
        if path.is_file():
            data = path.read_bytes()
            if path.name == "manifest.json":
                facts = json.loads(data)
                data = [facts | {"time_taken_s": 0, "seconds": 0, "known": 0, "sealed": ""}]
            found[str(path.relative_to(folder))] = data
    return found


def is_one_line(told):
    """True for an error in a line of at most 200 letters that names something, without a trace."""
    lines = told.splitlines()
    return len(lines) == 1 and len(lines[0]) <= 300 and "Traceback" not in told
