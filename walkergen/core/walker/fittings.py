"""Keys of the fittings of a walker: its marks, its cap, its motor, its battery and their pockets.

`marks`, `caps` and `pockets` build them. Motor and battery are cylinders with a position in the design's frame: along
and across from the middle of the body, up from its middle height. Their pockets are larger by a clearance.
"""

from collections.abc import Iterator, Mapping
from typing import Annotated, Literal, NamedTuple

from pydantic import Field, model_validator

from walkergen.core.files.config import Section
from walkergen.core.walker.body import Size
from walkergen.core.walker.limbs import Coordinate

MAX_SERIAL = 99_999
"""Largest serial number."""

POSITION_KEYS = ("along_mm", "up_mm", "across_mm")
"""Keys of a position, in the order of the design's axes x, y and z."""

MIN_FLOOR_MM = 0.4
"""Least thickness of the floor or wall of a pocket in the body's box, mm: two layers, or one printed line."""

MIN_PLATE_DISTANCE_MM = 0.5
"""Least distance of a part under the body from the plate, mm: the assumed deflection of the legs."""


class Marks(Section):
    """Settings of the marks that show the tilt of a part."""

    kind: Literal["none", "notches", "digits", "text"] = "none"
    text: Annotated[str, Field(min_length=1, max_length=40)] | None = None
    """Letters of kind "text", engraved: the same on every member of a family."""
    text_height_mm: Annotated[float, Field(ge=1e-3, le=1e4)] | None = None
    """Height of the capital letters. None: half the height of the marked face."""
    line_mm: Annotated[float, Field(ge=0.05, le=5)] = 0.4
    depth_mm: Annotated[float, Field(ge=1e-3, le=1e4)] = 0.4
    serial: Annotated[int, Field(ge=1, le=MAX_SERIAL)] | None = None
    """Number of one copy, engraved next to its mark. None: copies have no numbers."""

    @property
    def blank(self) -> bool:
        """Whether there is neither a mark nor a serial number."""
        return self.kind == "none" and self.serial is None

    @property
    def letters(self) -> str:
        """Letters to engrave: the text and the serial number, if they are given, or "" without both."""
        parts = (self.text or "", "" if self.serial is None else str(self.serial))
        return " ".join(part for part in parts if part)

    @model_validator(mode="after")
    def _check_text(self) -> "Marks":
        if (self.kind == "text") != (self.text is not None):
            other = "needs text" if self.text is None else "has no text. Give it kind = 'text'"
            raise ValueError(f'marks.kind = {self.kind!r} {other}: text and kind = "text" go together')
        return self


MARKER_CELLS, TILE_CELLS = 6, 8
"""Cells along the side of a marker, its black frame included, and of the tile that bears it."""

TILE_THICKNESS_MM = {"engraved": 1.0, "raised": 1.0, "paper": 0.1}
"""Default thickness of a tile, mm; that of a raised one is below its raised cells."""
PAPER_G_CM3 = 0.8
"""Density of paper: 80 g/m^2 of 0.1 mm."""


class Cap(Section):
    """Settings of the cap that shows a walker's number to a camera above it."""

    kind: Literal["engraved", "raised", "paper"] = "engraved"
    dictionary: Literal["4x4_50", "4x4_100"] = "4x4_50"
    number: Annotated[int, Field(ge=0, le=99)] = 0
    """Number of the marker. On plates it is the number of the first copy, and the others follow."""
    marker_mm: Annotated[float, Field(ge=1.0, le=120.0)] = 7.2
    """Side of the marker, its black frame included; the tile is 4/3 as wide."""
    thickness_mm: Annotated[float, Field(ge=0.02, le=20.0)] | None = None
    """Thickness of the tile. None: 1 mm, of paper 0.1 mm."""
    relief_mm: Annotated[float, Field(ge=0.02, le=5.0)] = 0.4
    """Depth of engraved cells, or height of raised ones; paper has none."""

    @model_validator(mode="after")
    def _check_number_and_relief(self) -> "Cap":
        if self.number >= self.count:
            raise ValueError(
                f"number = {self.number}: the markers of {self.dictionary!r} are numbered "
                f"0..{self.count - 1}" + ("" if self.count > 50 else ". For more, set dictionary = '4x4_100'")
            )
        if self.kind == "engraved" and self.relief_mm > 0.7 * self.thickness:
            raise ValueError(
                f"relief_mm = {self.relief_mm:g}: must be at most 0.7 times the tile's thickness, "
                f"{self.thickness:g} mm. Lower it, or raise thickness_mm"
            )
        return self

    @property
    def count(self) -> int:
        """Number of markers in the dictionary."""
        return int(self.dictionary.rpartition("_")[2])

    @property
    def cell(self) -> float:
        """Side of one square cell of the marker, mm."""
        return self.marker_mm / MARKER_CELLS

    @property
    def side(self) -> float:
        """Side of the square tile, mm."""
        return TILE_CELLS * self.cell

    @property
    def thickness(self) -> float:
        """Thickness of the tile, mm, without raised cells."""
        return TILE_THICKNESS_MM[self.kind] if self.thickness_mm is None else self.thickness_mm

    def density(self, material_g_cm3: float) -> float:
        """Return the density of the cap, g/cm^3: that of paper, or of the walker's material.

        Ink has no mass. A second colour is assumed to have the same density as the first.
        """
        return PAPER_G_CM3 if self.kind == "paper" else material_g_cm3


Direction = Literal["along", "across", "up"]
Opening = Literal["up", "down", "side"]
Extent = Annotated[float, Field(ge=0.5, le=100, description="coin motors and cells have 2 to 25")]
Gram = Annotated[float, Field(ge=1e-3, le=1e3, description="coin motors and cells weigh 0.5 to 4")]


class Cell(NamedTuple):
    """Size and mass of a standard coin cell."""

    diameter_mm: float
    height_mm: float
    mass_g: float


COIN_CELLS = {"CR2032": Cell(20.0, 3.2, 2.9), "LR44": Cell(11.6, 5.4, 2.0)}
"""Coin cells by their names in IEC 60086, with its largest sizes. Masses are from data sheets: Panasonic's of the
CR2032 (other makers state 2.8 to 3.2 g), and those of LR44 and A76 (1.8 to 2.1 g)."""


class Cylinder(NamedTuple):
    """Solid of a motor or a battery, without clearance."""

    radius: float
    """Radius, mm."""
    height: float
    """Height along its axis, mm."""
    mass: float
    """Mass, g."""
    centre: tuple[float, float, float]
    """Position of its middle from the middle of the body, mm: x along, y up, z across."""
    axis: int
    """Index of its axis: 0 along, 1 up, 2 across."""

    @property
    def half(self) -> tuple[float, float, float]:
        """Half the cylinder's extent along x, y and z, mm."""
        x, y, z = (0.5 * self.height if i == self.axis else self.radius for i in range(3))
        return x, y, z

    def centre_in_design(self, depth: float) -> tuple[float, float, float]:
        """Return the cylinder's middle, mm, in the design's frame, where a body of this depth (mm) begins at z = 0."""
        x, y, z = self.centre
        return x, y, z + 0.5 * depth


class Part(Section):
    """Part in a pocket of the body: its position, and the opening of the pocket."""

    along_mm: Coordinate = 0.0
    """Position of its middle along the body, from the middle of the body."""
    across_mm: Coordinate = 0.0
    """Position of its middle across the body, from the middle of the body."""
    up_mm: Coordinate = 0.0
    """Height of its middle above the middle of the body."""
    opens: Opening = "up"
    """Side of the body where its pocket opens. "side" is the upper side of a walker that prints on its side."""

    @property
    def cylinder(self) -> Cylinder:
        """Cylinder that the part fills."""
        raise NotImplementedError

    def _make_cylinder(self, diameter: float, height: float, mass: float, axis: Direction) -> Cylinder:
        """Return a cylinder of this size (mm), mass (g) and axis at the part's position."""
        centre = (self.along_mm, self.up_mm, self.across_mm)
        return Cylinder(0.5 * diameter, height, mass, centre, ("along", "up", "across").index(axis))


class Motor(Part):
    """Motor with an unbalanced rotor, by default a coin motor on its edge.

    Common sizes are 10 x 2.7 mm (about 1 g), 8 x 2.5 mm and 12 x 3.4 mm.
    """

    diameter_mm: Extent = 10.0
    height_mm: Extent = 2.7
    mass_g: Gram = 1.0
    """Mass of the whole motor with its rotor."""
    axis: Direction = "across"
    """Axis of the cylinder and of its rotor."""

    @property
    def cylinder(self) -> Cylinder:
        """Cylinder that the motor fills."""
        return self._make_cylinder(self.diameter_mm, self.height_mm, self.mass_g, self.axis)


class Battery(Part):
    """Battery of a standard shape or of given sizes; by default it lies flat."""

    shape: Literal["CR2032", "LR44"] | None = None
    """Standard coin cell, with its sizes and mass."""
    diameter_mm: Extent | None = None
    height_mm: Extent | None = None
    mass_g: Gram | None = None
    """Weighed mass. None: the mass of the standard coin cell."""
    axis: Direction = "up"

    @model_validator(mode="after")
    def _check_size(self) -> "Battery":
        given = [key for key in ("diameter_mm", "height_mm") if getattr(self, key) is not None]
        if self.shape is not None and given:
            raise ValueError(f"{given[0]} follows from shape = {self.shape!r}: keep one of them")
        if self.shape is None and (len(given) < 2 or self.mass_g is None):
            raise ValueError(
                f"a battery needs shape, one of {', '.join(COIN_CELLS)}, or diameter_mm, height_mm and mass_g"
            )
        return self

    @property
    def cylinder(self) -> Cylinder:
        """Cylinder that the battery fills."""
        standard = COIN_CELLS.get(self.shape or "", Cell(0.0, 0.0, 0.0))
        return self._make_cylinder(
            self.diameter_mm or standard.diameter_mm,
            self.height_mm or standard.height_mm,
            self.mass_g or standard.mass_g,
            self.axis,
        )


class Pockets(Section):
    """Pockets of motor and battery, with wires in a channel, and glue."""

    clearance_mm: Annotated[float, Field(ge=0, le=2, description="printers state theirs: pocket_clearance_mm")] = 0.2
    """Gap on every side between a part and the wall of its pocket."""
    channel_mm: Annotated[float, Field(ge=0, le=5, description="0 for no channel")] = 1.0
    """Width and height of the channel for the wires from motor to battery. 0: none."""
    wires_g: Annotated[float, Field(ge=0, le=100)] = 0.1
    """Mass of the wires, spread evenly from the middle of the motor to that of the battery."""
    glue_g: Annotated[float, Field(ge=0, le=100)] = 0.1
    """Mass of the glue, shared by motor and battery and distributed like them."""


def find_fit_problems(parts: Mapping[str, Part], pockets: Pockets, size: Size, foot_height: float) -> list[str]:
    """Return a message for each size or position with which a part does not fit into the body's box.

    Parameters
    ----------
    parts : mapping
        Motor and battery, by the names of their tables.
    pockets : Pockets
        Settings of the pockets.
    size : Size
        Size of the body's box, mm.
    foot_height : float
        Height of the lowest foot from the middle of the body, mm. It is negative.

    Returns
    -------
    list of str
        Messages. Whether plastic surrounds a pocket in a body of any shape is checked by `pockets.cut_pockets`.
    """
    return [
        f"{name}.{problem}"
        for name, part in parts.items()
        for problem in _part_problems(name, part, pockets.clearance_mm, size, foot_height)
    ]


def _part_problems(name: str, part: Part, clearance: float, size: Size, foot_height: float) -> Iterator[str]:
    """Yield the faults of a part that does not fit into the body's box. Messages begin with a key of the part."""
    cylinder = part.cylinder
    for axis, key in enumerate(POSITION_KEYS):
        value, half = cylinder.centre[axis], cylinder.half[axis] + clearance
        low, high = _position_limits(part.opens, axis, half, size[axis])
        if low > high:
            size_key = "height_mm" if axis == cylinder.axis else "diameter_mm"
            needed = 2.0 * (half + MIN_FLOOR_MM)
            yield (
                f"{size_key} = {2.0 * (half - clearance):g}: its pocket needs a body of "
                f"{needed:.4g} mm {key.removesuffix('_mm')}, but this one has {size[axis]:.4g} mm. Make "
                "the body larger, or turn the part (axis)."
            )
        elif not low <= value <= high:
            is_too_deep = value > high if part.opens == "down" else value < low
            opens_along_axis = axis == 1 or (axis == 2 and part.opens == "side")
            what = f"the {name} leaves the body"
            if is_too_deep and opens_along_axis:
                what = "its pocket is deeper than the body"
            yield (
                f"{key} = {value:g}: {what}. It must lie in {low:.4g}..{high:.4g} mm, so that "
                f"floor and walls keep {MIN_FLOOR_MM:g} mm. Move it, or make the body larger."
            )
    gap = cylinder.centre[1] - cylinder.half[1] - foot_height
    low, _ = _position_limits(part.opens, 1, cylinder.half[1] + clearance, size.thickness)
    if gap < MIN_PLATE_DISTANCE_MM and cylinder.centre[1] >= low:
        yield (
            f"up_mm = {cylinder.centre[1]:g}: the {name} ends {gap:.3g} mm above the plate. It needs "
            f"at least {MIN_PLATE_DISTANCE_MM:g} mm. Move it up, or make the legs longer."
        )


def _position_limits(opens: Opening, axis: int, half_width: float, body_size: float) -> tuple[float, float]:
    """Return the range, mm from the body's middle, in which a pocket's middle may lie along axis 0, 1 or 2 (x, y, z).

    `half_width` is half the size of the pocket along this axis, and `body_size` the size of the body, mm.
    """
    limit = 0.5 * body_size - MIN_FLOOR_MM - half_width
    low, high = -limit, limit
    if axis == 1 and opens == "down":
        low = MIN_FLOOR_MM - 0.5 * body_size - half_width
    elif axis == 1:
        high = 0.5 * body_size + half_width - MIN_FLOOR_MM
    elif axis == 2 and opens == "side":
        high = 0.5 * body_size - half_width
    return low, high
