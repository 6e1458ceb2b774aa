"""What `check` is asked for."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field

from walkergen import request
from walkergen.errors import PrintabilityError
from walkergen.files.progress import Progress
from walkergen.request import Flag

if TYPE_CHECKING:
    from walkergen.jobs.make.check.make import CheckReport
    from walkergen.jobs.make.check.weigh_report import WeighReport

MESHES = (".stl", ".obj", ".ply", ".off", ".3mf", ".glb")
"""Endings of files of meshes."""


class CheckRequest(request.Request):
    """Check whether walkers will print as designed, or weigh any mesh, without writing any file.

    Of a mesh file it tells volume, mass, centre of mass, inertia tensor, principal moments and axes.
    """

    design: Annotated[
        Any,
        Flag(
            "Walker, a template or a TOML file; or a mesh: STL, OBJ, PLY, OFF, 3MF or GLB.",
            "DESIGN",
            takes="Walker",
            templates=("walkers",),
            argument=True,
        ),
    ] = request.PAPER
    tilt: request.Tilts = None
    legs: request.Kinds = None
    printer: request.Machine = request.PRUSA
    set: request.Settings = {}
    copies: request.Copies = 1
    strict: request.Strict = False
    density: Annotated[float, Field(ge=1e-6, le=100.0), Flag("Density of a mesh's material, g/cm3.", "G/CM3")] = 1.24
    scale: Annotated[float, Field(ge=1e-6, le=1e6), Flag("Length of a mesh file's unit, mm.", "MM")] = 1.0

    def run(self, progress: Progress) -> "CheckReport | WeighReport":
        """Check the walkers, or weigh the mesh."""
        if isinstance(self.design, (str, Path)) and Path(self.design).suffix.lower() in MESHES:
            return self._weigh(Path(self.design))
        from walkergen.jobs.make.check import make
        from walkergen.printing import findings

        self.refuse("is of a mesh file", "density", "scale")
        given = self.inputs()
        members, counts = given.batch(given.design(self.design), self.tilt, self.legs, self.copies, whole=True)
        report = make.check(members, counts, given.printer(self.printer))
        try:
            findings.refuse(report.findings, self.strict)
        except PrintabilityError as error:
            return replace(report, errors=str(error).splitlines(), code=2)
        return report

    def _weigh(self, path: Path) -> "WeighReport":
        """Weigh a mesh file."""
        from walkergen.jobs.make.check import weigh_report, weighing

        self.refuse("is of a walker, not of a mesh", "tilt", "legs", "printer", "set", "copies", "strict")
        return weigh_report.of(weighing.weigh(path, self.density, self.scale), path, self.density, self.scale)
