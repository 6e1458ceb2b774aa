"""Simulated speeds of earlier fits, in the user's cache: a file for each walker in its scene."""

import hashlib
import json
from pathlib import Path

from walkergen import caches
from walkergen.errors import InputError
from walkergen.files import output, reading
from walkergen.scene import Scene
from walkergen.simulation import points
from walkergen.walker.design import Design


def place(scene: Scene, design: Design) -> Path:
    """File of the speeds of this walker in this scene, for this version."""
    text = json.dumps(points.facts(scene, design), sort_keys=True)
    return caches.folder("fit") / f"{hashlib.sha256(text.encode()).hexdigest()[:32]}.json"


def remember(path: Path, speeds: dict[str, float | None]) -> None:
    """Save speeds (mm/s, None where a walker has none) by the keys of their points."""
    output.write(path, json.dumps(speeds, allow_nan=False).encode())


def recall(path: Path) -> dict[str, float | None]:
    """Load what was saved; nothing where there is no file, or one cut short."""
    try:
        data = reading.json_of(path)
        return {str(key): None if speed is None else float(speed) for key, speed in data.items()}
    except (InputError, ValueError, TypeError, AttributeError):
        return {}
