"""Variants of a design as command lines name them: tilts, kinds of legs, copies."""

from typing import TYPE_CHECKING, Any

from walkergen.errors import InputError
from walkergen.files import words

if TYPE_CHECKING:
    from collections.abc import Sequence

    from walkergen.walker.design import Design
    from walkergen.walker.limbs import Kind

MOST_TILTS = 1000
MOST_COPIES = 5000

MARKERS = ("aruco",)
"""Markers that caps may bear: OpenCV's ArUco."""


def one_of(design: "Design", tilt: float | None, legs: str | None) -> "Design":
    """Find the single walker that a command line asks for. Raises InputError for two kinds."""
    kind = parse_kinds(legs) if legs is not None else [design.kind]
    if len(kind) != 1:
        raise InputError(f"--legs {str(legs)[:60]!r}: one kind at a time")
    (member,) = design.members([design.tilt_deg if tilt is None else tilt], kind)
    return member


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


def capped(members: "Sequence[Design]", markers: str | None) -> "list[Design]":
    """Walkers with caps of the markers that --caps asks for, where they have none yet.

    Raises InputError for markers of another kind.
    """
    from walkergen.files.assignments import changed

    if markers is None:
        return list(members)
    if markers not in MARKERS:
        raise InputError(f"--caps {markers[:30]!r}: must be {' or '.join(MARKERS)}")
    return [
        changed(design, {"cap.kind": "engraved"}, design.name) if design.cap is None else design for design in members
    ]


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
    tilts: list[float] = []
    for piece in text.split(","):
        numbers = [_number(word, text) for word in piece.split(":")]
        if len(numbers) == 1:
            tilts.append(numbers[0])
        elif len(numbers) == 3:
            first, last, step = numbers
            tilts += _range(first, last, step, text)
        else:
            raise InputError(f"--tilt {text[:60]!r}: write 10, or 5,10,15, or FIRST:LAST:STEP")
    unique = list(dict.fromkeys(tilts))
    if len(unique) > MOST_TILTS:
        raise InputError(f"--tilt {text[:60]!r}: {len(unique)} tilts; at most {MOST_TILTS}")
    return unique


def _number(word: str, text: str, option: str = "--tilt") -> float:
    value = words.value(word)
    if value is None:
        raise InputError(f"{option} {text[:60]!r}: {word[:30]!r} is not a number")
    if not -85 <= value <= 85:
        raise InputError(f"{option} {text[:60]!r}: {word[:30]} must lie in -85..85 deg")
    return value


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
