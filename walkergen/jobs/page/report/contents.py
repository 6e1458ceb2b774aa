"""Contents of a family's folder, read back and compared with its manifest."""

import hashlib
import io
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

from pydantic import BaseModel, ConfigDict, StringConstraints, ValidationError

from walkergen.errors import InputError
from walkergen.files import columns, plain, reading
from walkergen.files.columns import Records
from walkergen.files.output import MANIFEST

State = Literal["as written", "changed", "missing"]

LARGEST_FOLDER_BYTES, LARGEST_MANIFEST_BYTES = 200_000_000, 20_000_000
Digest = Annotated[str, StringConstraints(pattern="^[0-9a-f]{64}$")]


class Manifest(BaseModel):
    """Parts of manifest.json that the page needs; other keys are kept as they are."""

    model_config = ConfigDict(frozen=True, extra="allow", strict=True, allow_inf_nan=False)

    design: dict[str, Any]
    scene: dict[str, Any]
    members: list[str]
    legs_up: list[str]
    """Members whose STL file has them upside down, as they print: its z points to the plate."""
    versions: dict[str, str]
    files: dict[str, Digest]


class Contents(NamedTuple):
    """A folder read into memory."""

    manifest: Manifest
    files: Mapping[str, bytes]
    """Bytes of every file that the manifest lists and the folder has, by its listed name."""
    states: Mapping[str, State]
    """State of every file that the manifest lists, by comparing hashes."""

    def named(self, state: State) -> list[str]:
        """Files in a state, in the manifest's order."""
        return [name for name, own in self.states.items() if own == state]

    def records(self, name: str) -> Records:
        """Rows of a CSV file as text. Raises InputError when it is not one."""
        text = self.files[name].decode("utf-8", "replace")
        return columns.records(io.StringIO(text, newline=None), name)


def read(folder: Path) -> Contents:
    """Read every file that the folder's manifest lists and compare its hash.

    Raises InputError for a folder without a manifest that `family` wrote, for a manifest that names
    files outside its folder, for files that cannot be read and for more than LARGEST_FOLDER_BYTES.
    """
    manifest = _manifest(folder)
    files: dict[str, bytes] = {}
    states: dict[str, State] = {}
    total = 0
    for name, digest in manifest.files.items():
        path = _inside(folder, name)
        if not os.path.lexists(path):
            states[name] = "missing"
            continue
        data = reading.content(path, LARGEST_FOLDER_BYTES)
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
    """Manifest of a folder; raises InputError when there is none or it is not one of ours."""
    path = folder / MANIFEST
    if not os.path.lexists(path):
        raise InputError(f"{folder}: no folder with a {MANIFEST}; give one that `walkergen family` wrote")
    advice = "write the folder again with `walkergen family`"
    try:
        return Manifest.model_validate(reading.json_of(path, LARGEST_MANIFEST_BYTES))
    except ValidationError as error:
        mistake = error.errors()[0]
        where = plain.line(".".join(map(str, mistake["loc"])) or "its contents")
        raise InputError(f"{path}: {where}: {mistake['msg']}; {advice}") from None
    except InputError as error:
        raise InputError(f"{error}; {advice}") from None


def _inside(folder: Path, name: str) -> Path:
    """Path of a listed file; raises InputError when it would lead out of the folder."""
    path = folder / name
    if reading.named_soundly(path):
        inside = Path(os.path.realpath(folder)) in Path(os.path.realpath(path)).parents
        if inside:
            return path
    raise InputError(f"{folder / MANIFEST}: files: {name!r} is not inside the folder")
