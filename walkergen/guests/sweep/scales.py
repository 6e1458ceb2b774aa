"""Scales of the axes of a picture: the values of a key as positions, and as text with units."""

from collections.abc import Sequence
from typing import Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

from walkergen.core import Array
from walkergen.core.files.formatting import is_number
from walkergen.files.figures import wrap_text
from walkergen.files.key_names import format_key

LOG_MIN_RATIO, LOG_MAX_MEDIAN = 30.0, 1 / 3
"""An axis of positive values is logarithmic if the largest is more than LOG_MIN_RATIO times the smallest, and if the
median is below LOG_MAX_MEDIAN times the largest. Evenly spaced values thus have a linear axis."""

MAX_WORD_TICKS = 12

NAME_INCHES = 2.1
"""Width at which the name of an axis is wrapped, inches: about the width of a panel."""


class Scale(NamedTuple):
    """Distinct values of a key, their positions on an axis, and the index of each row's value among them."""

    key: str
    values: tuple[Any, ...]
    """Distinct values, numbers in rising order, words in the order of the rows."""
    positions: Array
    """Positions of `values` on the axis: the numbers themselves, or 0, 1, 2 for words."""
    indices: npt.NDArray[np.intp]
    """Index in `values` of the value of each row."""
    has_words: bool
    """Whether the values are words; False for numbers."""
    log: bool
    """Whether the axis is logarithmic."""

    @property
    def row_positions(self) -> Array:
        """Positions of the rows on the axis, shape (n,)."""
        return self.positions[self.indices]

    @property
    def unit(self) -> str:
        """Unit of the values; "" without one."""
        return format_key(self.key).partition(" (")[2].rstrip(")")


def make_scale(key: str, values: Sequence[Any]) -> Scale:
    """Return the scale of a key from its values in all rows. If any is not a number, all are words."""
    words = not all(is_number(value) for value in values)
    entries = [_to_word(value) if words else value for value in values]
    distinct = list(dict.fromkeys(entries)) if words else sorted(set(entries))
    index_of = {value: number for number, value in enumerate(distinct)}
    positions = np.array(range(len(distinct)) if words else distinct, dtype=float)
    log = not words and positions[0] > 0 and positions[-1] > LOG_MIN_RATIO * positions[0]
    log = bool(log and np.median(positions) < LOG_MAX_MEDIAN * positions[-1])
    index = np.array([index_of[value] for value in entries], dtype=np.intp)
    return Scale(key, tuple(distinct), positions, index, words, log)


def _to_word(value: Any) -> str:
    """Return a value as text, with None, True and False in lower case."""
    return str(value).lower() if value is None or isinstance(value, bool) else str(value)


def format_value(scale: Scale, number: int, named: bool = True) -> str:
    """Format the value with index `number` of a scale: "tilt of the legs 10 deg" or, if not `named`, "10 deg"."""
    name, value = format_key(scale.key).partition(" (")[0], scale.values[number]
    parts = (name if named else "", value if scale.has_words else f"{value:.5g}", scale.unit)
    return " ".join(part for part in parts if part)


def cell_edges(scale: Scale) -> Array:
    """Return the edges of a map's cells along a scale, half-way between neighbouring values, shape (values + 1,)."""
    positions = np.log(scale.positions) if scale.log else scale.positions
    if len(positions) == 1:
        return np.array([positions[0] - 0.5, positions[0] + 0.5])
    middle = 0.5 * (positions[1:] + positions[:-1])
    borders = np.concatenate([[2 * positions[0] - middle[0]], middle, [2 * positions[-1] - middle[-1]]])
    return np.exp(borders) if scale.log else borders


def format_axis(axes: Axes, direction: Literal["x", "y"], scale: Scale) -> None:
    """Set label, scaling (linear or logarithmic) and ticks of the x or y axis for the scale of a key."""
    axis = axes.xaxis if direction == "x" else axes.yaxis
    axis.set_label_text(wrap_text(format_key(scale.key), NAME_INCHES))
    if scale.log:
        axes.set(**{f"{direction}scale": "log"})
        decades = np.log10(scale.positions[-1] / scale.positions[0])
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if decades < 2.5 else (1.0,)))
        axis.set_major_formatter(StrMethodFormatter("{x:g}"))
        axis.set_minor_formatter(NullFormatter())
    elif scale.has_words:
        stride = -(-len(scale.values) // MAX_WORD_TICKS)
        shown = [word if len(word) <= 14 else word[:13] + "…" for word in scale.values][::stride]
        axis.set_ticks(scale.positions[::stride].tolist(), shown)
        if direction == "x" and sum(map(len, shown)) > 30:
            axes.tick_params(axis="x", rotation=30)
