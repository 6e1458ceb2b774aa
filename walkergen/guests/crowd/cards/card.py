"""Card of a walker: its parameters for a crowd in a plane, each number with its error.

A card is measured from runs or films (`walkergen crowd --card`), written as JSON, and read again by the
flat model of a crowd. Its frame is the walker seen from above: heading along +x, C at the origin.
"""

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from pydantic import (
    Field,
    PlainSerializer,
    ValidationInfo,
    ValidatorFunctionWrapHandler,
    WrapValidator,
    field_validator,
    model_validator,
)

from walkergen.core import InputError, Quantity, read_json
from walkergen.core.errors import spell_for_python
from walkergen.core.files import config
from walkergen.core.files.config import Fraction, Friction, Name, Section

Size = Annotated[float, Field(gt=0, le=1e9)]
Value = Annotated[float, Field(ge=-1e9, le=1e9)]
Corner = Annotated[list[Value], Field(min_length=2, max_length=2)]
Contour = Annotated[list[Corner], Field(min_length=3, max_length=100_000)]

MIN_AREA_MM2 = 1e-6
"""Least area of a contour, mm^2."""

KEY_UNITS = ("mm2_s", "rad2_s", "rad_s", "mm_s", "per_mm", "s")
"""Units at the ends of a card's keys. A unit comes before any shorter unit at its own end: mm_s before s."""


class _Number(Section):
    """A measured number as a card's file stores it."""

    value: Value
    se: Annotated[float, Field(ge=0, le=1e9)] | None = None
    """Standard error; None if unknown."""
    runs: Annotated[int, Field(ge=1, le=10**9)] | None = None
    """Number of independent runs or films behind the value: one more than the degrees of freedom of its error."""


def _to_quantity(data: Any, validate: ValidatorFunctionWrapHandler, info: ValidationInfo) -> Quantity:
    """Return a number of the file (a dict) as a Quantity named after its field, and a Quantity unchanged."""
    if isinstance(data, Quantity):
        return data
    number: _Number = validate(data)
    return field_quantity(str(info.field_name), number.value, number.se, number.runs)


def _to_dict(quantity: Quantity) -> dict[str, Any]:
    """Return a quantity as a dict for the file: value, standard error and number of runs."""
    return {"value": quantity.value, "se": quantity.se, "runs": run_count(quantity)}


if TYPE_CHECKING:
    Measured = Quantity
else:  # A file contains a table. The validator turns it into a quantity.
    Measured = Annotated[_Number, WrapValidator(_to_quantity), PlainSerializer(_to_dict)]


def field_quantity(field: str, value: float, se: float | None = None, runs: int | None = None) -> Quantity:
    """Return the quantity of a card's `field` (a key that ends in its unit), measured in `runs` independent runs."""
    unit = next((unit for unit in KEY_UNITS if field.endswith(f"_{unit}")), "")
    return Quantity(field.removesuffix(f"_{unit}"), unit, value, se, math.inf if runs is None else runs - 1.0)


def run_count(quantity: Quantity) -> int | None:
    """Return the number of independent runs behind a card's number; None if not stated."""
    return None if math.isinf(quantity.freedom) else round(quantity.freedom) + 1


class Overdamped(Section):
    """Whether a model without inertia is enough for a walker."""

    enough: bool | None
    """None if the numbers, within their errors, allow both answers."""
    reason: str
    """Deciding numbers, as text."""


class Card(Section):
    """Properties of a walker for a crowd in a plane; None if not measured."""

    removed_keys: ClassVar[Mapping[str, str]] = dict.fromkeys(
        ("wall_alignment", "wall_turning_rad_s", "wall_torque_g_mm2_s2"),
        "No crowd used it. Leave the key out. `walkergen crowd --count 1` measures a walker in a dish with walls.",
    )

    name: Name
    scene: str = ""
    mass_g: Size
    inertia_g_mm2: Size
    """Inertia about the vertical axis through C."""
    outline_mm: Annotated[list[Contour], Field(min_length=1, max_length=2000)]
    """Outer contours seen from above, counter-clockwise, from C."""
    corner_radius_mm: Annotated[float, Field(ge=0, le=1e3)] = 0.0
    """Radius of the rounding of corners, inside the outline."""
    speed_mm_s: Measured
    """Mean speed along the heading, of a walker alone."""
    velocity_relaxation_s: Measured
    """Relaxation time of the velocity along the heading: mass over friction coefficient."""
    sideways_relaxation_s: Measured | None = None
    """Relaxation time of the velocity across the heading; None if equal to the one along the heading."""
    turning_rad_s: Measured
    """Mean turning rate."""
    turning_sd_rad_s: Measured | None = None
    """Standard deviation of the mean turning rate from print to print."""
    turning_relaxation_s: Measured | None = None
    """Relaxation time of the turning rate."""
    rotational_diffusion_rad2_s: Measured
    """D_R: the heading's squared change grows by 2 D_R t."""
    translational_diffusion_mm2_s: Measured
    """D_T along each axis: the part of a walker's spread that motion along its heading does not explain."""
    delay_s: Measured | None = None
    """Mean delay of the velocity behind the heading."""
    sideways_mm_s: Measured | None = None
    """Mean velocity to the left of the heading."""
    self_alignment_per_mm: Measured | None = None
    """Curvity: rate of turning toward a velocity across the heading, over that velocity."""
    restitution: Fraction = 0.5
    friction: Friction = 0.3
    """Restitution and friction of body on body."""
    wall_restitution: Fraction = 0.5
    wall_friction: Friction = 0.25
    overdamped: Overdamped | None = None

    @field_validator("outline_mm")
    @classmethod
    def _check_contours(cls, contours: list[Contour]) -> list[Contour]:
        """Return the contours. Raises ValueError for a contour that is clockwise or too small."""
        for number, contour in enumerate(contours, start=1):
            size = signed_area(contour)
            if size < MIN_AREA_MM2:
                raise ValueError(
                    f"contour {number} encloses {size:.3g} mm2: must be counter-clockwise and >= "
                    f"{MIN_AREA_MM2:g} mm2. Reverse the order of its corners, or repair them."
                )
        return contours

    @property
    def length_mm(self) -> float:
        """Extent of the outline along the heading, mm."""
        along = [x for contour in self.outline_mm for x, _ in contour]
        return max(along) - min(along)

    @property
    def propulsion_mm_s(self) -> float:
        """Speed v0 that propulsion alone would give, mm/s.

        It is above the mean speed along the heading if the walker turns, because its velocity lags behind. Valid for
        active Brownian particles with inertia, whose turning has no memory.
        """
        time_along, rotation = self.velocity_relaxation_s.number, self.rotational_diffusion_rad2_s.number
        time_across = time_along if self.sideways_relaxation_s is None else self.sideways_relaxation_s.number
        turning_term = self.turning_rad_s.number**2 * time_along * time_across
        return self.speed_mm_s.number * (1.0 + rotation * time_along + turning_term / (1.0 + rotation * time_across))

    @model_validator(mode="after")
    def _check_nonnegative(self) -> "Card":
        """Return the card. Raises ValueError for a negative relaxation time, diffusion or spread."""
        for key in (
            "velocity_relaxation_s",
            "rotational_diffusion_rad2_s",
            "translational_diffusion_mm2_s",
            "sideways_relaxation_s",
            "turning_relaxation_s",
            "turning_sd_rad_s",
        ):
            number = getattr(self, key)
            if number is not None and number.number < 0:
                raise ValueError(f"{key}.value = {number.number:g}: must be >= 0")
        return self


def signed_area(contour: Contour) -> float:
    """Return the area that a contour encloses, mm^2; negative if it runs clockwise."""
    after = [*contour[1:], contour[0]]
    return 0.5 * sum(x * v - u * y for (x, y), (u, v) in zip(contour, after, strict=True))


def read_card(path: Path) -> Card:
    """Read a card. Raises InputError for a file that is incomplete or has an invalid number."""
    data = read_json(path)
    if not isinstance(data, dict):
        raise InputError(f"{path}: is not a card. Use a file that `walkergen crowd --card` wrote.")
    return config.validate(data, Card, str(path), "")


def to_json(card: Card) -> bytes:
    """Return a card as the bytes of its JSON file. Equal cards give equal bytes."""
    data: dict[str, Any] = card.model_dump(mode="json")
    return spell_for_python(json.dumps(data, indent=1, ensure_ascii=False, allow_nan=False) + "\n").encode()
