"""Finished parts of the checks, minutes each: kept until the whole is done, so that what ends it loses one at most."""

import hashlib
import pickle
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from evidence.crowd_checks.setting import Size
from walkergen.core.files import output
from walkergen.points.point import digest

Part = TypeVar("Part")


class Parts:
    """Parts of one size, made by the current sources; parts of other sources are made again."""

    def __init__(self, folder: Path, size: Size) -> None:
        """Keep the parts next to the folder of the whole."""
        name = hashlib.sha256(f"{digest()} {size!r}".encode()).hexdigest()[:16]
        self._folder = folder.with_name(f"{folder.name}.parts-{name}")

    def load_or_make(self, name: str, make: Callable[[], Part]) -> Part:
        """Load the stored part of this name, or make and store it."""
        path = self._folder / f"{name}.pickle"
        if path.exists():
            part: Part = pickle.loads(path.read_bytes())
            return part
        part = make()
        output.write(path, pickle.dumps(part))
        return part

    def remove(self) -> None:
        """Remove them: the whole is written."""
        shutil.rmtree(self._folder, ignore_errors=True)
