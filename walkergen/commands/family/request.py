"""Request of the command `family`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ClassVar

from walkergen import print_fields, request
from walkergen.core.files.progress import Progress
from walkergen.request import Flag

if TYPE_CHECKING:
    from walkergen.commands.family.report import FamilyReport


class FamilyRequest(request.Request):
    """Make a family of walkers: STL files, plates, predicted speeds, pictures.

    With --page also one self-contained HTML page that opens offline.

    Examples
    --------
    >>> import walkergen as wg
    >>> made = wg.family("koumakis2016", "mine", tilt=[5, 10], legs="flexible", pictures=False)
    >>> sorted(path.name for path in made.folder.iterdir())
    ['family.csv', 'family.md', 'manifest.json', 'plates', 'stl', 'weights.csv']
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
    speeds: Annotated[bool, Flag("Predict speeds. Without them only parts are made, in seconds.")] = True
    why: Annotated[bool, Flag("Explain the sources of the speeds.")] = False
    simulate: Annotated[bool, Flag("Simulate every walker too (takes minutes).")] = False
    seconds: request.Seconds = None
    runs: request.Runs = None
    measured: Annotated[
        Path | None, request.File, Flag("Measured speeds (CSV) for speed.png.", "FILE", takes="Name | None")
    ] = None
    page: Annotated[bool, Flag("Write report.html, a page with all results.")] = False
    pictures: Annotated[bool, Flag("Draw speed.png and preview.png.")] = True
    strict: print_fields.Strict = False

    def run(self, progress: Progress) -> "FamilyReport":
        """Make the family."""
        if not self.speeds:
            self.check_unset("needs speeds, which this request leaves out", "model", "simulate", "measured", "why")
        report: FamilyReport = self.do_work(progress, self._expect)
        return report
