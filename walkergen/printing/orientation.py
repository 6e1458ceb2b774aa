"""Orientation of walkers on the bed, in words for people; the meshes are solids.as_printed's."""

from collections.abc import Sequence

from walkergen.printing.slicer import Setting
from walkergen.walker import names, solids
from walkergen.walker.design import Design

ON_SIDE = "on its side, no supports"

LEGS_UP = (
    "upside down, flat on its upper side, legs up; no supports up to 45 deg of tilt, unless the "
    "checks tell of a body over air"
)


def words(design: Design) -> str:
    """Say how a walker lies on the bed, and with which supports."""
    return ON_SIDE if solids.on_side(design) else LEGS_UP


def settings(members: Sequence[Design]) -> list[Setting]:
    """Lines of a print sheet on how its walkers lie; where they differ, each names its designs."""
    lying: dict[str, list[str]] = {}
    for name, own in names.by_design(members).items():
        lying.setdefault(words(own[0]), []).append(name)
    return [
        Setting(
            "orientation" if len(lying) == 1 else f"orientation of {', '.join(designs)}",
            f"as in the file: {way}",
            "layers run across the leg's width" if way == ON_SIDE else "layers lie across the leg: weaker, softer",
        )
        for way, designs in lying.items()
    ]
