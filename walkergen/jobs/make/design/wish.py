"""Wishes: what a design shall do, within which error, and what a point's record says of it."""

import math
from typing import Literal, NamedTuple

from walkergen.errors import InputError
from walkergen.points.point import WENT, Record, Went
from walkergen.points.tolerance import Tolerance

Quantity = Literal["speed", "persistence length", "turning radius", "turning down the slope", "turning up the slope"]

UNITS: dict[Quantity, str] = {
    "speed": "mm/s",
    "persistence length": "mm",
    "turning radius": "mm",
    "turning down the slope": "rad/s",
    "turning up the slope": "rad/s",
}
OPTIONS: dict[str, Quantity] = {
    "--speed": "speed",
    "--persistence": "persistence length",
    "--turning-radius": "turning radius",
}

Way = Literal["down", "up"]
"""Way in which a slope shall turn headings."""

TURNS: dict[Way, Quantity] = {"down": "turning down the slope", "up": "turning up the slope"}

LEAST, LARGEST = 1e-6, 1e9
"""Least and largest number that may be wished, mm/s or mm."""

NORMAL_95 = 1.96
"""Standard errors to either side that hold 95 %, of many runs."""


RESOLVED = 2.0
"""Standard errors by which a rate of turning must differ from 0 for its length to be one."""


class Wish(NamedTuple):
    """What a design shall do: a value of a quantity, or the fastest, or the least sensitive."""

    of: Quantity
    target: float | None
    """Value wished, in UNITS; None for the fastest, the least sensitive or the most turning of all."""
    calm: bool
    """True for the smallest change of speed with friction, among those with the target if any."""
    error: Tolerance

    @property
    def slug(self) -> str:
        """Name for files: speed40, fastest, speed40-least-sensitive."""
        calm = "least-sensitive" if self.calm else ""
        if self.way is not None:
            return f"turn-{self.way}"
        if self.target is None:
            return calm or "fastest"
        name = {"speed": "speed", "persistence length": "persistence", "turning radius": "radius"}
        value = f"{name[self.of]}{self.target:g}".replace("+", "")
        return "-".join(filter(None, (value.replace(".", "p"), calm)))

    @property
    def words(self) -> str:
        """Wish as people say it."""
        calm = "least sensitive to friction" if self.calm else ""
        if self.way is not None:
            return f"most {self.of}"
        if self.target is None:
            return calm or "fastest"
        value = f"{self.of} {self.target:g} {UNITS[self.of]}"
        return f"{value}, {calm}" if calm else value

    @property
    def way(self) -> Way | None:
        """Way in which a slope shall turn headings; None for other wishes."""
        return next((way for way, quantity in TURNS.items() if quantity == self.of), None)

    @property
    def logarithmic(self) -> bool:
        """True for lengths, which vary over decades."""
        return UNITS[self.of] == "mm"

    @property
    def asks_space(self) -> bool:
        """True for what only a walker that turns has."""
        return self.of != "speed"

    def allowed(self, value: float) -> float:
        """Error that is allowed: a share counts of the target, without one of `value`."""
        return self.allowed_of(value if self.target is None else self.target)

    def allowed_of(self, value: float) -> float:
        """Error that is allowed of a value, whatever the target."""
        return self.error.value * (abs(value) if self.error.relative else 1.0)


def of_options(
    speed: float | None,
    persistence: float | None,
    radius: float | None,
    turn: Way | None,
    fastest: bool,
    calm: bool,
    error: Tolerance,
) -> Wish:
    """Wish of a command line. Raises InputError unless it is exactly one that can be."""
    by_option = dict(zip(OPTIONS, (speed, persistence, radius), strict=True))
    targets = {name: value for name, value in by_option.items() if value is not None}
    named = [*targets, *(["--turn"] if turn else []), *(["--fastest"] if fastest else [])]
    if len(named) > 1 or (calm and named not in ([], ["--speed"])):
        both = " and ".join([*named, *(["--least-sensitive"] if calm else [])])
        raise InputError(f"{both}: one wish at a time; only --speed and --least-sensitive go together")
    if not named and not calm:
        raise InputError(
            "no wish: give --speed 40, --fastest, --least-sensitive, --persistence MM, --turning-radius MM "
            "or --turn down"
        )
    if turn and not error.relative:
        raise InputError(f"--error {error}: a speed is no error of a rate of turning: write 10%")
    if turn:
        return Wish(TURNS[turn], None, calm, error)
    if not targets:
        return Wish("speed", None, calm, error)
    ((name, value),) = targets.items()
    _check(name, value, error)
    return Wish(OPTIONS[name], value, calm, error)


def _check(name: str, value: float, error: Tolerance) -> None:
    """Refuse targets that are no number, or of which no share can be. Raises InputError."""
    unit = UNITS[OPTIONS[name]]
    if not (value == 0.0 or LEAST <= abs(value) <= LARGEST):
        raise InputError(f"{name} {value:g}: must be a number of {unit}, {LEAST:g} at least, {LARGEST:g} at most")
    if name != "--speed":
        if not value > 0.0:
            raise InputError(f"{name} {value:g}: must be a length in mm above 0")
        if not error.relative:
            raise InputError(f"--error {error}: a speed is no error of a length: write 10%")
    elif value == 0.0 and error.relative:
        raise InputError(f"--speed 0: {error} of 0 is no error: say --error 1mm/s, or wish another speed")


class Seen(NamedTuple):
    """What a record says of a quantity."""

    value: float
    se: float
    """Standard error of the runs; 0 of a predicted one."""

    @property
    def above_0(self) -> bool:
        """True when the bounds of 95 % lie above 0."""
        return self.value > NORMAL_95 * self.se


def seen(record: Record, of: Quantity) -> Seen | None:
    """Value of a quantity in a record, with its standard error; None where it has none.

    A persistence length is the speed over the rotational diffusion, which runs shorter than the
    persistence tell too; a turning radius is the speed over the turning bias. Turning by a slope is
    the rate at 90 degrees to its descent, below 0 where headings turn the other way.
    """
    if of == "speed":
        return _pair(record, "speed_mm_s", "se_mm_s")
    if of in TURNS.values():
        rate = _pair(record, "slope_turning_rad_s", "slope_turning_se_rad_s")
        return rate if rate is None or of == TURNS["down"] else Seen(-rate.value, rate.se)
    name = "rotational_diffusion" if of == "persistence length" else "turning_bias"
    unit = "rad2_s" if of == "persistence length" else "rad_s"
    speed, rate = (_pair(record, "speed_mm_s", "se_mm_s"), _pair(record, f"{name}_{unit}", f"{name}_se_{unit}"))
    if speed is None or rate is None or speed.value == 0.0:
        return None
    if abs(rate.value) <= RESOLVED * rate.se:
        return None
    length = abs(speed.value / rate.value)
    return Seen(length, length * math.hypot(speed.se / speed.value, rate.se / rate.value))


def alignment(record: Record) -> Seen | None:
    """Self-alignment in a record, 1/mm; None where it has none."""
    return _pair(record, "self_alignment_per_mm", "self_alignment_se_per_mm")


def _pair(record: Record, name: str, error: str) -> Seen | None:
    value, se = record.get(name), record.get(error)
    if "runs" not in record:  # predicted
        se = 0.0
    if not isinstance(value, (int, float)) or not isinstance(se, (int, float)):
        return None
    return Seen(float(value), float(se))


def bounds(record: Record, of: Quantity) -> tuple[float, float] | None:
    """Bounds of 95 % of a quantity, the step's error in those of a speed; None where unknown.

    Those of a prediction are what is not known exactly of print, contact and model.
    """
    ends = ("predicted_low_95_mm_s", "predicted_high_95_mm_s")
    if of == "speed":
        if "runs" in record:
            ends = ("low_95_mm_s", "high_95_mm_s")
        low, high = (record.get(end) for end in ends)
        if isinstance(low, (int, float)) and isinstance(high, (int, float)):
            return float(low), float(high)
        return None
    quantity = seen(record, of)
    if quantity is None:
        return None
    return quantity.value - NORMAL_95 * quantity.se, quantity.value + NORMAL_95 * quantity.se


def ended_well(record: Record) -> bool:
    """True for a record whose numbers stand, with whatever error."""
    return record[WENT] in (Went.OK, Went.NOT_MET)
