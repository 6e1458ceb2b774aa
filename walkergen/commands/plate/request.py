"""Request of the command `plate`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field

from walkergen import print_fields, request
from walkergen.core.files.progress import Progress
from walkergen.request import Flag

if TYPE_CHECKING:
    from walkergen.files.report import Report


class PlateRequest(request.Request):
    """Arrange copies of walkers on as many print-ready plates (3MF) as they need, with maps.

    Design, tilts and copies are given here, or those of several designs by an order list.

    Examples
    --------
    >>> import walkergen as wg
    >>> wg.plate("koumakis2016", tilt=[5, 10], copies=2, out="plate", pictures=False)
    4 parts on 1 plate of prusa-mk3s
    plates: 2 rows
    """

    design: Annotated[
        Any,
        request.file_flag(
            "walkers",
            f"Walker: a template, TOML file, drawing or mesh; {request.PAPER_WALKER} without --orders.",
            optional=True,
            argument=True,
        ),
    ] = None
    tilt: request.Tilts = None
    legs: request.Kinds = None
    copies: print_fields.Copies = 1
    orders: Annotated[
        Path | None,
        request.File,
        Flag("Order list (CSV: design, tilt_deg, legs, copies) of several designs.", "FILE", takes="Name | None"),
    ] = None
    serial: Annotated[
        int | None, Field(ge=1), Flag("Engrave a number into each copy, counted from FIRST.", "FIRST")
    ] = None
    caps: print_fields.Caps = None
    printer: print_fields.Machines = request.DEFAULT_PRINTER
    text: request.Text = None
    mirror: request.Mirror = None
    set: request.Settings = {}
    max_parts: print_fields.MaxParts = 5000
    prusaslicer: print_fields.ForPrusaSlicer = False
    max_plates: print_fields.MaxPlates = None
    how_many: Annotated[bool, Flag("Print how many copies of each walker fit on a plate.")] = False
    strict: print_fields.Strict = False
    out: request.Out = None
    pictures: Annotated[bool, Flag("Draw a map of every plate.")] = True

    def run(self, progress: Progress) -> "Report":
        """Arrange the copies, or count how many fit."""
        report: Report = self.do_work(progress)
        return report
