"""Walkers and scenes of the table: what people build most often, its neighbours, and the rest."""

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from walkergen.errors import GeometryError
from walkergen.scene import Arena, Contact, Drive, Effects, Feet, LegModel, Plate, Run, Scene
from walkergen.theory import uncertain
from walkergen.theory.discrepancy import MOST_SLOPE_DEG
from walkergen.walker.body import Body
from walkergen.walker.design import Design
from walkergen.walker.limbs import Kind, Legs

SEED = 12

RUN = Run(seconds=1.5, discard_seconds=0.3, runs=6)
"""Runs of a row: 10.8 simulated seconds. Many rows with noise tell more than few without."""

ALL = Effects(unevenness=True, second_harmonic=True, plate_slope=True)
"""Effects that rows without them have too, to no effect: else every combination is compiled."""

Ranges = dict[str, tuple[float, float]]

PAPER: Ranges = {
    "tilt_share": (0.08, 0.9),
    "restitution": (0.03, 0.92),
    "log_friction": (math.log(0.08), math.log(0.45)),
    "gamma": (1.4, 2.6),
    "log_frequency_hz": (math.log(90.0), math.log(90.0)),
    "thickness_mm": (0.28, 0.62),
    "length_mm": (7.5, 7.5),
    "spacing_mm": (13.0, 13.0),
    "unevenness": (-0.1, 0.2),
    "body_length_mm": (28.0, 28.0),
    "body_thickness_mm": (3.0, 3.0),
    "depth_mm": (8.0, 8.0),
}
"""The paper's walker on its plate, in any contact. Tilts are those of `tilt_of`; negative
unevenness (over the plate's amplitude) means none."""

PRINTED: Ranges = PAPER | {
    "tilt_share": (0.0, 0.95),
    "log_friction": (math.log(0.17), math.log(0.33)),
    "gamma": (1.8, 1.8),
    "thickness_mm": (0.34, 0.47),
}
"""The same as its authors printed and drove it: the first walker that people ask about."""

PLATE: Ranges = PRINTED | {
    "tilt_share": (0.03, 0.92),
    "restitution": (0.05, 0.42),
    "log_friction": (math.log(0.2), math.log(0.3)),
    "thickness_mm": (0.37, 0.43),
}
"""The same in the contact of the paper's plate, and in its neighbourhood: a newcomer's numbers."""

USUAL: Ranges = PAPER | {
    "log_frequency_hz": (math.log(70.0), math.log(125.0)),
    "gamma": (1.3, 2.6),
    "length_mm": (6.0, 9.0),
    "spacing_mm": (11.0, 15.0),
    "body_length_mm": (24.0, 32.0),
    "body_thickness_mm": (2.5, 4.0),
    "depth_mm": (6.0, 10.0),
}
"""Walkers that people make of it."""

WIDE: Ranges = {
    "tilt_share": (0.0, 1.0),
    "restitution": (0.02, 1.0),
    "log_friction": (math.log(0.05), math.log(0.6)),
    "gamma": (1.1, 3.0),
    "log_frequency_hz": (math.log(50.0), math.log(150.0)),
    "thickness_mm": (0.25, 0.8),
    "length_mm": (5.0, 10.0),
    "spacing_mm": (9.0, 17.0),
    "unevenness": (-0.1, 0.25),
    "body_length_mm": (22.0, 36.0),
    "body_thickness_mm": (2.0, 5.0),
    "depth_mm": (5.0, 12.0),
}

EXTRAS: Ranges = {
    "harmonic_share": (0.0, 1.0),
    "harmonic_phase_deg": (-180.0, 180.0),
    "slope_share": (0.0, 1.0),
    "noise_share": (0.0, 1.0),
}
"""What most rows have none of: see `_extra`."""

NO_EXTRAS = dict.fromkeys(EXTRAS, 0.0)

WITH_EXTRA = 0.1
"""Share of the rows that have a second harmonic; the same share has a slope, and noise."""

MOST_HARMONIC, MOST_NOISE, MOST_SLOPE_RATIO = 0.5, 0.5, 0.8
"""Ratio of the second harmonic; rms of the plate's noise over its peak speed; tan(slope) over
friction, above which walkers soon slide off as they like."""


class Group(NamedTuple):
    """Rows that are sampled together."""

    kind: Kind
    ranges: Ranges
    rows: int
    """Number of its rows in a whole table."""
    extras: bool = True
    """False for rows without second harmonic, slope and noise."""


GROUPS = (
    Group("flexible", PRINTED, 2100, extras=False),
    Group("flexible", PAPER, 1800),
    Group("flexible", USUAL, 1020),
    Group("flexible", WIDE, 840),
    Group("braced", USUAL, 240),
    Group("flexible", PLATE, 700, extras=False),
)

COUNT = sum(group.rows for group in GROUPS)


class Case(NamedTuple):
    """Walker and scene of one row of the table."""

    scene: Scene
    design: Design


def cases(rows: int) -> Iterator[Case]:
    """Walkers and scenes of about so many rows; what cannot be built is left out.

    The groups take turns, so that a table of which a part is made is one of fewer rows.
    """
    sampled = [
        list(_samples(group, math.ceil(rows * group.rows / COUNT), SEED + number))
        for number, group in enumerate(GROUPS)
    ]
    ordered = sorted(
        ((place + 0.5) / len(group), number, place)
        for number, group in enumerate(sampled)
        for place in range(len(group))
    )
    for _, number, place in ordered:
        try:
            yield _case(GROUPS[number].kind, sampled[number][place])
        except GeometryError:
            continue


def _samples(group: Group, count: int, seed: int) -> Iterator[dict[str, float]]:
    """Numbers of a group's rows, by name."""
    ranges = group.ranges | EXTRAS
    low, high = np.array(list(ranges.values())).T
    for values in low + (high - low) * uncertain.even(len(ranges), count, seed):
        row = dict(zip(ranges, values.tolist(), strict=True))
        yield row if group.extras else row | NO_EXTRAS


def tilt_of(share: float) -> float:
    """Tilt, deg, from 0 to 45: half of them below 20, where speeds change most."""
    return float(45.0 * share ** (math.log(20.0 / 45.0) / math.log(0.5)))


def _extra(share: float, most: float) -> float:
    """Value of an extra, 0 for most rows, else evenly up to `most`."""
    return most * max(0.0, 1.0 - (1.0 - share) / WITH_EXTRA)


def _signed_extra(share: float, most: float) -> float:
    """As `_extra`, evenly from -most to most."""
    beyond = (1.0 - share) / WITH_EXTRA
    return 0.0 if beyond >= 1.0 else most * (2.0 * beyond - 1.0)


def _case(kind: Kind, value: dict[str, float]) -> Case:
    """Walker and scene of a row. Raises GeometryError for one that cannot be built."""
    body = Body(length_mm=value["body_length_mm"], thickness_mm=value["body_thickness_mm"], depth_mm=value["depth_mm"])
    legs: dict[str, Any] = {
        "kind": kind,
        "tilt_deg": tilt_of(value["tilt_share"]),
        "length_mm": value["length_mm"],
        "contact_spacing_mm": value["spacing_mm"],
    }
    if kind == "flexible":
        legs["flexible_thickness_mm"] = value["thickness_mm"]
    friction = math.exp(value["log_friction"])
    harmonic = _extra(value["harmonic_share"], MOST_HARMONIC)
    drive = Drive(
        frequency_hz=math.exp(value["log_frequency_hz"]),
        gamma=value["gamma"],
        second_harmonic_ratio=harmonic,
        second_harmonic_phase_deg=value["harmonic_phase_deg"] if harmonic else 0.0,
    )
    most = min(math.radians(MOST_SLOPE_DEG), math.atan(MOST_SLOPE_RATIO * friction))
    plate = Plate(
        slope_deg=math.degrees(_signed_extra(value["slope_share"], most)),
        noise_ratio=_extra(value["noise_share"], MOST_NOISE),
    )
    scene = Scene(
        drive=drive,
        contact=Contact(restitution=value["restitution"], friction=friction),
        plate=plate,
        arena=Arena(kind="plane"),
        legs=LegModel(model="space"),
        feet=Feet(unevenness_um=1e3 * drive.amplitude * max(value["unevenness"], 0.0)),
        run=RUN,
        effects=ALL,
    )
    return Case(scene, Design(body=body, legs=Legs(**legs)))
