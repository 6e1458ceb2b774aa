"""Ranges of sliders that give valid walkers, found by trial."""

import time
from collections.abc import Callable, Sequence
from functools import partial

from walkergen.app import form
from walkergen.app.document import Document
from walkergen.core.errors import WalkergenError
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design

ERROR = 1.000001 / 2**7
"""Largest error of an end of a range, relative to the searched interval. Seven halvings reach it."""

MIN_RANGE_SHARE = 0.05
"""Smallest range, relative to the whole range of the slider. A smaller one is dropped: the slider could hardly move."""

MAX_CPU_S = 0.6
"""CPU time, s, after which the remaining sliders keep their whole range. Building some bodies is slow."""


def slider_ranges(document: Document, keys: Sequence[str]) -> dict[str, tuple[float, float]]:
    """Return, by key, the range of each slider within which the walker can be built, all other keys unchanged.

    Keys of a scene or a printer, very narrow ranges, and ranges not found in time are left out. Raises InputError for
    an invalid document.
    """
    controls = {control.key: control for group in form.groups(document) for control in group.controls}
    end, ranges = time.process_time() + MAX_CPU_S, {}
    for key in keys:
        control = controls.get(key)
        if control is None or control.slider is None or key.startswith(("scene.", "printer.")):
            continue
        if time.process_time() > end:
            break
        value, design_at = float(control.value), partial(_design_with, document, key)
        low, high = (nearest_buildable(design_at, value, far, ERROR * abs(far - value)) for far in control.slider)
        if high - low > MIN_RANGE_SHARE * (control.slider[1] - control.slider[0]):
            ranges[key] = (low, high)
    return ranges


def nearest_buildable(design_at: Callable[[float], Design], near: float, far: float, error: float) -> float:
    """Find the value nearest to `far` at which a walker can be built, by bisection from `near`, where it can be built.

    `design_at`: returns the design for a value. `error`: largest error of the result.
    """

    def can_build(value: float) -> bool:
        try:
            solids.mass_of(design_at(value))
        except WalkergenError:
            return False
        return True

    if can_build(far):
        return far
    while abs(far - near) > error and (middle := 0.5 * (near + far)) not in (near, far):
        near, far = (middle, far) if can_build(middle) else (near, middle)
    return near


def _design_with(document: Document, key: str, value: float) -> Design:
    """Return the document's walker with another value of a key, and without engraved marks."""
    return document._replace(values={**document.values, key: value}).load_design().unmarked
