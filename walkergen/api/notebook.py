"""Display of a walker in a notebook: on its feet in 3D, with its properties in a table."""

from collections.abc import Iterator
from html import escape

from walkergen.core.errors import WalkergenError
from walkergen.core.walker import names, solids
from walkergen.core.walker.design import Design
from walkergen.files import viewer


def html(design: Design) -> str:
    """Return HTML with a 3D view of the walker, and a table of its properties below it.

    For a walker that cannot be built, or cannot stand, the table has the reason.
    """
    rows, shown = list(_rows(design)), ""
    try:
        built = solids.build(design)
        shown = viewer.render_frame(
            [viewer.Part(names.part_name(design), design.kind, *built.walker_with_cap)], design.name
        )
        mass = solids.weigh(design, built)
        rows.append(("mass (g)", f"{float(mass.total):.4g}"))
    except WalkergenError as error:
        rows.append(("cannot be shown" if not shown else "mass unknown", str(error)))
    cells = (f"<tr><th>{escape(name)}</th><td>{escape(value)}</td></tr>" for name, value in rows)
    return f"{shown}<table><tbody>{''.join(cells)}</tbody></table>"


def _rows(design: Design) -> Iterator[tuple[str, str]]:
    """Yield the walker's properties: name with unit, and value."""
    size, legs = design.size, len(design.limbs)
    yield "walker", design.name
    if design.description:
        yield "description", design.description
    yield "legs", f"{legs}, {design.kind}"
    yield "tilt (deg)", f"{design.tilt_deg:g}"
    yield "body (mm)", f"{size.length:g} x {size.depth:g} x {size.thickness:g}"
    for name, part in design.parts.items():
        cylinder = part.cylinder
        yield name, f"{2.0 * cylinder.radius:g} x {cylinder.height:g} mm, {cylinder.mass:g} g"
    material = design.material
    constants = f"{material.density_g_cm3:g} g/cm³, {material.youngs_modulus_gpa:g} GPa"
    yield "material", constants
