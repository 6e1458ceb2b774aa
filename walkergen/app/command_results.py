"""Results of commands that a page runs on its walker: the effects of its scene, and ten walkers in a dish."""

from pathlib import Path
from typing import Any

import manifold3d
import numpy as np

from walkergen.app import document as documents
from walkergen.app import walker_answers
from walkergen.app.document import Document
from walkergen.core.errors import InputError
from walkergen.core.files import columns
from walkergen.core.walker import solids
from walkergen.files import web_page
from walkergen.request import PLANE_SCENE, choose_scene

MAX_PICTURE_BYTES = 10_000_000
"""Largest picture that the page can show, bytes."""


def explain_arguments(document: Document, folder: Path) -> list[str]:
    """Return the words after `walkergen` that measure each effect, and draw it below `folder`. Raises InputError."""
    return documents.arguments(document, "explain", "--measure", "--json", "--out", str(_folder(document, folder)))


def read_picture(document: Document, folder: Path) -> dict[str, str]:
    """Return the picture as a data address. Raises InputError if there is none."""
    path = _folder(document, folder) / "explain.png"
    try:
        data = path.read_bytes()[:MAX_PICTURE_BYTES]
    except OSError:
        raise InputError(f"{documents.SOURCE}: the effects of this walker have not been measured") from None
    return {"picture": web_page.data_url("image/png", data)}


def _folder(document: Document, folder: Path) -> Path:
    return folder / walker_answers.part_name(document)


WALKER_COUNT, RUN_S, DISH_DIAMETER_MM = 10, 6.0, 160.0
"""Number of walkers in the dish, their simulated time, s, and its diameter, mm."""

TRACK_COLUMNS = ("t_s", "particle", "x_mm", "y_mm", "theta_rad")


def crowd_arguments(document: Document, folder: Path) -> list[str]:
    """Return the words after `walkergen` that simulate them, and write their tracks below `folder`.

    They run on an open plate, those with a motor on a table. Raises InputError.
    """
    own = {key: value for key, value in document.values.items() if not key.startswith("scene.")}
    free = document._replace(scene=choose_scene(None, [document.load_design()], PLANE_SCENE), values=own)
    run = f"--count {WALKER_COUNT} --seconds {RUN_S:g} --runs 1 --arena disc:{DISH_DIAMETER_MM:g} --no-pictures".split()
    return documents.arguments(free, "crowd", *run, "--json", "--out", str(_folder(document, folder)))


def read_playback(document: Document, folder: Path) -> dict[str, Any]:
    """Read the outline of a walker from above and the poses of all, (x, y) mm and heading, by times in s."""
    path = _folder(document, folder) / "tracks" / "run-0.csv"
    table = columns.read_numbers(path, TRACK_COLUMNS)
    rows = np.column_stack([table.values[key] for key in TRACK_COLUMNS])
    times = np.unique(rows[:, 0])
    frames = rows[np.lexsort((rows[:, 1], rows[:, 0]))][:, 2:].reshape(len(times), -1, 3)
    corners = solids.build(document.load_design()).walker.vertices[:, [0, 2]] * [1.0, -1.0]
    hull = manifold3d.CrossSection.hull_points(corners).to_polygons()[0]
    return {
        "radius": 0.5 * DISH_DIAMETER_MM,
        "outline": np.round(hull - 0.5 * (hull.min(axis=0) + hull.max(axis=0)), 3).tolist(),
        "times": times.tolist(),
        "frames": np.round(frames, 3).tolist(),
    }
