"""Request of `fit`."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator

from walkergen import field_values, request
from walkergen.core.files.progress import Progress
from walkergen.request import Flag

if TYPE_CHECKING:
    from walkergen.guests.lab.fit.report import FitReport


def _parse_fixed(value: Any) -> list[str]:
    """Return the parameters to hold, NAME=VALUE, from texts or from {NAME: VALUE}."""
    return (
        [f"{name}={number!r}" for name, number in value.items()]
        if isinstance(value, Mapping)
        else field_values.parse_texts(value)
    )


class FitRequest(request.Request):
    """Estimate the contact from measured speeds, and predict walkers that were not measured.

    The CSV file has columns tilt_deg, speed_mm_s and, if known, speed_se_mm_s, legs (flexible or braced; otherwise the
    design's) and plate_speed_mm_s (otherwise the scene's). A row is one print, its standard error that of its film. In
    place of a speed, a column tracks may name the tracks.csv of a film: a row for each of its walkers, or for the one
    in a column particle. By default the fit takes seconds and uses the model of `predict`. A simulated model is fitted
    with emulators. Both give bands for one more print at every tilt. The theory, the paper's eq. 15, is fitted by least
    squares. All write scene.toml and design.toml for `walkergen family`.
    """

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

    def run(self, progress: Progress) -> "FitReport":
        """Fit, and write the results."""
        from walkergen.core.files import output
        from walkergen.guests.lab.fit import make
        from walkergen.guests.lab.report import Setup

        if self.model == "theory":
            self.check_unset("‹model=›theory has none", "predict", "prior", "seed")
        else:
            self.check_unset(f"a mode of the theory; ‹model=›{self.model} has none", "mode")
        given = self.inputs()
        setup = Setup(given.design(self.design), given.scene(self.scene))
        return make.fit(self, setup, output.result_folder(self.speeds, self.out, "fit"), progress, self._expect)
