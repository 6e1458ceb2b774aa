"""Ranges of sliders that a walker can be built in, found by trying."""

import time
from collections.abc import Sequence

from walkergen.app import form
from walkergen.app.document import Document
from walkergen.core.errors import WalkergenError
from walkergen.core.walker import solids

BISECTIONS = 7
"""Halvings of what is not known of an end: it errs by less than a hundredth of the range."""

MIN_RANGE_SHARE = 0.05
"""Least share of its range that a slider keeps: one that cannot move would say nothing."""

MAX_CPU_S = 0.6
"""Time of a core after which sliders that are left keep the range of their key, s: solids of some bodies take long."""


def slider_ranges(document: Document, keys: Sequence[str]) -> dict[str, tuple[float, float]]:
    """Find the range of each slider that the walker can be built with, all other keys unchanged.

    Keys of a scene or a printer change no walker and are left out. Raises InputError for an invalid document.
    """
    controls = {control.key: control for group in form.groups(document) for control in group.controls}
    end, ranges = time.process_time() + MAX_CPU_S, {}
    for key in keys:
        control = controls.get(key)
        if control is None or control.slider is None or key.startswith(("scene.", "printer.")):
            continue
        if time.process_time() > end:
            break
        low, high = (_find_end(document, key, float(control.value), far) for far in control.slider)
        if high - low > MIN_RANGE_SHARE * (control.slider[1] - control.slider[0]):
            ranges[key] = (low, high)
    return ranges


def _find_end(document: Document, key: str, near: float, far: float) -> float:
    """Value nearest to `far` of those that were tried from a sound one on."""
    if _is_buildable(document, key, far):
        return far
    for _ in range(BISECTIONS):
        middle = 0.5 * (near + far)
        near, far = (middle, far) if _is_buildable(document, key, middle) else (near, middle)
    return near


def _is_buildable(document: Document, key: str, value: float) -> bool:
    try:
        solids.mass_of(document._replace(values={**document.values, key: value}).load_design().unmarked)
    except WalkergenError:
        return False
    return True
