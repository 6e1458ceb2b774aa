"""Kernels shipped compiled with the package, in `walkergen/kernels`, if they fit this machine.

They are machine code for any CPU of a kind (x86-64-v3, or the generic one elsewhere). numba
compiles for that kind as well, so that new kernels fit the shipped ones. Code is unpickled only
from the package's own folder, checked with its manifest's sums, and only if no other user can write to it.
"""

import functools
import hashlib
import json
import os
import platform
import stat
import sys
from pathlib import Path
from typing import Any, NamedTuple

from walkergen.core import caches

KERNEL_FOLDER = caches.PACKAGE_FOLDER / "kernels"
MANIFEST = "manifest.json"

X86_64_V3_FEATURES = ("avx", "avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe")
"""Features of a CPU of the kind x86-64-v3, by LLVM's names."""


class Kind(NamedTuple):
    """Properties, apart from the sources, that machine code depends on: all must match."""

    sources: str
    """Digest of the kernels' sources."""
    numba: str
    python: str
    """Implementation and version, whose byte code the keys of entries hold: cpython-311."""
    machine: str
    cpu: str
    """LLVM's name of the CPU that the code is for."""


def machine_kind(sources: str) -> Kind:
    """Return the `Kind` of machine code that this computer compiles. `sources`: digest of the kernels' sources."""
    from importlib.metadata import version

    return Kind(
        sources, version("numba"), str(sys.implementation.cache_tag), f"{sys.platform}-{platform.machine()}", cpu_kind()
    )


@functools.cache
def cpu_kind() -> str:
    """Return LLVM's name of the kind of CPU that shipped kernels need; "" if this CPU lacks some of its features."""
    if platform.machine().lower() not in ("x86_64", "amd64"):
        return "generic"
    from llvmlite import binding

    has = binding.get_host_cpu_features()
    return "x86-64-v3" if all(has.get(name, False) for name in X86_64_V3_FEATURES) else ""


def read_manifest(folder: Path = KERNEL_FOLDER) -> dict[str, Any] | None:
    """Read the manifest of the shipped kernels; None if it is missing or unreadable."""
    try:
        return dict(json.loads((folder / MANIFEST).read_text()))
    except (OSError, ValueError, TypeError):
        return None


def mismatch_reason(manifest: dict[str, Any], own: Kind, folder: Path = KERNEL_FOLDER) -> str:
    """Return the reason why a manifest's kernels do not fit this machine, whose kind is `own`; "" if they fit."""
    if not _is_trusted_folder(folder):
        return f"{folder} can be written by others"
    requested = os.environ.get("NUMBA_CPU_NAME", own.cpu), os.environ.get("NUMBA_CPU_FEATURES", "")
    if requested != (own.cpu, "") or not own.cpu:
        return "they are for a CPU of another kind"
    for name, value in own._asdict().items():
        if manifest.get(name) != value:
            description = "edited sources" if name == "sources" else f"{name} {manifest.get(name)}"
            return f"they are of {description}" + ("" if name == "sources" else f", this is {value}")
    return ""


def _is_trusted_folder(folder: Path) -> bool:
    """Return whether only the user and root, who may have installed it, can write to a folder and its files."""
    if not hasattr(os, "getuid"):
        return True  # Windows: a profile's folders are its user's
    for path in (folder, *folder.rglob("*")):
        status = path.lstat()
        if status.st_uid not in (0, os.getuid()) or stat.S_ISLNK(status.st_mode):
            return False
        shared = bool(status.st_mode & stat.S_IWGRP) and status.st_gid != os.getgid()
        if shared or status.st_mode & stat.S_IWOTH:
            return False
    return True


def find_fitting_kernels(sources: str) -> tuple[dict[str, str], str]:
    """Return the checksums of the shipped kernels by file, and "". If they do not fit this machine: {} and the reason.

    If none are shipped: {} and "". `sources` is the digest of the kernels' sources. If the kernels fit, environment
    variables make numba, which is not yet imported, compile for the same kind of CPU.
    """
    manifest = read_manifest()
    if manifest is None:
        return {}, ""
    own = machine_kind(sources)
    reason = mismatch_reason(manifest, own)
    if reason:
        return {}, reason
    os.environ["NUMBA_CPU_NAME"], os.environ["NUMBA_CPU_FEATURES"] = own.cpu, ""
    return dict(manifest["files"]), ""


def install_in_cache(sums: dict[str, str]) -> None:
    """Make numba's cache search the shipped files first. Import numba. `sums`: checksums of these files by path."""
    from numba.core import caching

    caching.IndexDataCacheFile = add_shipped_files(caching.IndexDataCacheFile, sums)


def add_shipped_files(base: Any, sums: dict[str, str], folder: Path = KERNEL_FOLDER) -> Any:
    """Return a subclass of `base`, numba's class of cache files, that reads shipped files first. `sums`: by path."""
    # Subfolders of shipped kernels, by numba's names of their sources' folders
    subfolders = {
        caches.cache_subpath(caches.PACKAGE_FOLDER / name): name for name in {str(Path(path).parent) for path in sums}
    }

    class ShippedFile(base):  # type: ignore[misc]
        """Shipped machine code of one function, read only if files have the checksums of the manifest."""

        def _load_index(self) -> Any:
            """Load the index of the function's entries; empty if the file is not intact."""
            return super()._load_index() if self._is_intact(self._index_name) else {}

        def _load_data(self, name: str) -> Any:
            """Load the machine code in a file. Raises FileNotFoundError if the file is not intact."""
            if not self._is_intact(name):
                raise FileNotFoundError(name)
            return super()._load_data(name)

        def _is_intact(self, name: str) -> bool:
            """Return whether a file matches its checksum."""
            path = Path(self._cache_path) / name
            expected = sums.get(path.relative_to(folder).as_posix())
            return expected is not None and file_checksum(path) == expected

    class CombinedFile(base):  # type: ignore[misc]
        """Machine code of one function: shipped, or compiled on this machine."""

        def __init__(self, cache_path: str, filename_base: str, source_stamp: Any) -> None:
            super().__init__(cache_path, filename_base, source_stamp)
            subfolder = subfolders.get(Path(cache_path).name)
            shipped_folder = None if subfolder is None else str(folder / subfolder)
            self._shipped = None if shipped_folder is None else ShippedFile(shipped_folder, filename_base, source_stamp)

        def load(self, key: Any) -> Any:
            """Load the machine code for a `key` of numba's index: shipped, or if missing, compiled here."""
            entry = None if self._shipped is None else self._shipped.load(key)
            return super().load(key) if entry is None else entry

    return CombinedFile


def file_checksum(path: Path) -> str:
    """Return the SHA-256 of a file; "" if it cannot be read."""
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError:
        return ""
