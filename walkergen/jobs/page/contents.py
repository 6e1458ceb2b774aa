"""What a family's folder holds, read back and compared with its manifest."""

import csv
import hashlib
import io
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

from pydantic import BaseModel, ConfigDict, StringConstraints, ValidationError

from walkergen.errors import InputError
from walkergen.files.output import MANIFEST

State = Literal["as written", "changed", "missing"]

LARGEST_FOLDER_BYTES = 200_000_000
Digest = Annotated[str, StringConstraints(pattern="^[0-9a-f]{64}$")]


class Manifest(BaseModel):
    """What the page needs of manifest.json; whatever else it holds is kept as it is."""

    model_config = ConfigDict(frozen=True, extra="allow", strict=True, allow_inf_nan=False)

    design: dict[str, Any]
    scene: dict[str, Any]
    members: list[str]
    versions: dict[str, str]
    files: dict[str, Digest]


class Contents(NamedTuple):
    """A folder read into memory."""

    manifest: Manifest
    files: Mapping[str, bytes]
    """Every file that the manifest lists and the folder has, by its name in the manifest."""
    states: Mapping[str, State]
    """Every file that the manifest lists, by hash."""

    def named(self, state: State) -> list[str]:
        """Files in a state, in the manifest's order."""
        return [name for name, found in self.states.items() if found == state]

    def rows(self, name: str) -> list[list[str]]:
        """The cells of a CSV file, its headings first. Raises InputError."""
        text = self.files[name].decode("utf-8", "replace")
        try:
            return list(csv.reader(io.StringIO(text, newline=""))) or [[]]
        except csv.Error as error:
            raise InputError(f"{name}: not valid CSV: {error}; write the folder again") from None


def read(folder: Path) -> Contents:
    """Read every file that the folder's manifest lists and compare its hash.

    Raises InputError for a folder that has no manifest, or none that `family` wrote, for one whose
    manifest names files outside it, and for files that cannot be read.
    """
    manifest = _manifest(folder)
    files: dict[str, bytes] = {}
    states: dict[str, State] = {}
    total = 0
    for name, digest in manifest.files.items():
        path = _inside(folder, name)
        if not path.is_file():
            states[name] = "missing"
            continue
        data = _bytes(path)
        total += len(data)
        if total > LARGEST_FOLDER_BYTES:
            raise InputError(
                f"{folder}: its files exceed {LARGEST_FOLDER_BYTES // 10**6} MB, too much for one "
                "page; make a smaller family"
            )
        files[name] = data
        states[name] = "as written" if hashlib.sha256(data).hexdigest() == digest else "changed"
    return Contents(manifest, files, states)


def _manifest(folder: Path) -> Manifest:
    path = folder / MANIFEST
    if not path.is_file():
        raise InputError(
            f"{folder}: no folder with a {MANIFEST}; give one that `walkergen family` wrote"
        )
    advice = "write the folder again with `walkergen family`"
    try:
        return Manifest.model_validate(json.loads(_bytes(path)))
    except ValidationError as error:
        mistake = error.errors()[0]
        where = ".".join(map(str, mistake["loc"])) or "its contents"
        raise InputError(f"{path}: {where}: {mistake['msg']}; {advice}") from None
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: not valid JSON: {error}; {advice}") from None


def _inside(folder: Path, name: str) -> Path:
    """The path of a listed file; a manifest is text, and never a way out of its folder."""
    path = folder / name
    try:
        if folder.resolve() in path.resolve().parents:
            return path
    except ValueError:  # a NUL in the name
        pass
    raise InputError(f"{folder / MANIFEST}: files: {name!r} is not inside the folder")


def _bytes(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
