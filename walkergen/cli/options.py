"""Options that several commands share, and the parsing of tilts and lists."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from walkergen.errors import InputError

if TYPE_CHECKING:
    from walkergen.printing.printers import Printer
    from walkergen.scene import Scene
    from walkergen.theory.speed import Mode
    from walkergen.walker.design import Design
    from walkergen.walker.limbs import Kind

PAPER, SCENE, PRINTER = "koumakis2016", "lane-90hz", "prusa-mk3s"
"""Templates of the walker, the scene and the printer that commands use by default."""

MOST_TILTS = 1000
MOST_COPIES = 5000

DesignName = Annotated[
    str, typer.Argument(metavar="DESIGN", help="Walker: a template or a TOML file.")
]
OneTilt = Annotated[float | None, typer.Option("--tilt", metavar="DEG", help="Tilt of the legs.")]
OneKind = Annotated[
    str | None, typer.Option("--legs", metavar="KIND", help="Kind of legs: flexible or braced.")
]
Tilt = Annotated[
    str | None,
    typer.Option("--tilt", metavar="DEG", help="Tilts, deg: 10, or 5,10,15, or FIRST:LAST:STEP."),
]
LegKinds = Annotated[
    str | None,
    typer.Option(
        "--legs", metavar="KIND", help="Kinds of legs: flexible, braced, or flexible,braced."
    ),
]
SceneName = Annotated[
    str, typer.Option("--scene", metavar="SCENE", help="Scene: a template or a TOML file.")
]
Restitution = Annotated[
    float | None, typer.Option("--restitution", help="Coefficient of restitution, 0..1.")
]
Friction = Annotated[float | None, typer.Option("--friction", help="Friction coefficient, >= 0.")]
ModeName = Annotated[
    str,
    typer.Option(
        "--mode", metavar="MODE", help="Theory: coulomb (feet may stick) or paper (eq. 15)."
    ),
]
LawName = Annotated[
    str | None,
    typer.Option(
        "--law",
        metavar="LAW",
        help="Law of impact: poisson, newton or stronge; the last two not in space.",
    ),
]
Seconds = Annotated[
    float | None, typer.Option("--seconds", help="Measured time of each simulated run, s.")
]
Runs = Annotated[int | None, typer.Option("--runs", help="Number of simulated runs.")]
Seed = Annotated[int | None, typer.Option("--seed", help="Seed of the runs' random starts.")]
Model = Annotated[
    str | None,
    typer.Option(
        "--model", metavar="MODEL", help="Model: rigid, relaxed, compliant, space or auto."
    ),
]
Method = Annotated[
    str | None, typer.Option("--method", metavar="METHOD", help="Method: event, step or auto.")
]
Gamma = Annotated[float | None, typer.Option("--gamma", help="Peak acceleration over g.")]
Frequency = Annotated[float | None, typer.Option("--frequency", help="Frequency of the drive, Hz.")]
Step = Annotated[
    float | None, typer.Option("--step", metavar="MICROSECONDS", help="Time step of method step.")
]
Uncertain = Annotated[
    bool, typer.Option("--uncertain", help="Draw uncertain inputs; say what to measure next.")
]
Pictures = Annotated[bool, typer.Option(help="Draw the figures.")]
PrinterName = Annotated[
    str, typer.Option("--printer", metavar="PRINTER", help="Printer: a template or a TOML file.")
]
Copies = Annotated[
    str | None,
    typer.Option(
        "--copies",
        metavar="COPIES",
        help="Copies of each walker, 1 by default: 8, or by tilt: 10:20,15:40.",
    ),
]
MaxParts = Annotated[
    int, typer.Option("--max-parts", min=1, max=5000, help="Largest number of parts on a plate.")
]
ForPrusaSlicer = Annotated[
    bool,
    typer.Option("--prusaslicer", help="Let PrusaSlicer list and slice all copies as one object."),
]
WeightsFile = Annotated[
    Path | None,
    typer.Option("--weights", metavar="FILE", help="Masses from a balance: a filled weights.csv."),
]
Out = Annotated[
    Path | None,
    typer.Option("--out", metavar="FOLDER", help="Folder to write to; out/NAME by default."),
]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON instead of a table.")]
Strict = Annotated[bool, typer.Option("--strict", help="Refuse parts that get warnings, too.")]
Quiet = Annotated[bool, typer.Option("--quiet", help="Print nothing but errors.")]


def design_of(name: str) -> "Design":
    """Load the design with a template's name or at a file's path."""
    from walkergen.files import templates
    from walkergen.walker.design import Design

    return templates.load(name, "walkers", Design)


def one_design(name: str, tilt: float | None, legs: str | None) -> "Design":
    """Load the single walker that a command line asks for. Raises InputError for two kinds."""
    design = design_of(name)
    kind = parse_kinds(legs) if legs is not None else [design.kind]
    if len(kind) != 1:
        raise InputError(f"--legs {legs!r}: one kind at a time")
    (member,) = design.members([design.tilt_deg if tilt is None else tilt], kind)
    return member


class Changes(NamedTuple):
    """Values that the command line sets in a scene; None keeps the scene's own value."""

    restitution: float | None = None
    friction: float | None = None
    law: str | None = None
    gamma: float | None = None
    frequency: float | None = None
    seconds: float | None = None
    runs: int | None = None
    seed: int | None = None
    method: str | None = None
    step: float | None = None
    model: str | None = None


def scene_of(name: str, changes: Changes) -> "Scene":
    """Load the scene with a name or at a path, and put in the command line's values."""
    from walkergen.files import templates
    from walkergen.files.config import validate
    from walkergen.scene import Scene

    scene = templates.load(name, "scenes", Scene)
    data: dict[str, dict[str, Any]] = scene.model_dump(exclude_none=True)
    if changes.gamma is not None or changes.frequency is not None:
        # Two numbers determine the drive: those given, completed from the scene's own.
        drive = {key: value for key, value in data["drive"].items() if key.startswith("second_")}
        drive["frequency_hz"] = _given(changes.frequency, scene.drive.frequency)
        drive["gamma"] = _given(changes.gamma, scene.drive.peak_gamma)
        data["drive"] = drive
    places: dict[str, dict[str, Any]] = {
        "contact": {"restitution": changes.restitution, "friction": changes.friction,
                    "law": changes.law},
        "run": {"seconds": changes.seconds, "runs": changes.runs, "seed": changes.seed,
                "method": changes.method, "step_us": changes.step},
        "legs": {"model": changes.model},
    }  # fmt: skip
    for table, values in places.items():
        data[table] |= {key: value for key, value in values.items() if value is not None}
    return validate(data, Scene, "command line")


def _given(value: float | None, otherwise: float) -> float:
    return otherwise if value is None else value


def printers_of(text: str) -> "list[Printer]":
    """Load the printers of a comma-separated list. Raises InputError for a name that repeats."""
    from walkergen.files import templates
    from walkergen.printing.printers import Printer

    found = [templates.load(name.strip(), "printers", Printer) for name in text.split(",")]
    names = [printer.name for printer in found]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"--printer {text[:60]!r}: two printers are called {name}")
    return found


def mode_of(mode: str, scene: "Scene") -> "Mode":
    """Check a mode's name. Raises InputError; so does mode paper unless the law is Poisson's."""
    from walkergen.theory.speed import MODES

    if mode not in MODES:
        raise InputError(f"--mode {mode!r}: must be one of {', '.join(MODES)}")
    if mode == "paper" and scene.contact.law != "poisson":
        raise InputError(
            f"--mode paper (eq. 15) is derived for law poisson only, seen {scene.contact.law}: "
            "use --mode coulomb"
        )
    return mode


def members_of(design: "Design", tilt: str | None, legs: str | None, whole: bool) -> "list[Design]":
    """List the variants asked for; without options the design alone or, if `whole`, its family."""
    tilts = parse_tilts(tilt) if tilt is not None else None
    kinds = parse_kinds(legs) if legs is not None else None
    if not whole:
        tilts = tilts or [design.tilt_deg]
        kinds = kinds or [design.kind]
    return design.members(tilts, kinds)


def batch_of(
    design: "Design", tilt: str | None, legs: str | None, copies: str | None, whole: bool
) -> "tuple[list[Design], list[int]]":
    """List the variants that a command line asks for, and the number of copies of each, or 1."""
    copies = "1" if copies is None else copies
    if ":" not in copies:
        members = members_of(design, tilt, legs, whole)
        return members, [_count(copies, copies)] * len(members)
    if tilt is not None:
        raise InputError(f"--copies {copies[:60]!r} names the tilts: leave --tilt out")
    quotas: dict[float, int] = {}
    for piece in copies.split(","):
        word, _, count = piece.partition(":")
        value = _number(word, copies, "--copies")
        quotas[value] = quotas.get(value, 0) + _count(count, copies)
    if legs is None and not whole:
        legs = design.kind
    members = design.members(quotas, parse_kinds(legs) if legs is not None else None)
    return members, [quotas[member.tilt_deg] for member in members]


def _count(word: str, text: str) -> int:
    from walkergen.files import columns

    count = columns.whole(word, MOST_COPIES)
    if count is None:
        raise InputError(
            f"--copies {text[:60]!r}: {word[:30]!r} must be a whole number in 1..{MOST_COPIES}; "
            "write 8, or TILT:COPIES,TILT:COPIES"
        )
    return count


def parse_tilts(text: str) -> list[float]:
    """Parse tilts in degrees: 10, or 5,10,15, or FIRST:LAST:STEP with both ends included."""
    found: list[float] = []
    for piece in text.split(","):
        numbers = [_number(word, text) for word in piece.split(":")]
        if len(numbers) == 1:
            found.append(numbers[0])
        elif len(numbers) == 3:
            first, last, step = numbers
            found += _range(first, last, step, text)
        else:
            raise InputError(f"--tilt {text!r}: write 10, or 5,10,15, or FIRST:LAST:STEP")
    unique = list(dict.fromkeys(found))
    if len(unique) > MOST_TILTS:
        raise InputError(f"--tilt {text[:60]!r}: {len(unique)} tilts; at most {MOST_TILTS}")
    return unique


def _number(word: str, text: str, option: str = "--tilt") -> float:
    try:
        value = float(word)
    except ValueError:
        raise InputError(f"{option} {text[:60]!r}: {word[:30]!r} is not a number") from None
    if not -85 <= value <= 85:
        raise InputError(f"{option} {text[:60]!r}: {word[:30]} must lie in -85..85 deg")
    return value + 0.0


def _range(first: float, last: float, step: float, text: str) -> list[float]:
    if step == 0 or (last - first) / step < 0:
        raise InputError(f"--tilt {text[:60]!r}: step {step:g} does not lead from first to last")
    count = (last - first) / step
    if count > MOST_TILTS:
        raise InputError(f"--tilt {text[:60]!r}: more than {MOST_TILTS} tilts; take a larger step")
    # Rounded to what people write, so that 0:1:0.1 gives 0.3 and not 0.30000000000000004.
    return [round(first + index * step, 9) + 0.0 for index in range(int(count + 1e-9) + 1)]


def parse_kinds(text: str) -> "list[Kind]":
    """Parse kinds of legs from a comma-separated list. Raises InputError."""
    from walkergen.walker.limbs import KINDS

    kinds: list[Any] = [word.strip() for word in text.split(",")]
    for kind in kinds:
        if kind not in KINDS:
            raise InputError(f"--legs {kind[:30]!r}: must be one of {', '.join(KINDS)}")
    return list(dict.fromkeys(kinds))
