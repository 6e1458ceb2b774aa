"""Unevenness: corners of the feet that differ in height from print to print.

Every run draws one print: independent normal heights of the corners, of the scene's standard
deviation, about their mean. Limit: zero is the even walker.
"""

import numpy as np
import numpy.typing as npt

from walkergen.core.errors import InputError
from walkergen.core.simulation.effects.effect import Case, Effect, Rule, decide_from_key

NAME, SWITCH, KEY = "unevenness", "unevenness", "feet.unevenness_um"

MAX_SD_RATIO = 0.1
"""Largest standard deviation over the length of a leg."""


def judge(case: Case) -> Effect:
    """Judge the effect: on when corners differ. The number is their standard deviation over the amplitude.

    Raises InputError for corners that differ as much as legs are long.
    """
    height = case.scene.feet.unevenness_um
    on, reason = decide_from_key(case, KEY, SWITCH)
    shortest = min(limb.length for limb in case.design.limbs)
    most = 1e3 * MAX_SD_RATIO * shortest
    if on and height > most:
        raise InputError(
            f"feet.unevenness_um = {height:g}: must lie in 0..{most:g} for legs of "
            f"{shortest:g} mm; prints differ by some 10 um"
        )
    amplitude = 1e3 * case.shaken.amplitude
    meaning = "standard deviation of corners' heights over the plate's amplitude"
    return Effect(NAME, on, height / amplitude, meaning, reason, SWITCH)


RULE = Rule(judge, SWITCH, usual={KEY: 10.0})


def sample_heights(case: Case, corners: int, rng: np.random.Generator) -> npt.NDArray[np.float64]:
    """Draw the heights of the corners of one print, mm, with mean zero."""
    heights = 1e-3 * case.scene.feet.unevenness_um * rng.normal(size=corners)
    return np.asarray(heights - heights.mean())
