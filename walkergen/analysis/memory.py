"""Rates of turning that last for a while: whether tracks show it, exclude it, or leave it open.

Where it is left open, headings that lose direction late cannot be told from noise of the headings.
An exponential would then give a persistence too long, with an error that knows nothing of it: so
the rate is that of the fit with a memory, whose error holds for walkers without one as well.
"""

from collections.abc import Mapping, Sequence

from scipy import special

from walkergen.analysis import estimates, judgement
from walkergen.analysis.estimates import Frame
from walkergen.analysis.moments import Moments
from walkergen.numerics.quantity import Quantity

EXCLUDED = 0.025
"""Probability, for walkers whose memory lasts for a sample, of one that counts as shorter."""


def choose(sums: Sequence[Moments], frame: Frame) -> tuple[Frame, list[dict[str, float]]]:
    """Frame that says what the tracks tell of the memory, and the numbers that it gives.

    `sums` are those of all samples, then of those without each one, and so are the numbers.
    """
    if frame.lane or not frame.headed:
        return frame, numbers(sums, frame)
    late = frame._replace(memory=True)
    lasting = numbers(sums, late)
    memory = judgement.measured(lasting, "turning_memory")
    # Within a sample it cannot be told from less noise of the headings.
    if judgement.resolved(memory) and lasting[0]["turning_memory"] > frame.interval:
        return late, lasting
    at_once = numbers(sums, frame)
    if _shorter(memory, frame.interval):
        return frame, at_once
    return frame._replace(memory_open=True), _joined(at_once, lasting)


def numbers(sums: Sequence[Moments], frame: Frame) -> list[dict[str, float]]:
    """Numbers of each of the sums, with what `frame` says of the memory."""
    values = [estimates.evaluate(sample, frame) for sample in sums]
    if not frame.memory_open:
        return values
    late = frame._replace(memory=True)
    return _joined(values, [estimates.evaluate(sample, late) for sample in sums])


def _shorter(memory: Quantity, seconds: float) -> bool:
    """Whether a memory is shorter than `seconds` beyond what chance makes of it."""
    if memory.value is None or memory.se is None:
        return False
    errors = float(special.stdtrit(memory.freedom, 1.0 - EXCLUDED))
    return memory.value + errors * memory.se < seconds


def _joined(at_once: Sequence[Mapping[str, float]], lasting: Sequence[Mapping[str, float]]) -> list[dict[str, float]]:
    """Numbers of walkers without memory, but for the persistence, which is that with one.

    The memory itself is there to name a bound.
    """
    names = "persistence_rate", "persistence_time", "turning_memory"
    return [
        {
            **plain,
            **{name: late[name] for name in names},
            "persistence_length": abs(plain["speed"]) * late["persistence_time"],
        }
        for plain, late in zip(at_once, lasting, strict=True)
    ]
