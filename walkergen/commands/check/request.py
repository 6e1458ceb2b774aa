"""Request of the command `check`."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from pydantic import Field

from walkergen import print_fields, request
from walkergen.core.errors import InputError, PrintabilityError
from walkergen.core.files.progress import Progress
from walkergen.request import Flag

if TYPE_CHECKING:
    from walkergen.commands.check.make import CheckReport
    from walkergen.commands.check.weigh_report import WeighReport


class CheckRequest(request.Request):
    """Check whether walkers will print as designed, or weigh any mesh, without writing any file.

    With --weigh the result has volume, mass, centre of mass, inertia tensor, principal moments and axes of a mesh
    file.

    Examples
    --------
    >>> import walkergen as wg
    >>> checked = wg.check(tilt=[5, 10], printer="ender3")
    >>> checked.table
    <table: 4 rows of wall, thickness_mm, lines, plastic_percent>
    >>> checked.warnings
    ()
    """

    design: request.Walker = request.PAPER_WALKER
    tilt: request.Tilts = None
    legs: request.Kinds = None
    printer: request.Machine = request.DEFAULT_PRINTER
    text: request.Text = None
    mirror: request.Mirror = None
    set: request.Settings = {}
    copies: print_fields.Copies = 1
    strict: print_fields.Strict = False
    weigh: Annotated[bool, Flag("Report the mass properties of any mesh file.")] = False
    density: Annotated[float, Field(ge=1e-6, le=100.0), Flag("Density of a mesh's material, g/cm3.", "G/CM3")] = 1.24
    scale: Annotated[float, Field(ge=1e-6, le=1e6), Flag("Length of a mesh file's unit, mm.", "MM")] = 1.0

    def run(self, progress: Progress) -> "CheckReport | WeighReport":
        """Check the walkers, or weigh the mesh."""
        if self.weigh:
            return self._weigh(Path(self.design))
        from walkergen.commands.check import make
        from walkergen.core.printing import findings

        self.check_unset("has an effect only with ‹weigh›", "density", "scale")
        given = self.inputs()
        members, counts = given.batch(given.design(self.design), self.tilt, self.legs, self.copies, whole=True)
        report = make.check(members, counts, given.printer(self.printer))
        try:
            findings.check_printable(report.findings, self.strict)
        except PrintabilityError as error:
            return replace(report, errors=str(error).splitlines(), code=2)
        return report

    def _weigh(self, path: Path) -> "WeighReport":
        """Weigh a mesh file. Raises InputError."""
        from walkergen.commands.check import weigh_report, weighing
        from walkergen.core.walker.spec import MESH_SUFFIXES

        if not isinstance(self.design, (str, Path)) or Path(self.design).suffix.lower() not in MESH_SUFFIXES:
            raise InputError(
                f"‹design=›{str(self.design)[:60]!r}: ‹weigh› needs a mesh file ({', '.join(MESH_SUFFIXES)}).", "design"
            )
        unused = ("tilt", "legs", "printer", "text", "mirror", "set", "copies", "strict")
        self.check_unset("cannot be combined with ‹weigh›", *unused)
        return weigh_report.make_report(weighing.weigh(path, self.density, self.scale), path, self.density, self.scale)
