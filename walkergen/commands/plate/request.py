"""What `plate` is asked for."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field

from walkergen import inputs, print_fields, request
from walkergen.core.errors import InputError
from walkergen.core.files.progress import Progress
from walkergen.request import Flag

if TYPE_CHECKING:
    from walkergen.core.printing.findings import Finding
    from walkergen.files.report import Report


class PlateRequest(request.Request):
    """Arrange copies of walkers on as many print-ready plates (3MF) as they need, with maps.

    Their design, tilts and copies are given here, or those of several designs by an order list.
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
        int | None, Field(ge=1), Flag("Engrave a number into each copy, counted over all from FIRST.", "FIRST")
    ] = None
    caps: print_fields.Caps = None
    printer: print_fields.Machines = request.DEFAULT_PRINTER
    text: request.Text = None
    mirror: request.Mirror = None
    set: request.Settings = {}
    max_parts: print_fields.MaxParts = 5000
    prusaslicer: print_fields.ForPrusaSlicer = False
    max_plates: print_fields.MaxPlates = None
    how_many: Annotated[bool, Flag("Print how many of each fit on a plate.")] = False
    strict: print_fields.Strict = False
    out: request.Out = None
    pictures: Annotated[bool, Flag("Draw a map of every plate.")] = True

    def run(self, progress: Progress) -> "Report":
        """Arrange the copies, or count how many fit."""
        from walkergen.commands.plate import make, order_list
        from walkergen.core.files import output
        from walkergen.core.printing import findings as printed

        given = self.inputs()
        if self.orders is not None:
            why = f"‹orders=›{str(self.orders)[:80]!r} names it"
            self.check_unset(why, "design", "tilt", "legs", "copies")
            if "copies" in self.model_fields_set:  # 1, as by default, may not be what the list says
                raise InputError(f"‹copies=›{self.copies}: {why}; leave it out", "copies")
            given.check_unset(given.keys_of("design"), "‹orders› names designs; leave it out")
            members, counts = order_list.read_orders(self.orders)
            name = output.safe_folder_name(self.orders)
        else:
            design = given.design(self.design or request.PAPER_WALKER)
            members, counts = given.batch(design, self.tilt, self.legs, self.copies, whole=False)
            name = design.name
        members = inputs.add_caps(members, self.caps)
        printers = given.printers(self.printer)
        if self.how_many:
            return make.count_fitting(members, printers, self.max_parts)
        order = make.Order(
            members,
            counts,
            printers,
            self.max_plates,
            self.max_parts,
            self.pictures,
            self.prusaslicer,
            self.serial,
            self.strict,
        )
        folder, findings = self.out or Path("out") / name, list["Finding"]()
        report = make.make(order, folder, progress, findings.extend)
        return replace(
            report, warnings=[*printed.warning_lines(findings), *inputs.filled_form_warnings(folder, members)]
        )
