"""The disk cache of kernels: edits to anything a kernel is made of must start a fresh one."""

import ast
import gc
import sys
import weakref
from pathlib import Path

import numba
import numpy as np
import pytest

import walkergen
from walkergen.core.numerics.kernels import SOURCE_PATTERNS, borrow_item, kernel, kernel_without_refcount, typed_list
from walkergen.core.theory.networks import Layer

PACKAGE = Path(walkergen.__file__).parent
COVERED = {path for pattern in SOURCE_PATTERNS for path in PACKAGE.glob(pattern)}
WITH_KERNELS = sorted(p for p in PACKAGE.rglob("*.py") if "@kernel" in p.read_text())


def kernel_names(tree):
    """Every name that the kernels of a module use."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef) and any(
            isinstance(decorator, ast.Name) and decorator.id == "kernel" for decorator in node.decorator_list
        ):
            yield from (inner.id for inner in ast.walk(node) if isinstance(inner, ast.Name))


def imported_names(node):
    """Names that an import from the package binds, each with the file that it comes from."""
    source = PACKAGE.joinpath(*node.module.split(".")[1:])
    for alias in node.names:
        module = source / f"{alias.name}.py"
        found = module if module.is_file() else source.with_suffix(".py")
        yield alias.asname or alias.name, found if found.is_file() else source / "__init__.py"


def test_the_cache_covers_every_file_that_kernels_are_made_of():
    assert len(WITH_KERNELS) > 10
    # A kernel's own file is watched by numba; every other that it is made of has to be covered.
    for path in WITH_KERNELS:
        tree = ast.parse(path.read_text())
        used = set(kernel_names(tree))
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("walkergen"):
                for name, source in imported_names(node):
                    assert source in COVERED or name not in used, f"{path.name} uses {name}"


@kernel
def _twice(pair):
    return 2.0 * pair[0] + pair[1]


@kernel
def _call_twice(pair):
    return _twice(pair) + 1.0


@pytest.mark.skipif(numba.config.DISABLE_JIT, reason="the compiler is off")
def test_only_what_python_calls_has_a_wrapper_and_both_give_the_same():
    pair = (0.5, 0.25)
    assert _call_twice(pair) == 2.25
    assert len(_call_twice.outer.signatures) == 1
    assert len(_twice.inner.signatures) <= 1  # none where the caller came from the cache
    assert not _twice.outer.signatures
    assert _twice(pair) == 1.25
    assert len(_twice.outer.signatures) == 1


@kernel_without_refcount
def _raise(pairs, i):
    pair = borrow_item(pairs, i)
    pair.weights[0] += pair.bias[1]


@kernel
def _raise_all(pairs):
    for _ in range(100):
        for i in range(3):
            _raise(pairs, i)


def test_items_of_a_list_are_read_without_counting_references_that_would_never_be_returned():
    """Of a type of the package: the cache names the type, and a command could not import one of these tests."""
    shared = np.arange(2.0)
    items = [Layer(np.full(1, float(i)), shared) for i in range(3)]
    pairs = typed_list(items)
    before = sys.getrefcount(shared)
    _raise_all(pairs)
    assert [item.weights[0] for item in items] == [100.0, 101.0, 102.0]
    gone = weakref.ref(shared)
    assert sys.getrefcount(shared) == before
    del pairs, items, shared
    gc.collect()
    assert gone() is None
