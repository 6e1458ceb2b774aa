"""Fields of the request of `fit`."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator

from walkergen import field_values, request
from walkergen.request import Flag


def _parse_fixed(value: Any) -> list[str]:
    """Return the parameters to hold as texts NAME=VALUE, from such texts or from a mapping {NAME: VALUE}."""
    return (
        [f"{name}={number!r}" for name, number in value.items()]
        if isinstance(value, Mapping)
        else field_values.parse_texts(value)
    )


class FitFields(request.Request):
    """Choices of `fit`."""

    by_position: ClassVar = ("speeds", "design", "scene")

    speeds: Annotated[Path, request.File, Flag("File of measured speeds.", "SPEEDS.csv", takes="Name", argument=True)]
    design: request.Filmed = request.PAPER_WALKER
    scene: request.Ground = request.LANE_SCENE
    model: Annotated[
        Literal["prediction", "theory", "space"],
        Flag("Model: prediction (as in family), theory, or space (simulated, minutes).", "MODEL"),
    ] = "prediction"
    fix: Annotated[
        list[str],
        BeforeValidator(_parse_fixed),
        Flag(
            "Parameter to hold: friction=0.25.", "NAME=VALUE", takes="Mapping[str, float] | Iterable[str]", repeats=True
        ),
    ] = []
    prior: Annotated[
        Literal["flat", "scene"] | None,
        Flag("Prior of restitution and friction: as in the scene (scene, the default), or flat.", "PRIOR"),
    ] = None
    predict: Annotated[
        list[float] | None,
        BeforeValidator(field_values.parse_tilts),
        Flag(
            "Tilts to predict: 8,12 or FIRST:LAST:STEP; else the family's.",
            "DEG",
            takes="float | Iterable[float] | str | None",
        ),
    ] = None
    mode: request.Mode = "coulomb"
    seed: request.Seed = None
    set: request.Settings = {}
    pictures: request.Pictures = True
    out: request.Out = None
