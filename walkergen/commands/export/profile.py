"""Profiles: a walker's side view as polygons, and drawings of it for laser cutters.

A walker that prints on its side is a prism: its profile and its depth define it, except for engraved digits. The
drawing of a body in plan view is its outline, without legs.
"""

from collections.abc import Callable, Sequence

import numpy as np

from walkergen.core.errors import InputError, SolidError
from walkergen.core.shapes.modeller import MIN_WINDOW_RATIO
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.readers.drawings import dxf, svg
from walkergen.readers.drawings.outlines import Polygon

FORMATS: dict[str, Callable[[Sequence[Polygon]], bytes]] = {"dxf": dxf.pack, "svg": svg.pack}
"""Formats of drawings."""


def drawing_outlines(design: Design) -> list[Polygon]:
    """Return the polygons, mm, of a walker that is a prism: outer contours first, then holes.

    For a body in plan view they are the outline of the body from above, without legs. Otherwise they are the side view
    of body and legs. Raises InputError for a walker that is no prism.
    """
    depth, why = design.size.depth, "its legs are narrower than its body"
    if design.parts:
        why = f"its body has pockets ({', '.join(design.parts)})"
    elif design.body.flat and design.shape.mesh is not None:
        why = "it stands on a base plate"
    elif design.body.flat:
        return list(design.shape.plan)
    elif solids.is_printed_on_side(design) and all(limb.width == depth for limb in design.limbs):
        return side_profile(design)
    elif design.body.mesh:
        why = "its body is a mesh"
    raise InputError(f"{design.name}: has no drawing as {' or '.join(FORMATS)}: {why}. Export it as stl or 3mf.")


def side_profile(design: Design) -> list[Polygon]:
    """Return the side view of body and legs, in the design's frame, mm: outer contour first, then holes.

    Raises SolidError when it is not one piece.
    """
    import shapely

    body, limbs = solids.side_view(design)
    legs = [part + np.array(limb.anchor) for limb, parts in zip(design.limbs, limbs, strict=True) for part in parts]
    united = shapely.union_all([shapely.Polygon(part) for part in (body, *legs)])
    if not isinstance(united, shapely.Polygon):
        raise SolidError(f"{design.name}: its side view is not one piece. Make the legs touch the body.")
    least = MIN_WINDOW_RATIO * united.area  # as in the solid: slivers are no windows
    holes = [ring for ring in united.interiors if shapely.Polygon(ring).area > least]
    oriented = shapely.orient_polygons(shapely.Polygon(united.exterior, holes))
    rings = (oriented.exterior, *oriented.interiors)
    return [np.array(ring.coords, dtype=np.float64)[:-1, :2] for ring in rings]
