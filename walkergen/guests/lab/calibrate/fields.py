"""Fields of the request of `calibrate`."""

from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from walkergen import print_fields, request
from walkergen.request import Flag


class CalibrateFields(request.Request):
    """Choices of `calibrate`."""

    by_position: ClassVar = ("what", "design", "scene")

    what: Annotated[
        Any,
        request.AsText,
        Flag("Filled form of `calibrate plate`; or plate; or drop.", "WHAT", takes="Name | None", argument=True),
    ] = None
    design: request.Filmed = request.PAPER_WALKER
    tilt: request.Tilt = None
    legs: request.Legs = None
    scene: request.Ground = request.LANE_SCENE
    restitution: request.Restitution = None
    friction: request.Friction = None
    by: Annotated[
        Literal["deflection", "ring", "both"], Flag("Method for Young's modulus: deflection, ring or both.", "METHOD")
    ] = "both"
    roll_deg: Annotated[
        float,
        Field(ge=0.0, le=20.0),
        Flag("Deviation of pitch and roll of drops from the hand, deg; 0: all are released flat.", "DEG"),
    ] = 1.0
    drops: Annotated[int, Field(ge=2, le=1000), Flag("Simulated drops from the hand for each point.", "N")] = 24
    seed: request.Seed = None
    measured: Annotated[
        float | None,
        Field(ge=1e-9, le=1.0, description="rebound of a drop: square root of the height after over the height before"),
        Flag("Rebound of a drop: square root of the height after over the height before.", "NUMBER"),
    ] = None
    measured_sd: Annotated[float | None, Field(ge=1e-9, le=1.0), Flag("Standard error of --measured.", "NUMBER")] = None
    tries: Annotated[int, Field(ge=1, le=10_000), Flag("Number of drops in the measured mean.", "N")] = 1
    height_mm: Annotated[float, Field(ge=0.01, le=1000.0), Flag("Height of the drop, mm.", "MM")] = 10.0
    printer: print_fields.Machines = request.DEFAULT_PRINTER
    max_plates: print_fields.MaxPlates = None
    prusaslicer: print_fields.ForPrusaSlicer = False
    strict: print_fields.Strict = False
    plate: Annotated[
        Path | None, request.File, Flag("Recording of an accelerometer on the plate, CSV.", "FILE", takes="Name | None")
    ] = None
    set: request.Settings = {}
    pictures: request.Pictures = True
    out: request.Out = None
