"""Run of one walker in space, for a viewer to play."""

import base64
from typing import Any

import numpy as np

from walkergen.core import ENDED_WELL, Array, Design, InputError, Scene, mass_of, part_name, prepare
from walkergen.guests.movie.shot import point_in_mesh
from walkergen.points import poses

POSES_PER_SECOND = 2000.0
"""Poses for each simulated second: every bounce is visible at a hundredth of real time."""


def record_run(design: Design, scene: Scene, seconds: float) -> dict[str, Any]:
    """Simulate a run of `seconds` and return data for the page's viewer. Raises InputError if it ends immediately."""
    mass = mass_of(design)
    short = scene.run.model_copy(update={"seconds": seconds})
    motion = poses.sample(prepare(scene.model_copy(update={"run": short}), design, mass), 1.0 / POSES_PER_SECOND)
    if len(motion.times) < 2:
        raise InputError(f"{scene.name}: the run ended immediately ({motion.outcome.value})")
    return _pack_poses(motion, point_in_mesh(design, mass)) | {"words": _caption(motion, scene, part_name(design))}


def _pack_poses(motion: poses.Poses, O: Array) -> dict[str, Any]:  # noqa: E741
    """Pack poses and landings for the page's viewer, as little-endian float32 in base64.

    `O`: the walker's reference point in its mesh, shape (3,), mm. A pose is a shift (mm) and a quaternion (x, y, z,
    scalar) of the mesh. A landing is time (s), corner and impulse over the largest. `plate`: heights (mm), if it moves.
    """
    R = motion.rotations
    shift = motion.places - R @ O
    rows = np.column_stack([shift, motion.turns[:, [1, 2, 3, 0]]])
    times, corner, along, upward = motion.landings[:, :4].T
    impulse = np.hypot(along, upward)
    landings = np.column_stack([times, corner, impulse / max(impulse.max(initial=0), 1e-9)])
    corners = (motion.corners[0] - motion.places[0]) @ R[0] + O
    moving = {"plate": _to_base64(motion.plate)} if np.ptp(motion.plate) > 0.0 else {}
    return moving | {
        "interval": float(motion.times[1]),
        "poses": _to_base64(rows),
        "landings": _to_base64(landings),
        "closed": base64.b64encode(np.packbits(motion.closed, axis=1).tobytes()).decode(),
        "corners": corners.round(4).tolist(),
    }


def _caption(motion: poses.Poses, scene: Scene, name: str) -> str:
    """Describe a simulated run, its scene and its duration in a line. `name`: name of the walker."""
    drive = scene.drive
    ended = "" if motion.outcome in ENDED_WELL else f"; it ended: {motion.outcome.value}"
    shaking = drive.motor_in_words or (
        f"{drive.frequency:g} Hz, {drive.peak_gamma:.3g} g, plate ± {1e3 * drive.amplitude:.3g} µm"
    )
    return (
        f"{name} in {scene.name}: {shaking}, feet of restitution "
        f"{scene.contact.restitution:g}, friction {scene.contact.friction:g}; "
        f"{motion.times[-1]:.3g} s{ended}"
    )


def _to_base64(values: Array) -> str:
    """Return numbers as little-endian float32 in base64."""
    return base64.b64encode(values.astype("<f4").tobytes()).decode()
