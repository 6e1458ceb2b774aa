"""Compilation of kernels: Python functions that numba compiles, cached on disk, without the interpreter lock.

numba's disk cache notices edits in the file of the compiled function but not in the files that
it imports, and then returns old answers. So the cache lies in a folder named by a hash of all the
sources that kernels may be made of: any edit there starts a fresh cache.
"""

import functools
import hashlib
import operator
import os
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, TypeVar

from walkergen.core import caches
from walkergen.core.numerics import shipped_kernels

SOURCE_PATTERNS = (
    "core/drive.py",
    "core/numerics/kernels.py",
    "core/numerics/shipped_kernels.py",
    "core/theory/balance.py",
    "core/theory/impact.py",
    "core/simulation/**/*.py",
    "points/emulator.py",
    "points/poses.py",
    "readers/drawings/crossings.py",
    "guests/**/space/*.py",
)
"""Patterns of the files that kernels, their constants and their arguments' types come from."""


@functools.cache
def source_digest() -> str:
    """Return the hash of the kernels' sources, 16 hexadecimal digits."""
    hasher = hashlib.sha256()
    package = Path(__file__).parents[2]
    for source in sorted(path for pattern in SOURCE_PATTERNS for path in package.glob(pattern)):
        hasher.update(source.read_bytes())
    return hasher.hexdigest()[:16]


_sums: dict[str, str] = {}
if "numba" not in sys.modules and "NUMBA_CACHE_DIR" not in os.environ:
    _sums, _unfit = shipped_kernels.find_fitting_kernels(source_digest())
    _place = caches.prepare_version_folder("numba", source_digest())
    os.environ["NUMBA_CACHE_DIR"] = str(_place)
    if _unfit and not any(_place.iterdir()):
        print(f"compiling kernels once, since the shipped ones do not fit: {_unfit}", file=sys.stderr)

import numba  # noqa: E402  (the cache folder and the kind of CPU have to be set first)
from numba.extending import intrinsic, typeof_impl  # noqa: E402

if _sums:
    shipped_kernels.install_in_cache(_sums)


def _register_without_blas() -> None:
    """Import numba's array functions without SciPy, which no kernel needs. It saves a fifth of a simulation's start."""
    sys.modules["scipy.linalg"] = None  # type: ignore[assignment]
    try:
        import numba.np.arraymath  # noqa: F401
    finally:
        del sys.modules["scipy.linalg"]


# In a process of a command; elsewhere kernels of others may need one
if "walkergen.cli.command_builder" in sys.modules and not {"scipy.linalg", "numba.np.arraymath"} & set(sys.modules):
    _register_without_blas()

F = TypeVar("F", bound=Callable[..., Any])


class Kernel:
    """Compiled function, in two forms: for calls from kernels, and with a wrapper for calls from Python.

    The wrapper unpacks arguments. For nested tuples it is larger than most functions, so only functions that Python
    calls get one. Each form is compiled on its first use.
    """

    __wrapped__: Callable[..., Any]

    def __init__(self, function: Callable[..., Any], options: dict[str, Any]) -> None:
        functools.update_wrapper(self, function)
        self.options = options

    @functools.cached_property
    def inner(self) -> Any:
        """Compiled function for calls from kernels. It is not cached, since the calling kernel contains its code."""
        bare = self.options | {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
        return numba.njit(**bare)(self.__wrapped__)

    @functools.cached_property
    def outer(self) -> Any:
        """Compiled function for calls from Python, cached on disk."""
        return numba.njit(cache=True, **self.options)(self.__wrapped__)

    def __call__(self, *arguments: Any) -> Any:
        """Run on arguments from Python."""
        return self.outer(*arguments)


@typeof_impl.register(Kernel)  # type: ignore[untyped-decorator]
def _typeof_kernel(kernel: Kernel, context: Any) -> Any:
    """Return the type of a kernel that another kernel calls."""
    return numba.typeof(kernel.inner)


def _compile(function: F, **options: Any) -> F:
    """Return a function as a `Kernel` with options of numba; the function itself if the compiler is off."""
    if numba.config.DISABLE_JIT:
        return function
    compiled: Any = Kernel(function, {"nogil": True, "error_model": "numpy", **options})
    return compiled  # type: ignore[no-any-return]


def kernel(function: F) -> F:
    """Compile `function` with numba on its first call; type checkers see the plain function."""
    return _compile(function)


def lean(function: F) -> F:
    """Compile `function` for inlining into its callers, without counting references. It must allocate no memory.

    A call copies each number of the tuples that it takes, 1 ns each. One that passes many arrays otherwise counts a
    reference of each. That takes 0.3 us for the arrays of a walker in space, as much as one of its steps, and threads
    that share arrays wait for each other. Inlined, such calls take a quarter less of a step, and no longer to compile.
    """
    return _compile(function, _nrt=False, forceinline=True)


def kernel_without_refcount(function: F) -> F:
    """Compile `function` as `kernel` does, without counting references. It must allocate no memory.

    It is meant for functions as large as a step that are called from several places. Functions that it inlines are
    `lean`.
    """
    return _compile(function, _nrt=False)


def entry_point(function: F, *arguments: Any) -> F:
    """Return the machine code of a kernel for arguments of these types, compiled if necessary.

    A call through it does not look up the types, which for nested tuples takes 0.1 ms.
    """
    if not isinstance(function, Kernel):  # a plain function, or the compiler is off
        return function
    code: F = function.outer.compile(tuple(numba.typeof(argument) for argument in arguments))
    return code


def typed_list(items: Iterable[Any]) -> Any:
    """Return `items`, tuples of one type, as a list that kernels can read; a plain list if the compiler is off.

    Kernels of this package fill it, because numba's own are compiled again in every process: 7 s of CPU for tuples as
    large as a walker. Its items are read with `borrow_item`.
    """
    if numba.config.DISABLE_JIT:
        return list(items)
    first, *others = items
    filled = _new_typed_list(first)
    for item in others:
        _append(filled, item)
    return filled


@kernel
def _new_typed_list(item: Any) -> Any:
    """Create a typed list with one item."""
    items = numba.typed.List()
    items.append(item)
    return items


@kernel
def _append(items: Any, item: Any) -> None:
    items.append(item)


@intrinsic  # type: ignore[untyped-decorator]
def _borrow_item(typing: Any, items: Any, i: Any) -> Any:
    """Return item i of a typed list without counting a reference to it, as a numba intrinsic."""
    from numba.typed.listobject import _list_getitem_borrowed

    getter, load = _list_getitem_borrowed._defn(typing, items, i)

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        """Emit the machine code of a call (numba's code generator of an intrinsic). Return its value."""
        some = builder.extract_value(load(context, builder, getter, arguments), 1)
        return context.cast(builder, some, getter.return_type[1], items.item_type)

    return items.item_type(items, i), code


borrow_item = operator.getitem if numba.config.DISABLE_JIT else _borrow_item
"""Item i of a `typed_list`, for kernels without reference counts (`lean`, `kernel_without_refcount`)."""
