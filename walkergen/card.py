"""Card of a walker: what a crowd in a plane has to know of it, each number with its error.

A card is measured from runs or films (`walkergen card`), written as JSON, and read again by the
flat model of a crowd. Its frame is the walker seen from above: heading along +x, C at the origin.
"""

from typing import Annotated

from pydantic import Field, model_validator

from walkergen.files.config import Fraction, Name, Section

Size = Annotated[float, Field(gt=0, le=1e9)]
Value = Annotated[float, Field(ge=-1e9, le=1e9)]
Corner = Annotated[list[Value], Field(min_length=2, max_length=2)]
Contour = Annotated[list[Corner], Field(min_length=3, max_length=100_000)]


class Known(Section):
    """A measured number."""

    value: Value
    se: Annotated[float, Field(ge=0, le=1e9)] | None = None
    """Standard error; None where nothing tells it."""
    runs: Annotated[int, Field(ge=1, le=10**9)] | None = None
    """Independent runs or films that it is from."""


class Card(Section):
    """What a flat crowd has to know of a walker; None for what was not measured."""

    name: Name
    scene: str = ""
    mass_g: Size
    inertia_g_mm2: Size
    """Inertia about the vertical axis through C."""
    outline_mm: Annotated[list[Contour], Field(min_length=1, max_length=2000)]
    """Outer contours seen from above, counter-clockwise, from C."""
    corner_radius_mm: Annotated[float, Field(ge=0, le=1e3)] = 0.0
    """Radius of the rounding of corners, inside the outline."""
    speed_mm_s: Known
    """Mean speed along the heading, of a walker alone."""
    velocity_relaxation_s: Known
    """Time in which the velocity forgets a push: mass over friction coefficient."""
    turning_rad_s: Known
    """Mean turning rate."""
    turning_sd_rad_s: Known | None = None
    """Spread of that rate from print to print."""
    turning_relaxation_s: Known | None = None
    """Time in which the turning rate forgets a push."""
    rotational_diffusion_rad2_s: Known
    """D_R: the heading's squared change grows by 2 D_R t."""
    translational_diffusion_mm2_s: Known
    """D_T across and along the heading: the part of the spread that no heading explains."""
    delay_s: Known | None = None
    """Time by which the velocity's direction lags behind the heading."""
    restitution: Fraction = 0.5
    friction: Annotated[float, Field(ge=0, le=1e6)] = 0.3
    """Restitution and friction of body on body."""
    wall_restitution: Fraction = 0.5
    wall_friction: Annotated[float, Field(ge=0, le=1e6)] = 0.25

    @model_validator(mode="after")
    def _possible(self) -> "Card":
        for key in ("velocity_relaxation_s", "rotational_diffusion_rad2_s",
                    "translational_diffusion_mm2_s", "turning_relaxation_s",
                    "turning_sd_rad_s"):  # fmt: skip
            number = getattr(self, key)
            if number is not None and number.value < 0:
                raise ValueError(f"{key}.value = {number.value:g} must be >= 0")
        return self
