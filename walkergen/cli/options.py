"""Options that several commands share."""

from pathlib import Path
from typing import Annotated

import typer

from walkergen.cli.layout import names_of
from walkergen.errors import InputError

PAPER, SCENE, PRINTER = "koumakis2016", "lane-90hz", "prusa-mk3s"
"""Templates of the walker, the scene and the printer that commands use by default."""


def _sound(path: Path | None) -> Path | None:
    """Folder to write to. Raises InputError for a name that could not be read again."""
    from walkergen.files import reading

    if path is not None and not reading.named_soundly(path):
        raise InputError(f"--out {str(path)[:80]!r}: holds control characters; give another name")
    return path


DesignName = Annotated[
    str, typer.Argument(metavar="DESIGN", help="Walker: a template or a TOML file.", autocompletion=names_of("walkers"))
]
OneTilt = Annotated[float | None, typer.Option("--tilt", metavar="DEG", help="Tilt of the legs.")]
OneKind = Annotated[str | None, typer.Option("--legs", metavar="KIND", help="Kind of legs: flexible or braced.")]
Tilt = Annotated[
    str | None, typer.Option("--tilt", metavar="DEG", help="Tilts, deg: 10, or 5,10,15, or FIRST:LAST:STEP.")
]
LegKinds = Annotated[
    str | None, typer.Option("--legs", metavar="KIND", help="Kinds of legs: flexible, braced, or flexible,braced.")
]
SceneName = Annotated[
    str,
    typer.Option(
        "--scene", metavar="SCENE", help="Scene: a template or a TOML file.", autocompletion=names_of("scenes")
    ),
]
Restitution = Annotated[
    float | None, typer.Option("--restitution", metavar="NUMBER", help="Coefficient of restitution, 0..1.")
]
Friction = Annotated[float | None, typer.Option("--friction", metavar="NUMBER", help="Friction coefficient, >= 0.")]
ModeName = Annotated[
    str, typer.Option("--mode", metavar="MODE", help="Theory: coulomb (feet may stick) or paper (eq. 15).")
]
LawName = Annotated[
    str | None,
    typer.Option("--law", metavar="LAW", help="Law of impact: poisson, newton or stronge; the last two not in space."),
]
Seconds = Annotated[
    float | None, typer.Option("--seconds", metavar="S", help="Measured time of each simulated run, s.")
]
Runs = Annotated[int | None, typer.Option("--runs", metavar="N", help="Number of simulated runs.")]
Seed = Annotated[int | None, typer.Option("--seed", metavar="N", help="Seed of the runs' random starts.")]
Model = Annotated[
    str | None, typer.Option("--model", metavar="MODEL", help="Model: rigid, relaxed, compliant, space or auto.")
]
Gamma = Annotated[float | None, typer.Option("--gamma", metavar="NUMBER", help="Peak acceleration over g.")]
Frequency = Annotated[float | None, typer.Option("--frequency", metavar="HZ", help="Frequency of the drive, Hz.")]
Step = Annotated[float | None, typer.Option("--step", metavar="MICROSECONDS", help="Time step.")]
Uncertain = Annotated[bool, typer.Option("--uncertain", help="Draw uncertain inputs; say what to measure next.")]
Pictures = Annotated[bool, typer.Option(show_default=False, help="Draw the figures.")]
PrinterName = Annotated[
    str,
    typer.Option(
        "--printer", metavar="PRINTER", help="Printer: a template or a TOML file.", autocompletion=names_of("printers")
    ),
]
Copies = Annotated[
    str | None,
    typer.Option("--copies", metavar="COPIES", help="Copies of each walker, 1 by default: 8, or by tilt: 10:20,15:40."),
]
Caps = Annotated[
    str | None,
    typer.Option(
        "--caps", metavar="MARKERS", help="Caps to glue on, with markers that `track --markers` reads: aruco."
    ),
]
MaxParts = Annotated[
    int, typer.Option("--max-parts", metavar="N", min=1, max=5000, help="Largest number of parts on a plate.")
]
ForPrusaSlicer = Annotated[
    bool, typer.Option("--prusaslicer", help="Let PrusaSlicer list and slice all copies as one object.")
]
WeightsFile = Annotated[
    Path | None, typer.Option("--weights", metavar="FILE", help="Masses from a balance: a filled weights.csv.")
]
Out = Annotated[
    Path | None,
    typer.Option("--out", metavar="FOLDER", help="Folder to write to; out/NAME by default.", callback=_sound),
]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON instead of a table.")]
Strict = Annotated[bool, typer.Option("--strict", help="Refuse parts that get warnings, too.")]
Values = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="Key of a file to change: legs.length_mm=9, scene.drive.gamma=2, printer.nozzle_mm=1.",
    ),
]
Quiet = Annotated[bool, typer.Option("--quiet", help="Print nothing but errors.")]
