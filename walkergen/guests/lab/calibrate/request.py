"""Request of `calibrate`: a plate to measure, a filled form, a measured drop, or a recording of the plate."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from walkergen.core.errors import InputError
from walkergen.core.files.progress import Progress
from walkergen.guests.lab.calibrate.fields import CalibrateFields

if TYPE_CHECKING:
    from walkergen.core.printing.findings import Finding
    from walkergen.files.report import Report
    from walkergen.guests.lab.report import Setup
    from walkergen.inputs import Inputs


FORM_KIND = "form"
"""Name of a filled form in `KINDS_BY_FIELD`."""

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
    "scene": SIMULATED_KINDS,
    "printer": ("plate",),
    "max_plates": ("plate",),
    "prusaslicer": ("plate",),
    "strict": ("plate",),
}
"""Kinds of calibration (form, drop, plate) in which each field has a meaning."""


class CalibrateRequest(CalibrateFields):
    """Estimate Young's modulus, density, friction, damping and restitution from your readings.

    `calibrate plate` makes a plate to measure: strips of four thicknesses, a block and one walker, with a sheet and a
    form. Enter readings of a ruler and a phone, and give the form to `calibrate FORM.csv`. Its results have errors
    from those of the readings and from their scatter. They are written to design.toml and scene.toml, for `family` and
    `simulate`. Values that the form lacks stay as design and scene have them. Films of slides are read too: the
    quantity is filmed_deg, the angle of the incline, and a column tracks names the film's tracks.csv. The drop test of
    the walker is simulated, which takes a minute. Everything else takes a second.

    `calibrate --plate FILE.csv` reads a recording of a phone's accelerometer on the shaken plate, from phyphox and
    others: a column of times, three of accelerations. The results are frequency and amplitude of the drive, second
    harmonic, motion along the plate and noise, each with its error, and a scene.toml with these values. Three columns
    of a gyroscope also give the gradient of the amplitude over the plate, and its rocking.

    `calibrate drop` simulates drops of the walker on a still plate. It computes the restitution of the feet from the
    rebound in --measured, the square root of the height after over the height before.

    Examples
    --------
    >>> import walkergen as wg
    >>> made = wg.calibrate("plate", out="lab", pictures=False)
    >>> [path.name for path in made.files if path.suffix == ".3mf"]
    ['calibration_prusa-mk3s_1.3mf']
    """

    def run(self, progress: Progress) -> "Report":
        """Make a plate to measure, or compute results from a form, a drop or a recording. Return the report."""
        if self.plate is not None:
            return self._calibrate_plate(self.plate)
        if self.what is None:
            raise InputError("‹what› is missing. Write plate, drop or a filled form, or ‹plate=›FILE.", "what")
        what = self.what if self.what in ("drop", "plate") else FORM_KIND
        for field, owners in KINDS_BY_FIELD.items():
            if what not in owners:
                self.check_unset(f"works only with calibrate {' or '.join(owners)}, not with {what}", field)
        given = self.inputs()
        other = "scene" if what == "plate" else "printer"
        given.check_unset(given.keys_of(other), f"this command takes no {other} for {what}. Leave it out")
        if what == "plate":
            return self._make_plate(given, progress)
        if what == FORM_KIND:
            return self._calibrate_form(given, progress)
        return self._calibrate_drop(given, progress)

    def _read_setup(self, given: "Inputs") -> "Setup":
        """Return the design and the scene that the request names."""
        from walkergen.guests.lab.report import Setup

        return Setup(given.single_member(self.design, self.tilt, self.legs), given.scene(self.scene))

    def _calibrate_plate(self, path: Path) -> "Report":
        """Estimate the drive from a recording of the plate, and write the report."""
        from walkergen.core.files import output
        from walkergen.guests.lab.calibrate import plate_drive
        from walkergen.guests.lab.report import write_report

        self.check_unset("conflicts with ‹plate›", "what", *(name for name in KINDS_BY_FIELD if name != "scene"))
        setup = self._read_setup(self.inputs())
        report = plate_drive.calibrate(path, setup, output.result_folder(path, self.out, "calibrate"))
        choices = {"file": path.name, "settings": report.settings}
        return write_report(report, setup, choices, self.pictures, f"Measured: {path.name}")

    def _calibrate_form(self, given: "Inputs", progress: Progress) -> "Report":
        """Estimate the quantities of a filled form."""
        from walkergen.core.files import output
        from walkergen.guests.lab.calibrate import make

        folder = output.result_folder(Path(self.what), self.out, "calibrate")
        return make.calibrate_form(self, self._read_setup(given), folder, progress)

    def _calibrate_drop(self, given: "Inputs", progress: Progress) -> "Report":
        """Estimate the restitution from a measured rebound."""
        from walkergen.core.walker import names
        from walkergen.guests.lab.calibrate import make

        setup = self._read_setup(given)
        folder = self.out or Path("out") / setup.design.name / f"drop_{names.part_name(setup.design)}"
        return make.calibrate_drop(self, setup, folder, progress)

    def _make_plate(self, given: "Inputs", progress: Progress) -> "Report":
        """Write a plate of parts to measure, and return its report with warnings."""
        from walkergen.core.printing import findings as printed
        from walkergen.guests.lab.calibrate import form, plate

        walker = given.single_member(self.design, self.tilt, self.legs)
        printers, findings = given.printers(self.printer), list["Finding"]()
        folder = self.out or Path("out") / walker.name
        report = plate.make_plate(self, walker, printers, folder, progress, findings.extend)
        warnings, kept = printed.warning_lines(findings), folder / plate.STEM / form.FORM_FILE
        if kept not in report.files:
            warnings.append(f"{kept}: keeps its contents, because it was edited")
        return replace(report, warnings=warnings)
