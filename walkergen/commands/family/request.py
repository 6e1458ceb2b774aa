"""What `family` is asked for."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ClassVar

from walkergen import inputs, print_fields, request
from walkergen.core.errors import GeometryError
from walkergen.core.files.progress import Progress
from walkergen.request import Flag

if TYPE_CHECKING:
    from walkergen.analysis.speeds import Measured
    from walkergen.commands.family.report import FamilyReport
    from walkergen.core.printing.findings import Finding
    from walkergen.core.scene import Scene
    from walkergen.core.walker.design import Design


class FamilyRequest(request.Request):
    """Make a family of walkers: STL files, plates, predicted speeds, pictures.

    With --page also one self-contained HTML page that opens offline.
    """

    by_position: ClassVar = ("design", "out")

    design: request.Walker = request.PAPER_WALKER
    tilt: request.Tilts = None
    legs: request.Kinds = None
    scene: request.Home = None
    restitution: request.Restitution = None
    friction: request.Friction = None
    gamma: request.Gamma = None
    frequency: request.Frequency = None
    mode: request.Mode = "coulomb"
    printer: request.Machine = request.DEFAULT_PRINTER
    text: request.Text = None
    mirror: request.Mirror = None
    set: request.Settings = {}
    copies: print_fields.Copies = 1
    max_parts: print_fields.MaxParts = 5000
    prusaslicer: print_fields.ForPrusaSlicer = False
    weights: request.Weights = None
    out: request.Out = None
    model: request.Predicted = "best"
    simulate: Annotated[bool, Flag("Simulate every walker too (takes minutes).")] = False
    seconds: request.Seconds = None
    runs: request.Runs = None
    measured: Annotated[
        Path | None, request.File, Flag("Measured speeds (CSV) for speed.png.", "FILE", takes="Name | None")
    ] = None
    page: Annotated[bool, Flag("Write report.html, a page of all of it.")] = False
    pictures: Annotated[bool, Flag("Draw speed.png and preview.png.")] = True
    strict: print_fields.Strict = False

    def run(self, progress: Progress) -> "FamilyReport":
        """Make the family."""
        from walkergen.commands.family import make
        from walkergen.core.printing import findings as printed

        given = self.inputs()
        try:
            design = given.design(self.design)
        except GeometryError as error:
            raise make.attach_picture(error, self.output_folder(Path("out") / "trouble")) from None
        scene = given.scene(request.choose_scene(self.scene, [design]))
        members, counts = given.batch(design, self.tilt, self.legs, self.copies, whole=True)
        masses, unused = inputs.read_masses(self.weights, members)
        measured, left_out = self._read_measured(design, scene)
        findings: list[Finding] = []
        job = make.Job(
            design=design,
            members=members,
            scene=scene,
            printer=given.printer(self.printer),
            mode=self.mode,
            model=self.model,
            pictures=self.pictures,
            simulate=self.simulate,
            copies=counts,
            max_parts=self.max_parts,
            prusaslicer=self.prusaslicer,
            weighed=masses,
            strict=self.strict,
            measured=measured,
            page=self.page,
        )
        folder = self.out or Path("out") / design.name
        report = make.make(job, folder, progress, findings.extend)
        warnings = [*printed.warning_lines(findings), *unused, *left_out, *inputs.filled_form_warnings(folder, members)]
        return replace(report, warnings=warnings)

    def _read_measured(self, design: "Design", scene: "Scene") -> "tuple[Measured | None, list[str]]":
        """Speeds measured on the scene's plate, and what is to be said of rows left out."""
        if self.measured is None:
            return None, []
        from walkergen.analysis import speeds

        measured = speeds.read_at_plate_speed(self.measured, design.kind, scene.drive.peak_speed)
        return measured, [f"{self.measured}: {note}" for note in measured.notes]
