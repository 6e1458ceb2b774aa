"""Options that several commands share, and the parsing of tilts and lists."""

import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from walkergen.errors import InputError

if TYPE_CHECKING:
    from walkergen.printing.printers import Printer
    from walkergen.scene import Scene
    from walkergen.theory.speed import Mode
    from walkergen.walker.design import Design, Kind

PAPER, SCENE, PRINTER = "koumakis2016", "lane-90hz", "prusa-mk3s"
"""The templates that commands take unless told otherwise."""

MOST_TILTS = 1000
MOST_COPIES = 5000

DesignName = Annotated[
    str, typer.Argument(metavar="DESIGN", help="A template's name or the path of a TOML file.")
]
OneTilt = Annotated[float | None, typer.Option("--tilt", metavar="DEG", help="Tilt of the legs.")]
OneKind = Annotated[str | None, typer.Option("--legs", metavar="KIND", help="flexible or braced.")]
Tilt = Annotated[
    str | None,
    typer.Option("--tilt", metavar="DEG", help="Tilts: 10, or 5,10,15, or FIRST:LAST:STEP."),
]
LegKinds = Annotated[
    str | None, typer.Option("--legs", metavar="KIND", help="flexible, braced, or flexible,braced.")
]
SceneName = Annotated[
    str, typer.Option("--scene", metavar="SCENE", help="A template's name or a TOML file.")
]
Restitution = Annotated[
    float | None, typer.Option("--restitution", help="Coefficient of restitution, 0..1.")
]
Friction = Annotated[float | None, typer.Option("--friction", help="Coulomb friction, >= 0.")]
ModeName = Annotated[
    str,
    typer.Option("--mode", metavar="MODE", help="coulomb (feet may stick) or paper (eq. 15)."),
]
LawName = Annotated[
    str | None,
    typer.Option("--law", metavar="LAW", help="Law of restitution: poisson, newton, stronge."),
]
Seconds = Annotated[
    float | None, typer.Option("--seconds", help="Measured time of each simulated run, s.")
]
Runs = Annotated[int | None, typer.Option("--runs", help="Independent simulated runs.")]
Seed = Annotated[int | None, typer.Option("--seed", help="Seed of the runs' phases and drops.")]
Model = Annotated[
    str | None, typer.Option("--model", metavar="MODEL", help="rigid, relaxed, compliant or auto.")
]
Method = Annotated[
    str | None, typer.Option("--method", metavar="METHOD", help="event, step or auto.")
]
Gamma = Annotated[float | None, typer.Option("--gamma", help="Peak acceleration over g.")]
Frequency = Annotated[float | None, typer.Option("--frequency", help="Frequency of the drive, Hz.")]
Step = Annotated[
    float | None, typer.Option("--step", metavar="MICROSECONDS", help="Step of method step.")
]
Pictures = Annotated[bool, typer.Option(help="Draw the figures.")]
PrinterName = Annotated[
    str, typer.Option("--printer", metavar="PRINTER", help="A template's name or a TOML file.")
]
Copies = Annotated[
    str,
    typer.Option("--copies", metavar="COPIES", help="Copies of each: 8; or by tilt: 10:20,15:40."),
]
MaxParts = Annotated[
    int, typer.Option("--max-parts", min=1, max=5000, help="Most parts on one plate.")
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
    typer.Option("--out", metavar="FOLDER", help="Folder to write; out/NAME by default."),
]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON instead of a table.")]
Strict = Annotated[
    bool, typer.Option("--strict", help="Refuse what prints otherwise than predicted, too.")
]
Quiet = Annotated[bool, typer.Option("--quiet", help="Print nothing but errors.")]


def design_of(name: str) -> "Design":
    """The design of a template's name or a file's path."""
    from walkergen.files import templates
    from walkergen.walker.design import Design

    return templates.load(name, "walkers", Design)


def one_design(name: str, tilt: float | None, legs: str | None) -> "Design":
    """The one walker that a command line asks for."""
    design = design_of(name)
    kind = parse_kinds(legs) if legs is not None else [design.legs.kind]
    if len(kind) != 1:
        raise InputError(f"--legs {legs!r}: one kind at a time")
    (member,) = design.members([design.legs.tilt_deg if tilt is None else tilt], kind)
    return member


class Changes(NamedTuple):
    """What the command line changes in a scene; None keeps the scene's own value."""

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
    """The scene of a name or path, with the command line's values in place of its own."""
    from walkergen.files import templates
    from walkergen.files.config import validate
    from walkergen.scene import Scene

    scene = templates.load(name, "scenes", Scene)
    data: dict[str, dict[str, Any]] = scene.model_dump(exclude_none=True)
    if changes.gamma is not None or changes.frequency is not None:
        # Two numbers determine the drive: the new ones, completed from the scene's own.
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
    """The printers of a comma-separated list of names or paths."""
    from walkergen.files import templates
    from walkergen.printing.printers import Printer

    found = [templates.load(name.strip(), "printers", Printer) for name in text.split(",")]
    names = [printer.name for printer in found]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"--printer {text[:60]!r}: two printers are called {name}")
    return found


def mode_of(mode: str, scene: "Scene") -> "Mode":
    """The mode by its name; mode paper exists for Poisson's law only."""
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
    """The variants a command line asks for; without options the design's own, or its family."""
    tilts = parse_tilts(tilt) if tilt is not None else None
    kinds = parse_kinds(legs) if legs is not None else None
    if not whole:
        tilts = tilts or [design.legs.tilt_deg]
        kinds = kinds or [design.legs.kind]
    return design.members(tilts, kinds)


def batch_of(
    design: "Design", tilt: str | None, legs: str | None, copies: str, whole: bool
) -> "tuple[list[Design], list[int]]":
    """The variants a command line asks for and how many of each to print."""
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
        legs = design.legs.kind
    members = design.members(quotas, parse_kinds(legs) if legs is not None else None)
    return members, [quotas[member.legs.tilt_deg] for member in members]


def _count(word: str, text: str) -> int:
    if not re.fullmatch(r"\s*[0-9]{1,9}\s*", word) or not 1 <= int(word) <= MOST_COPIES:
        raise InputError(
            f"--copies {text[:60]!r}: {word[:30]!r} must be a whole number in 1..{MOST_COPIES}; "
            "write 8, or TILT:COPIES,TILT:COPIES"
        )
    return int(word)


def parse_tilts(text: str) -> list[float]:
    """Tilts in degrees from 10, from 5,10,15 or from FIRST:LAST:STEP (both ends included)."""
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
    """Kinds of legs from a comma-separated list."""
    from walkergen.walker.design import KINDS

    kinds: list[Any] = [word.strip() for word in text.split(",")]
    for kind in kinds:
        if kind not in KINDS:
            raise InputError(f"--legs {kind[:30]!r}: must be one of {', '.join(KINDS)}")
    return list(dict.fromkeys(kinds))
