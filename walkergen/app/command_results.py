"""Command lines that a page runs on its walker, and their results: effects of the scene, and ten walkers in a dish."""

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
    """Return the command line that measures each effect of the scene and draws them below `folder`."""
    return documents.arguments(document, "explain", "--measure", "--json", "--out", str(_folder(document, folder)))


def read_picture(document: Document, folder: Path) -> dict[str, str]:
    """Return the figure of the effects below `folder` as {"picture": data URL}. Raises InputError if there is none."""
    path = _folder(document, folder) / "explain.png"
    try:
        data = path.read_bytes()[:MAX_PICTURE_BYTES]
    except OSError:
        message = f"{documents.SOURCE}: the effects of this walker have not been measured. Measure them first."
        raise InputError(message) from None
    return {"picture": web_page.data_url("image/png", data)}


def _folder(document: Document, folder: Path) -> Path:
    """Return the folder below `folder` for results of the page's walker."""
    return folder / walker_answers.part_name(document)


WALKER_COUNT, RUN_S, DISH_DIAMETER_MM = 10, 6.0, 160.0
"""Number of walkers in the dish, their simulated time, s, and its diameter, mm."""

TRACK_COLUMNS = ("t_s", "particle", "x_mm", "y_mm", "theta_rad")


def crowd_arguments(document: Document, folder: Path) -> list[str]:
    """Return the command line that simulates ten walkers in a dish and writes their tracks below `folder`.

    The scene is an open plate, or a table for walkers with a motor. Raises InputError.
    """
    walker_values = {key: value for key, value in document.values.items() if not key.startswith("scene.")}
    scene = choose_scene(None, [document.load_design()], PLANE_SCENE)
    changed = document._replace(scene=scene, values=walker_values)
    run = f"--count {WALKER_COUNT} --seconds {RUN_S:g} --runs 1 --arena disc:{DISH_DIAMETER_MM:g} --no-pictures".split()
    return documents.arguments(changed, "crowd", *run, "--json", "--out", str(_folder(document, folder)))


def read_playback(document: Document, folder: Path) -> dict[str, Any]:
    """Read the result of `crowd_arguments` for playback, as JSON values.

    Keys: `radius` of the dish (mm), `outline` of a walker from above (mm), `times` (s), and `frames`, a list of poses
    (x mm, y mm, heading rad) of all walkers for each time.
    """
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
