"""The exported walker in MuJoCo, at any time step. Needs the extra `rivals`."""

import math
import re

import mujoco
import numpy as np

from evidence.work_precision.case import PERIODS_PER_POSE, Case, count_poses, draw_start, speed_along_heading

MESHES = re.compile(r'<mesh name[^>]*/>|<geom type="mesh"[^>]*/>')
"""Lines of the file that only show the walker."""


def simulate_speed(case: Case, steps_per_period: float, seconds: float, seed: int) -> float:
    """Return the mean speed (mm/s) of one run; NaN if it diverges."""
    interval = PERIODS_PER_POSE * case.period
    step = case.period / steps_per_period
    text = re.sub(r'timestep="[^"]*"', f'timestep="{step!r}"', MESHES.sub("", case.mjcf))
    model = mujoco.MjModel.from_xml_string(text)
    data, drive, start = mujoco.MjData(model), case.walker.scene.drive, draw_start(seed)
    data.qpos[0] = drive.amplitude * (math.sin(start.phase) - 1.0)  # of the plate, from its highest position
    data.qvel[0] = drive.amplitude * drive.omega * math.cos(start.phase)
    data.qpos[4:8] = start.quaternion
    poses = []
    for number in range(count_poses(seconds, case.period) + 1):
        if number:
            mujoco.mj_step(model, data, round(interval / step))
        if data.warning[mujoco.mjtWarning.mjWARN_BADQACC].number:
            return math.nan
        body = data.body("walker")
        along = body.xmat.reshape(3, 3)[:2, 0]
        poses.append([*body.xpos[:2], *along / np.linalg.norm(along)])
    return speed_along_heading(np.array(poses), interval)
