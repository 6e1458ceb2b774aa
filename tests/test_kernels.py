"""The disk cache of kernels: edits to anything a kernel is made of must start a fresh one."""

import ast
from pathlib import Path

import walkergen
from walkergen.numerics.kernels import SOURCES

PACKAGE = Path(walkergen.__file__).parent
COVERED = {path for pattern in SOURCES for path in PACKAGE.glob(pattern)}
WITH_KERNELS = sorted(p for p in PACKAGE.rglob("*.py") if "@kernel" in p.read_text())


def kernel_names(tree):
    """Every name that the kernels of a module use."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef) and any(
            isinstance(decorator, ast.Name) and decorator.id == "kernel"
            for decorator in node.decorator_list
        ):
            yield from (inner.id for inner in ast.walk(node) if isinstance(inner, ast.Name))


def test_the_cache_covers_every_file_that_kernels_are_made_of():
    assert len(WITH_KERNELS) > 10
    # A kernel's own file is watched by numba; every other that it is made of has to be covered.
    for path in WITH_KERNELS:
        tree = ast.parse(path.read_text())
        used = set(kernel_names(tree))
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("walkergen"):
                source = PACKAGE.joinpath(*(node.module or "").split(".")[1:])
                covered = source.with_suffix(".py") in COVERED or source.is_dir()
                names = {alias.asname or alias.name for alias in node.names}
                assert covered or not names & used, f"{path.name} uses {names & used}"
