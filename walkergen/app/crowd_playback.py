"""Ten walkers of a page in a dish: the command that simulates them, and the data of its playback."""

from pathlib import Path
from typing import Any

import manifold3d
import numpy as np

from walkergen.app import document as documents
from walkergen.app import walker_answers
from walkergen.app.document import Document
from walkergen.core.files import columns
from walkergen.core.walker import solids
from walkergen.request import PLANE_SCENE, choose_scene

WALKER_COUNT, RUN_S, DISH_DIAMETER_MM = 10, 6.0, 160.0
"""Number of walkers in the dish, their simulated time, s, and its diameter, mm."""

TRACK_COLUMNS = ("t_s", "particle", "x_mm", "y_mm", "theta_rad")


def crowd_arguments(document: Document, folder: Path) -> list[str]:
    """Return the words after `walkergen` that simulate them, and write their tracks below `folder`.

    They run on an open plate, those with a motor on a table. Raises InputError.
    """
    own = {key: value for key, value in document.values.items() if not key.startswith("scene.")}
    free = document._replace(scene=choose_scene(None, [document.load_design()], PLANE_SCENE), values=own)
    run = (
        "--count",
        str(WALKER_COUNT),
        "--seconds",
        f"{RUN_S:g}",
        "--runs",
        "1",
        "--arena",
        f"disc:{DISH_DIAMETER_MM:g}",
        "--no-pictures",
    )
    return documents.arguments(free, "crowd", *run, "--json", "--out", str(folder / walker_answers.part_name(document)))


def read_playback(document: Document, folder: Path) -> dict[str, Any]:
    """Read the outline of a walker from above and the poses of all, (x, y) mm and heading, by times in s."""
    path = folder / walker_answers.part_name(document) / "tracks" / "run-0.csv"
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
