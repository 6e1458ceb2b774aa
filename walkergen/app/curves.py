"""Curve of a page: predicted speed against tilt, over the tilts that can be built."""

from functools import lru_cache

import numpy as np

from walkergen.app.document import Document
from walkergen.app.slider_ranges import nearest_buildable
from walkergen.core.scene import Scene
from walkergen.core.theory import prediction
from walkergen.core.walker.design import Design

MAX_CURVE_TILT_DEG = 45.0
"""Largest tilt of the curve, unless the tilt of the walker is larger."""

TILT_TOLERANCE_DEG = 0.2
"""Largest error of the end of the curve, if it ends at the largest tilt at which the walker can be built."""

JOINED_POINTS, ROUGH_POINTS = 19, 13
"""Number of points of the curve for bodies to which legs must be joined, which is slow, and while sliders move."""

MAX_CACHED_CURVES = 32
"""Number of cached curves."""

Curve = dict[str, list[float | None]]


def speed_curve(document: Document, rough: bool) -> Curve | None:
    """Predict the walker's speed (mm/s) and its bounds against tilt (deg), for all tilts at which it can be built.

    Parameters
    ----------
    document : Document
        Document of the page. The curve does not depend on the tilt of its walker.
    rough : bool
        True for fewer points.

    Returns
    -------
    dict of list or None
        Columns of the curve. Speeds are None at tilts that need a simulation. None instead of a curve if the legs share
        no tilt, or if no other tilt can be built.

    Raises
    ------
    InputError
        If the document is invalid.
    """
    design, scene = document.load_design(), document.load_scene()
    if not design.has_family_tilt:
        return None
    steepest = max(MAX_CURVE_TILT_DEG, abs(design.tilt_deg))

    def with_tilt(tilt_deg: float) -> Design:
        return design.unmarked.variant(tilt_deg=tilt_deg)

    low = nearest_buildable(with_tilt, design.tilt_deg, -steepest if design.tilt_deg < 0.0 else 0.0, TILT_TOLERANCE_DEG)
    sections = (design.unmarked.variant(tilt_deg=low), scene)
    walker, ground = (section.model_dump_json(exclude_unset=True) for section in sections)
    high = nearest_buildable(with_tilt, design.tilt_deg, steepest, TILT_TOLERANCE_DEG)
    return _compute_curve(walker, ground, design.body.cache_key, low, high, rough) if low < high else None


def speed_curve_table(document: Document, rough: bool) -> dict[str, Curve | None]:
    """Return {"curve": speed curve}. A result of None would mean that the page is closed."""
    return {"curve": speed_curve(document, rough)}


@lru_cache(maxsize=MAX_CACHED_CURVES)
def _compute_curve(design: str, scene: str, body: str, low: float, high: float, rough: bool) -> Curve | None:
    """Compute the speed curve between two tilts (deg) from design and scene as JSON. `body`: hash of its files."""
    walker, ground = Design.model_validate_json(design), Scene.model_validate_json(scene)
    count = (
        ROUGH_POINTS if rough else prediction.CURVE_POINTS if walker.body.plain and not walker.parts else JOINED_POINTS
    )
    drawn = prediction.predict_curve(walker, ground, "coulomb", low, high, count)
    if np.isfinite(drawn.speed).sum() < 2:
        return None
    columns = dict(zip(("low_95", "low_68", "high_68", "high_95"), drawn.bounds, strict=True))
    columns |= {"tilt_deg": drawn.tilt_deg, "speed": drawn.speed}
    return {name: [None if np.isnan(each) else each for each in values.tolist()] for name, values in columns.items()}
