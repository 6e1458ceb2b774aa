"""Units that a file may be drawn in: asked back where a body has no walker's size."""

from walkergen.errors import InputError

SMALLEST, LARGEST = 1.0, 500.0
"""Least and greatest length of the longest side of a body, mm, that is taken without asking back."""

UNITS = {"inches": 25.4, "metres": 1000.0, "centimetres": 10.0, "micrometres": 1e-3}
"""Millimetres of other units."""


def refuse(size: float, source: str, scale_mm: float = 1.0) -> None:
    """Raise InputError, which begins with `source`, with what a body would be in other units, for no walker's size.

    `size`, mm, is that of the longest side, `scale_mm` the millimetres of the file's unit that it was read with.
    """
    if SMALLEST < size <= LARGEST:
        return
    readings = [
        f"{name} ({size * unit:.4g} mm; scale_mm = {scale_mm * unit:g})"
        for name, unit in UNITS.items()
        if SMALLEST <= size * unit <= LARGEST
    ]
    ask = f"is it in {' or '.join(readings)}? Or give" if readings else "give"
    raise InputError(
        f"{source}: the longest side is {size:.4g} mm at scale_mm = {scale_mm:g}, must lie in "
        f"{SMALLEST:g}..{LARGEST:g} mm: {ask} the length that it shall have, length_mm"
    )
