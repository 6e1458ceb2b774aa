"""Chart of speeds against tilt for the page: places of its marks, bands, bars, axes and labels.

It shows what speed.png shows, of the same rows. Only numbers here; the page's template draws them.
Coordinates are SVG user units, y downwards.
"""

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise, product
from typing import Literal, NamedTuple

from walkergen.jobs.make.family.chart_data import Speed
from walkergen.points.members import Member

WIDTH, HEIGHT = 600.0, 400.0
LEFT, RIGHT, TOP, BOTTOM = 64.0, 14.0, 30.0, 50.0
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
    """Line of one kind of legs."""

    legs: str
    what: Literal["predicted", "theory", "guide"]
    """Guides to the eye only join the members, where nothing is predicted between them."""
    points: str


class Band(NamedTuple):
    """Area between the bounds of one kind of legs."""

    legs: str
    share: int
    """Share of walkers that run at speeds in between, %."""
    points: str


class Mark(NamedTuple):
    """Speed that was measured, or that the paper states, with its bar of 95 %."""

    what: str
    legs: str
    x: float
    y: float
    low: float | None
    high: float | None
    label: str


class Tick(NamedTuple):
    """Mark of an axis: its place along it, and its text."""

    at: float
    text: str


class Chart(NamedTuple):
    """Points, lines, bands, marks and ticks of the chart."""

    points: list[Point]
    lines: list[Line]
    bands: list[Band]
    marks: list[Mark]
    gaps: bool
    """True where curves are broken, at tilts that a run has yet to tell."""
    sticking: tuple[float, float] | None
    """Ends, along x, of the tilts at which a flexible foot can stick."""
    x_ticks: list[Tick]
    y_ticks: list[Tick]


class _Frame(NamedTuple):
    """Ranges of both axes."""

    tilts: tuple[float, float]
    values: tuple[float, float]

    def x(self, tilt: float) -> float:
        """Place of a tilt, deg."""
        share = (tilt - self.tilts[0]) / (self.tilts[1] - self.tilts[0])
        return round(LEFT + share * (WIDTH - LEFT - RIGHT), 2)

    def y(self, speed: float) -> float:
        """Place of a speed, mm/s."""
        share = (speed - self.values[0]) / (self.values[1] - self.values[0])
        return round(HEIGHT - BOTTOM - share * (HEIGHT - TOP - BOTTOM), 2)

    def path(self, points: Sequence[tuple[float, float]]) -> str:
        """Points (tilt, speed) as SVG writes them."""
        return " ".join(f"{self.x(tilt):g},{self.y(speed):g}" for tilt, speed in points)


class _Speed(NamedTuple):
    member: int
    tilt: float
    legs: str
    simulated: bool
    value: float
    low: float | None
    high: float | None


def speeds(members: Sequence[Member], chart_data: Sequence[Speed] = ()) -> Chart:
    """Make the chart of predicted speeds, simulated ones if any, and of what stands beside them."""
    family = [speed for number, member in enumerate(members) for speed in _of(number, member)]
    ends = [speed.value for speed in family]
    ends += [end for speed in family for end in (speed.low, speed.high) if end is not None]
    ends += [end for speed in chart_data for end in (speed.speed_mm_s, *_bounds(speed)) if end is not None]
    ends += [speed.theory_mm_s for speed in chart_data if speed.theory_mm_s is not None]
    tilts = [*(member.row.tilt_deg for member in members), *(speed.tilt_deg for speed in chart_data)]
    frame = _Frame(_padded(tilts), _padded([*ends, 0.0]))
    between = sorted((speed for speed in chart_data if speed.what == "predicted"), key=_tilt)
    curves = {
        legs: [speed for speed in between if speed.legs == legs]
        for legs in dict.fromkeys([*(speed.legs for speed in family), *(speed.legs for speed in between)])
    }
    return Chart(
        [_point(speed, frame) for speed in family],
        [line for legs, curve in curves.items() for line in _lines(legs, curve, family, frame)],
        [band for legs, curve in curves.items() for band in _bands_of(legs, curve, frame)],
        [_mark(speed, frame) for speed in chart_data if speed.what != "predicted"],
        any(len(_stretches(curve)) > 1 for curve in curves.values()),
        _sticking(between, frame),
        [Tick(frame.x(value), _text(value)) for value in ticks(*frame.tilts)],
        [Tick(frame.y(value), _text(value)) for value in ticks(*frame.values)],
    )


def ticks(low: float, high: float) -> list[float]:
    """Four to ten multiples of 1, 2 or 5 times a power of ten, inside the range."""
    power = 10.0 ** math.floor(math.log10((high - low) / 4.0))
    step = max(f * power for f in (1.0, 2.0, 5.0) if 4.0 * f * power <= (high - low) * (1 + 1e-9))
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    return [number * step for number in range(first, last + 1)]


def _of(number: int, member: Member) -> list[_Speed]:
    """Speeds of one member, predicted and simulated."""
    row, runs = member.row, member.simulated
    bounds = row.speed_low_68_mm_s, row.speed_high_68_mm_s
    speeds = []
    if row.speed_mm_s is not None:
        speeds.append(_Speed(number, row.tilt_deg, row.legs, False, row.speed_mm_s, *bounds))
    if runs is not None and runs.sim_speed_mm_s is not None:
        ends = runs.sim_low_95_mm_s, runs.sim_high_95_mm_s
        speeds.append(_Speed(number, row.tilt_deg, row.legs, True, runs.sim_speed_mm_s, *ends))
    return speeds


def _bounds(speed: Speed) -> tuple[float | None, ...]:
    """Lower and upper bound of 68 %, then of 95 %, mm/s."""
    return speed[4:8]


def _tilt(speed: Speed) -> float:
    return speed.tilt_deg


def _point(speed: _Speed, frame: _Frame) -> Point:
    source, share = ("simulated", "95 %") if speed.simulated else ("predicted", "68 %")
    amount = "mm/s, error unknown"
    if speed.low is not None and speed.high is not None:
        amount = f"mm/s ({share}: {speed.low:.1f} to {speed.high:.1f})"
    return Point(
        member=speed.member,
        legs=speed.legs,
        simulated=speed.simulated,
        x=frame.x(speed.tilt),
        y=frame.y(speed.value),
        low=None if speed.low is None else frame.y(speed.low),
        high=None if speed.high is None else frame.y(speed.high),
        label=f"{speed.legs} legs, {speed.tilt:g}°: {source} {round(speed.value, 1) + 0.0:.1f} {amount}".replace(
            "-", "−"
        ),
    )


def _lines(legs: str, curve: Sequence[Speed], family: Sequence[_Speed], frame: _Frame) -> Iterator[Line]:
    """Predicted speed and theory of a kind of legs; without them, lines from member to member."""
    if not curve:
        members = (speed for speed in family if speed.legs == legs and not speed.simulated)
        joined = sorted((speed.tilt, speed.value) for speed in members)
        yield Line(legs, "guide", frame.path(joined))
        return
    for part in _stretches(curve):
        yield Line(legs, "predicted", frame.path([(speed.tilt_deg, speed.speed_mm_s) for speed in part]))
        theory = [(speed.tilt_deg, speed.theory_mm_s) for speed in part if speed.theory_mm_s is not None]
        yield Line(legs, "theory", frame.path(theory))


def _bands_of(legs: str, curve: Sequence[Speed], frame: _Frame) -> Iterator[Band]:
    """Bounds of 95 and 68 % around a kind's predicted speed."""
    for share, part in product((95, 68), _stretches(curve)):
        there = [(speed.tilt_deg, getattr(speed, f"speed_low_{share}_mm_s")) for speed in part]
        back = [(speed.tilt_deg, getattr(speed, f"speed_high_{share}_mm_s")) for speed in reversed(part)]
        yield Band(legs, share, frame.path([*there, *back]))


def _stretches(curve: Sequence[Speed]) -> list[list[Speed]]:
    """Parts of a curve whose tilts are equally far apart; in the gaps between them a run has yet to tell."""
    gaps = [after.tilt_deg - before.tilt_deg for before, after in pairwise(curve)]
    step = 1.5 * min(gaps, default=0.0)
    ends = [0, *(number for number, gap in enumerate(gaps, start=1) if gap > step), len(curve)]
    return [list(curve[first:last]) for first, last in pairwise(ends) if last > first]


def _mark(speed: Speed, frame: _Frame) -> Mark:
    amount = f"{round(speed.speed_mm_s, 1) + 0.0:.1f} mm/s"
    low, high = speed.speed_low_95_mm_s, speed.speed_high_95_mm_s
    if low is not None and high is not None:
        amount += f" (95 %: {low:.1f} to {high:.1f})"
    source = "measured" if speed.what == "measured" else "stated by the paper"
    return Mark(
        what=speed.what,
        legs=speed.legs,
        x=frame.x(speed.tilt_deg),
        y=frame.y(speed.speed_mm_s),
        low=None if low is None else frame.y(low),
        high=None if high is None else frame.y(high),
        label=f"{speed.legs} legs, {speed.tilt_deg:g}°: {source} {amount}".replace("-", "−"),
    )


def _sticking(between: Sequence[Speed], frame: _Frame) -> tuple[float, float] | None:
    tilts = [speed.tilt_deg for speed in between if speed.foot_can_stick == "yes" and speed.legs == "flexible"]
    return (frame.x(min(tilts)), frame.x(max(tilts))) if tilts else None


def _padded(values: Sequence[float]) -> tuple[float, float]:
    """Range that holds all values with a margin; of width 1 at least, for a single member."""
    low, high = min(values), max(values)
    if high - low < 1.0:
        low, high = low - 0.5, high + 0.5
    margin = MARGIN * (high - low)
    return low - margin, high + margin


def _text(value: float) -> str:
    return f"{value + 0.0:g}".replace("-", "−")
