"""What `calibrate` is asked for."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import Field

from walkergen import print_fields, request
from walkergen.core.errors import InputError
from walkergen.core.files.progress import Progress
from walkergen.request import Flag

if TYPE_CHECKING:
    from walkergen.core.printing.findings import Finding
    from walkergen.files.report import Report
    from walkergen.guests.lab.calibrate.make import Job
    from walkergen.guests.movie.make import Made
    from walkergen.inputs import Inputs

FPS = 20
"""Frames per second of the film of a drop."""

FORM_KIND = "form"
"""What a form filled in is called in `KINDS_BY_FIELD`."""

SIMULATED_KINDS = (FORM_KIND, "drop")
KINDS_BY_FIELD = {
    "by": (FORM_KIND,),
    "roll_deg": SIMULATED_KINDS,
    "drops": SIMULATED_KINDS,
    "seed": SIMULATED_KINDS,
    "restitution": ("drop",),
    "friction": ("drop",),
    "measured": ("drop",),
    "measured_sd": ("drop",),
    "tries": ("drop",),
    "height_mm": ("drop",),
    "movie": ("drop",),
    "scene": SIMULATED_KINDS,
    "printer": ("plate",),
    "max_plates": ("plate",),
    "prusaslicer": ("plate",),
    "strict": ("plate",),
}
"""Fields that are of some calibrations alone."""


class CalibrateRequest(request.Request):
    """Estimate Young's modulus, density, friction, damping and restitution from your readings.

    `calibrate plate` makes a plate to measure: strips of four thicknesses, a block and one walker, with a sheet and a
    form. Filled in with readings by a ruler and a phone, the form is what `calibrate FORM.csv` takes. What it holds is
    estimated, with errors from those of the readings and from their scatter, and written into design.toml and
    scene.toml for `family` and `simulate`; what it lacks stays as design and scene have it. Of films it takes those of
    slides: the quantity filmed_deg, angle of the incline, with a column tracks that names the film's tracks.csv. A
    drop test of the walker is simulated (a minute), the rest takes a second.

    `calibrate --plate FILE.csv` takes what a phone's accelerometer recorded on the shaken plate (phyphox and others: a
    column of times, three of accelerations): frequency and amplitude of the drive, second harmonic, motion along the
    plate and noise, each with its error, and a scene.toml that has them. Three columns of a gyroscope beside them tell
    how the amplitude changes over the plate, and how it rocks.

    `calibrate drop` simulates drops of the walker on a still plate and inverts the rebound that was --measured, root of
    height over height: it tells the restitution of the feet.
    """

    by_position: ClassVar = ("what", "design", "scene")

    what: Annotated[
        Any,
        request.AsText,
        Flag("Form of `calibrate plate`, filled in; or plate; or drop.", "WHAT", takes="Name | None", argument=True),
    ] = None
    design: request.Filmed = request.PAPER_WALKER
    tilt: request.Tilt = None
    legs: request.Legs = None
    scene: request.Ground = request.LANE_SCENE
    restitution: request.Restitution = None
    friction: request.Friction = None
    by: Annotated[
        Literal["deflection", "ring", "both"], Flag("What Young's modulus is by: deflection, ring or both.", "METHOD")
    ] = "both"
    roll_deg: Annotated[
        float,
        Field(ge=0.0, le=20.0),
        Flag("Deviation of pitch and roll of drops from the hand, deg; 0: all let go flat.", "DEG"),
    ] = 1.0
    drops: Annotated[int, Field(ge=2, le=1000), Flag("Simulated drops from the hand for each point.", "N")] = 24
    seed: request.Seed = None
    measured: Annotated[float | None, Flag("Rebound of a drop, root of height over height.", "NUMBER")] = None
    measured_sd: Annotated[float | None, Flag("Standard error of the measured number.", "NUMBER")] = None
    tries: Annotated[int, Field(ge=1, le=10_000), Flag("Drops whose mean was measured.", "N")] = 1
    height_mm: Annotated[float, Field(ge=0.01, le=1000.0), Flag("Height of the drop, mm.", "MM")] = 10.0
    movie: Annotated[
        Path | None, request.Target, Flag("GIF of a drop from the hand; MP4 beside it.", "FILE", takes="Name | None")
    ] = None
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

    def run(self, progress: Progress) -> "Report":
        """Make a plate to measure, simulate drops, or estimate from a filled form."""
        if self.plate is not None:
            return self._calibrate_plate(self.plate)
        if self.what is None:
            raise InputError("‹what›: name a filled form, plate or drop; or ‹plate=›FILE", "what")
        what = self.what if self.what in ("drop", "plate") else FORM_KIND
        for field, owners in KINDS_BY_FIELD.items():
            if what not in owners:
                self.check_unset(f"is of calibrate {', '.join(owners)}, not of {what}", field)
        given = self.inputs()
        other = "scene" if what == "plate" else "printer"
        given.check_unset(given.keys_of(other), f"this command takes no {other} for {what}; leave it out")
        if what == "plate":
            return self._make_plate(given, progress)
        if what == FORM_KIND:
            return self._calibrate_form(given, progress)
        return self._simulate_drops(given, progress)

    def _calibrate_plate(self, path: Path) -> "Report":
        """Estimate the drive of the plate that was recorded."""
        from walkergen.core.files import output
        from walkergen.guests.lab.calibrate import make, plate_drive
        from walkergen.guests.lab.report import write_report

        self.check_unset("is not of ‹plate›", "what", *(name for name in KINDS_BY_FIELD if name != "scene"))
        given = self.inputs()
        job = make.Job(
            given.single_member(self.design, self.tilt, self.legs), given.scene(self.scene), 0.0, 2, self.pictures
        )
        report = plate_drive.calibrate(path, job.design, job.scene, output.result_folder(path, self.out, "calibrate"))
        return write_report(report, job, {"file": path.name, "settings": report.settings}, f"Measured: {path.name}")

    def _calibrate_form(self, given: "Inputs", progress: Progress) -> "Report":
        """Estimate what a filled form tells."""
        from walkergen.core.files import output
        from walkergen.guests.lab.calibrate import make

        walker, scene, path = (
            given.single_member(self.design, self.tilt, self.legs),
            given.scene(self.scene),
            Path(self.what),
        )
        job = make.Job(walker, scene, self.roll_deg, self.drops, self.pictures, self.by)
        return make.calibrate(path, job, output.result_folder(path, self.out, "calibrate"), progress)

    def _make_plate(self, given: "Inputs", progress: Progress) -> "Report":
        """Make a plate to measure."""
        from walkergen.core.printing import findings as printed
        from walkergen.guests.lab.calibrate import form, plate

        walker = given.single_member(self.design, self.tilt, self.legs)
        printers, findings = given.printers(self.printer), list["Finding"]()
        order = plate.Order(walker, printers, self.max_plates, self.pictures, self.prusaslicer, self.strict)
        folder = self.out or Path("out") / walker.name
        report = plate.make_plate(order, folder, progress, findings.extend)
        warnings, kept = printed.warning_lines(findings), folder / plate.STEM / form.FORM_FILE
        if kept not in report.files:
            warnings.append(f"{kept}: somebody has written in it: left as it is")
        return replace(report, warnings=warnings)

    def _simulate_drops(self, given: "Inputs", progress: Progress) -> "Report":
        """Simulate drops, and invert the rebound that was measured."""
        from walkergen.guests.lab import inverse
        from walkergen.guests.lab.bench import make
        from walkergen.guests.lab.calibrate.make import Job

        if self.movie is not None and self.movie.suffix.lower() != ".gif":
            told = f"‹movie=›{str(self.movie)[:80]!r}: must end in .gif (the MP4 comes beside it)"
            raise InputError(told, "movie")
        walker = given.single_member(self.design, self.tilt, self.legs)
        seen = inverse.parse_measured(self.measured, self.measured_sd, self.tries, 1.0)
        job = Job(walker, given.scene(self.scene), self.roll_deg, self.drops, self.pictures)
        report = make.run_drop_test(job, self.height_mm, seen, self.out or make.default_folder(walker), progress)
        if self.movie is None:
            return report
        return replace(report, files=[_film_drop(job, self.height_mm, self.movie, progress).gif])


def _film_drop(dropped: "Job", height: float, path: Path, progress: Progress) -> "Made":
    """Film of the first of the drops from the hand, from the release to where it rises no more."""
    from walkergen.core.simulation.plan import Release
    from walkergen.guests.lab import drops, still_plate
    from walkergen.guests.movie import make
    from walkergen.guests.movie.request import MovieRequest

    let = drops.hand_drops(height, dropped.turn_deg, dropped.drops, dropped.scene.run.seed)[0]
    request = MovieRequest(seconds=drops.drop_seconds(height), fps=FPS, view="perspective")
    scene, release = still_plate.film_scene(dropped.scene), Release(let.height, let.pitch, let.roll)
    return make.make_movie(make.plan_film(request, [dropped.design], scene, release), path, progress)
