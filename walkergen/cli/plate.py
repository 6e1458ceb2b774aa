"""The command `plate`."""

import sys
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from walkergen.cli import loading, show, variants
from walkergen.cli import options as opt
from walkergen.errors import InputError

if TYPE_CHECKING:
    from walkergen.lab.calibrate.plate import Order
    from walkergen.walker.design import Design


def plate(
    design: Annotated[
        str | None,
        typer.Argument(
            metavar="DESIGN",
            help=f"Walker: a template or a TOML file; {opt.PAPER} without --orders.",
            show_default=False,
        ),
    ] = None,
    tilt: opt.Tilt = None,
    legs: opt.LegKinds = None,
    copies: opt.Copies = None,
    orders: Annotated[
        Path | None,
        typer.Option(
            "--orders", metavar="FILE", help="Order list (CSV: design, tilt_deg, legs, copies) of several designs."
        ),
    ] = None,
    calibration: Annotated[
        bool,
        typer.Option(
            "--calibration", help="A plate to measure material and contact with, its sheet and form, instead."
        ),
    ] = False,
    serial: Annotated[
        int | None,
        typer.Option(
            "--serial", metavar="FIRST", min=1, help="Engrave a number into each copy, counted over all from FIRST."
        ),
    ] = None,
    caps: opt.Caps = None,
    printers: Annotated[
        str, typer.Option("--printer", metavar="PRINTER", help="Printers: templates or TOML files.")
    ] = opt.PRINTER,
    keys: opt.Values = None,
    max_parts: opt.MaxParts = 5000,
    prusaslicer: opt.ForPrusaSlicer = False,
    max_plates: Annotated[
        int | None, typer.Option(metavar="N", min=1, max=1000, help="Largest number of plates to use.")
    ] = None,
    how_many: Annotated[bool, typer.Option("--how-many", help="Print how many of each fit on a plate.")] = False,
    strict: opt.Strict = False,
    out: opt.Out = None,
    pictures: Annotated[bool, typer.Option(show_default=False, help="Draw a map of every plate.")] = True,
    json: opt.AsJson = False,
    quiet: opt.Quiet = False,
) -> None:
    """Arrange copies of walkers on as many print-ready plates (3MF) as they need, with maps.

    Their design, tilts and copies are given here, or those of several designs by an order list.
    With --calibration: strips of four thicknesses, a block and one walker, to be measured with a
    ruler and a phone for `walkergen calibrate`.
    """
    from walkergen.files import output
    from walkergen.jobs.make.plate import make as plates
    from walkergen.lab.calibrate import plate as calibration_plate

    inputs = loading.inputs(keys, "design printer")
    if calibration:
        beside = {
            "--copies": copies,
            "--orders": orders,
            "--how-many": how_many or None,
            "--serial": serial,
            "--caps": caps,
        }
        _refuse("--calibration makes a plate of its own", beside)
        walker = inputs.one(opt.PAPER if design is None else design, _one_tilt(tilt), legs)
        machines = inputs.printers(printers)
        to_measure = calibration_plate.Order(walker, machines, max_plates, pictures, prusaslicer, strict)
        _calibrate(to_measure, out or Path("out") / walker.name, json, quiet)
        return
    if orders is not None:
        flags: dict[str, object] = {"DESIGN": design, "--tilt": tilt, "--legs": legs, "--copies": copies}
        flags |= {f"--set {key}": key for key in inputs.of("design")}
        members, counts = _ordered(orders, flags)
        name = output.named_after(orders)
    else:
        chosen = inputs.design(opt.PAPER if design is None else design)
        members, counts = inputs.batch(chosen, tilt, legs, copies, whole=False)
        name = chosen.name
    members = variants.capped(members, caps)
    machines = inputs.printers(printers)
    if how_many:
        show.report(plates.how_many(members, machines, max_parts), json, quiet=False)
        return
    folder = out or Path("out") / name
    order = plates.Order(members, counts, machines, max_plates, max_parts, pictures, prusaslicer, serial, strict)
    with show.progress(name, wanted=not quiet) as progress:
        tell = partial(show.warnings, quiet=quiet)
        report = plates.make(order, folder, progress, tell)
    show.report(report, json, quiet)
    show.kept_forms(folder, members)


def _calibrate(order: "Order", folder: Path, json: bool, quiet: bool) -> None:
    """Make a calibration plate, and print what lies on it and where its files are."""
    from walkergen.lab.calibrate import form
    from walkergen.lab.calibrate import plate as plates

    with show.progress("calibration", wanted=not quiet) as progress:
        report = plates.make(order, folder, progress, partial(show.warnings, quiet=quiet))
    kept = folder / plates.STEM / form.FILE
    if kept not in report.files:
        print(f"{kept}: somebody has written in it: left as it is", file=sys.stderr)
    show.report(report, json, quiet)


def _one_tilt(text: str | None) -> float | None:
    """Tilt of the one walker of a calibration plate. Raises InputError for several."""
    if text is None:
        return None
    tilts = variants.parse_tilts(text)
    if len(tilts) != 1:
        raise InputError(f"--tilt {text[:60]!r}: --calibration has one walker: give one tilt")
    return tilts[0]


def _refuse(why: str, flags: "Mapping[str, object]") -> None:
    """Raise InputError for the first option that is given."""
    for option, value in flags.items():
        if value is not None:
            raise InputError(f"{why}: leave {option} out")


def _ordered(path: Path, flags: "Mapping[str, object]") -> "tuple[list[Design], list[int]]":
    """Read an order list. Raises InputError for what is `given` beside it on the command line."""
    from walkergen.jobs.make.plate import order_list

    _refuse(f"--orders {str(path)[:80]!r} names designs, tilts, legs and copies", flags)
    return order_list.read(path)
