"""Chart of speeds against tilt for the page: places of its marks, bars, axes and labels.

Only numbers here; the page's template draws them. Coordinates are SVG user units, y downwards.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

from walkergen.jobs.page.members import Member

WIDTH, HEIGHT = 600.0, 380.0
LEFT, RIGHT, TOP, BOTTOM = 64.0, 14.0, 14.0, 50.0
MARGIN = 0.04
"""Share of the range of the data that is left free on every side."""


class Point(NamedTuple):
    """Point of the chart: a speed with its error bar."""

    member: int
    legs: str
    simulated: bool
    x: float
    y: float
    low: float | None
    """End of the bar of 68 % (predicted) or of 95 % (simulated); None: unknown."""
    high: float | None
    label: str


class Line(NamedTuple):
    """Straight lines from member to member of one kind of legs: a guide to the eye."""

    legs: str
    simulated: bool
    points: str


class Tick(NamedTuple):
    """Mark of an axis: its place along it, and its text."""

    at: float
    text: str


class Chart(NamedTuple):
    """Points, lines and ticks of the chart."""

    points: list[Point]
    lines: list[Line]
    x_ticks: list[Tick]
    y_ticks: list[Tick]


class _Speed(NamedTuple):
    member: int
    tilt: float
    legs: str
    simulated: bool
    value: float
    low: float | None
    high: float | None


def speeds(members: Sequence[Member]) -> Chart:
    """Make the chart of predicted speeds and, where the table has any, simulated speeds."""
    found = [speed for number, member in enumerate(members) for speed in _of(number, member)]
    tilts = _padded([speed.tilt for speed in found])
    ends = [end for speed in found for end in speed[-3:] if end is not None]
    values = _padded([*ends, 0.0])
    points = [_point(speed, tilts, values) for speed in found]
    return Chart(
        points,
        _lines(points),
        [Tick(_x(value, tilts), _text(value)) for value in ticks(*tilts)],
        [Tick(_y(value, values), _text(value)) for value in ticks(*values)],
    )


def ticks(low: float, high: float) -> list[float]:
    """Four to ten multiples of 1, 2 or 5 times a power of ten, inside the range."""
    power = 10.0 ** math.floor(math.log10((high - low) / 4.0))
    step = max(f * power for f in (1.0, 2.0, 5.0) if 4.0 * f * power <= (high - low) * (1 + 1e-9))
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    return [number * step for number in range(first, last + 1)]


def _of(number: int, member: Member) -> list[_Speed]:
    """Speeds of one member, predicted and simulated."""
    bounds = member.number("speed_low_68_mm_s"), member.number("speed_high_68_mm_s")
    found = [_Speed(number, member.tilt_deg, member.legs, False,
                    float(member.row["speed_mm_s"]), *bounds)]  # fmt: skip
    speed = member.number("sim_speed_mm_s")
    if speed is not None:
        ends = member.number("sim_low_95_mm_s"), member.number("sim_high_95_mm_s")
        found.append(_Speed(number, member.tilt_deg, member.legs, True, speed, *ends))
    return found


def _point(speed: _Speed, tilts: tuple[float, float], values: tuple[float, float]) -> Point:
    source, share = ("simulated", "95 %") if speed.simulated else ("predicted", "68 %")
    told = "mm/s, error unknown"
    if speed.low is not None and speed.high is not None:
        told = f"mm/s ({share}: {speed.low:.1f} to {speed.high:.1f})"
    return Point(
        member=speed.member,
        legs=speed.legs,
        simulated=speed.simulated,
        x=_x(speed.tilt, tilts),
        y=_y(speed.value, values),
        low=None if speed.low is None else _y(speed.low, values),
        high=None if speed.high is None else _y(speed.high, values),
        label=f"{speed.legs} legs, {speed.tilt:g}°: "
        f"{source} {round(speed.value, 1) + 0.0:.1f} {told}".replace("-", "−"),
    )


def _lines(points: Sequence[Point]) -> list[Line]:
    lines = []
    for legs, simulated in dict.fromkeys((point.legs, point.simulated) for point in points):
        chosen = sorted((p.x, p.y) for p in points if (p.legs, p.simulated) == (legs, simulated))
        lines.append(Line(legs, simulated, " ".join(f"{x:g},{y:g}" for x, y in chosen)))
    return lines


def _padded(values: Sequence[float]) -> tuple[float, float]:
    """Range that holds all values with a margin; of width 1 at least, for a single member."""
    low, high = min(values), max(values)
    if high - low < 1.0:
        low, high = low - 0.5, high + 0.5
    margin = MARGIN * (high - low)
    return low - margin, high + margin


def _x(tilt: float, tilts: tuple[float, float]) -> float:
    share = (tilt - tilts[0]) / (tilts[1] - tilts[0])
    return round(LEFT + share * (WIDTH - LEFT - RIGHT), 2)


def _y(speed: float, values: tuple[float, float]) -> float:
    share = (speed - values[0]) / (values[1] - values[0])
    return round(HEIGHT - BOTTOM - share * (HEIGHT - TOP - BOTTOM), 2)


def _text(value: float) -> str:
    return f"{value + 0.0:g}".replace("-", "−")
