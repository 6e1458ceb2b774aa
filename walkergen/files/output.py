"""Writing files so that nothing is ever half-written, and folders that know what they hold."""

import contextlib
import hashlib
import json
import platform
import re
import secrets
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from walkergen import __version__
from walkergen.errors import OutputError

MANIFEST = "manifest.json"
LIBRARIES = ("numpy", "manifold3d", "lib3mf", "matplotlib", "pydantic")


def write(path: Path, data: bytes) -> None:
    """Write a file whole or not at all: a temporary name in the same folder, then a rename.

    The temporary file is new and its name not foreseen, so that no link that somebody put there
    leads elsewhere. Parent folders are made. Raises OutputError; on any exception the temporary
    file is removed.
    """
    try:
        # Of long names the beginning: the whole must not exceed what a folder holds
        temporary = path.with_name(f".{path.name[:80]}.{secrets.token_hex(8)}")
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            _create(temporary, data)
            temporary.replace(path)
        except BaseException:
            with contextlib.suppress(OSError):
                temporary.unlink()
            raise
    except (OSError, ValueError) as error:  # ValueError: a path that holds NUL or has no name
        raise refused(path, error) from None


def _create(path: Path, data: bytes) -> None:
    """Write a file that is not there yet; fails where anything of this name is."""
    with path.open("xb") as stream:
        stream.write(data)


def refused(path: Path, error: Exception) -> OutputError:
    """Error, in words, for a file or folder that the system does not let us write."""
    reason = getattr(error, "strerror", None) or str(error)
    return OutputError(f"{str(path)!r}: cannot be written: {reason}; try another --out")


class Folder:
    """An output folder that remembers the hash of every file written into it.

    Folders of several makers have a manifest each, of another name.
    """

    def __init__(self, path: Path, manifest: str = MANIFEST) -> None:
        self.path = path
        self.manifest = manifest
        self.hashes: dict[str, str] = {}

    def write(self, name: str, data: bytes) -> None:
        """Write one file by its name relative to the folder."""
        write(self.path / name, data)
        self.hashes[name] = hashlib.sha256(data).hexdigest()

    def add(self, name: str) -> None:
        """Take in a file that was written by other means, as row by row."""
        self.hashes[name] = _hash(self.path / name)

    def finish(self, facts: dict[str, Any]) -> None:
        """Write the manifest, after removing what an earlier run left and this one did not make.

        Only files that the earlier manifest lists, and that nobody changed since, are removed.
        """
        for name, digest in self._listed().items():
            if name not in self.hashes and self._ours(name, digest):
                (self.path / name).unlink()
        manifest = {**facts, "files": dict(sorted(self.hashes.items()))}
        text = json.dumps(manifest, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
        write(self.path / self.manifest, text.encode())

    def earlier(self) -> dict[str, Any]:
        """Manifest of an earlier run; nothing where there is none, or one that is not ours."""
        try:
            found = json.loads((self.path / self.manifest).read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return {}
        return found if isinstance(found, dict) else {}

    def untouched(self) -> bool:
        """True when every file of an earlier run is as it was left."""
        listed = self._listed()
        return bool(listed) and all(self._ours(name, digest) for name, digest in listed.items())

    def _listed(self) -> dict[str, str]:
        """Hashes of the files of an earlier run, by their names."""
        files = self.earlier().get("files")
        if not isinstance(files, dict):
            return {}
        return {str(name): str(digest) for name, digest in files.items()}

    def _ours(self, name: str, digest: str) -> bool:
        """True for a file inside the folder that nobody changed since."""
        path = self.path / name
        inside = self.path.resolve() in path.resolve().parents
        return inside and path.is_file() and _hash(path) == digest


def versions() -> dict[str, str]:
    """Versions of walkergen, Python and the libraries that shape the files."""
    found = {"walkergen": __version__, "python": platform.python_version()}
    for library in LIBRARIES:
        try:
            found[library] = version(library)
        except PackageNotFoundError:  # vendored without metadata, as in some distributions
            found[library] = "unknown"
    return found


def _hash(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def results(path: Path, out: Path | None, what: str) -> Path:
    """Folder for what is made of a file: below `out`, or below out/ and the file's own name.

    A folder of its own within, so that what other commands wrote there stays.
    """
    return (out or Path("out") / named_after(path)) / what


def named_after(path: Path) -> str:
    """Name of a folder for what is made of a file: the file's own, in letters that are safe."""
    return re.sub(r"[^A-Za-z0-9_-]+", "-", path.stem).strip("-")[:64] or "results"
