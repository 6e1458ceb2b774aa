"""Tilts at which the theory's speed is largest, over realistic contacts."""

from typing import NamedTuple

import numpy as np

from walkergen.core.theory.speed import Mode, factors
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design

RESTITUTIONS, FRICTIONS = np.linspace(0.5, 1.0, 11), np.linspace(0.05, 0.4, 15)
"""Values that we take for the paper's "wide range of realistic values"."""


class Range(NamedTuple):
    """Range of tilts of the theory's maximum over RESTITUTIONS x FRICTIONS, deg."""

    mode: Mode
    low_deg: float
    high_deg: float


def find_tilts(design: Design, mode: Mode) -> Range:
    """Tilts of the theory's largest speed over realistic contacts, to 0.25 deg within 0.25..25."""
    tried = np.arange(0.25, 25.1, 0.25)
    e, mu = np.meshgrid(RESTITUTIONS, FRICTIONS)
    speeds = [factors(solids.mass_of(design.variant(tilt_deg=float(tilt))), e, mu, mode).mean for tilt in tried]
    tops = tried[np.argmax(speeds, axis=0)]
    return Range(mode, float(tops.min()), float(tops.max()))
