"""Compilation of kernels: by numba, cached on disk, without the interpreter lock.

numba's disk cache notices edits in the file of the compiled function but not in the files that
it imports, and then returns old answers. So the cache lies in a folder named by a hash of all the
sources that kernels may be made of: any edit there starts a fresh cache.
"""

import functools
import hashlib
import os
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

SOURCES = ("numerics/*.py", "theory/*.py", "simulation/**/*.py")
"""Patterns of the files that kernels, their constants and their arguments' types come from."""


@functools.cache
def digest() -> str:
    """Hash of the sources that kernels are made of, 16 hexadecimal digits."""
    found = hashlib.sha256()
    package = Path(__file__).parent.parent
    for source in sorted(path for pattern in SOURCES for path in package.glob(pattern)):
        found.update(source.read_bytes())
    return found.hexdigest()[:16]


def cache(name: str) -> Path:
    """Writable folder in the user's cache, for files that can be made again at any time."""
    try:
        base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
        folder = base / "walkergen" / name
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return folder
    except (OSError, RuntimeError):  # no home, or a read-only home: a folder for this process alone
        return Path(tempfile.mkdtemp(prefix=f"walkergen-{name}-"))


if "numba" not in sys.modules and "NUMBA_CACHE_DIR" not in os.environ:
    os.environ["NUMBA_CACHE_DIR"] = str(cache(f"numba-{digest()}"))

import numba  # noqa: E402  (the cache folder has to be set first)

F = TypeVar("F", bound=Callable[..., Any])


def kernel(function: F) -> F:
    """Compile `function` with numba on its first call; type checkers see the plain function."""
    compiled: F = numba.njit(cache=True, nogil=True, error_model="numpy")(function)
    return compiled


def inlined(function: F) -> F:
    """Compile `function` as `kernel` does, into the code of those that call it.

    For parts of a hot loop that take whole tuples: a call copies each of their numbers, 1 ns each.
    """
    compiled: F = numba.njit(cache=True, nogil=True, error_model="numpy", forceinline=True)(
        function
    )
    return compiled


def lean(function: F) -> F:
    """Compile `function` as `kernel` does, without counting references: it must allocate nothing.

    A call that passes many arrays otherwise counts a reference of each: 0.3 us for those of a
    walker in space, as much as one of its steps, and threads that share arrays wait for each other.
    """
    compiled: F = numba.njit(cache=True, nogil=True, error_model="numpy", _nrt=False)(function)
    return compiled


def entry(function: F, *arguments: Any) -> F:
    """Machine code of a kernel for arguments of these types, compiled if need be.

    A call through it does not look up the types, which for nested tuples takes 0.1 ms.
    """
    if not hasattr(function, "compile"):  # a plain function, or the compiler is off
        return function
    code: F = function.compile(tuple(numba.typeof(argument) for argument in arguments))
    return code
