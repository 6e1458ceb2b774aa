"""Limits: what stopped a search that found no design for its wish."""

from walkergen.files import words
from walkergen.jobs.make.design.lab import Job, Trial
from walkergen.jobs.make.design.search import Search
from walkergen.jobs.make.design.verify import Verified
from walkergen.jobs.make.design.wish import UNITS


def stopped(job: Job, result: Search, designs: list[Verified]) -> str:
    """Line on a wish that no design meets: the nearest value, and the limit that is in the way."""
    wish, unit = job.wish, UNITS[job.wish.of]
    seen = [design.verified for design in designs if design.verified is not None]
    values = [each.value for each in seen]
    if wish.way is not None and seen and not any(each.above_0 for each in seen):
        best = max(seen, key=lambda each: each.value)
        return (
            f"no design for {wish.words}: the most of fresh runs is {words.with_error(best.value, best.se)} {unit}, "
            "not clearly above 0; other --vary ranges, a steeper slope or another --seed"
        )
    if wish.target is None or not values:
        return (
            f"no design for {wish.words}: fresh runs do not agree with those that chose; "
            "another --seed, or a larger --error"
        )
    target = wish.target
    nearest = min(values, key=lambda value: abs(value - target))
    head = f"no design for {wish.words} within {wish.error}: the nearest runs at "
    if wish.of != "speed":
        head = f"no design for {wish.words} within {wish.error}: the nearest has "
    head += f"{words.number(nearest, 4)} {unit}"
    tried = [(trial.seen.value, trial) for trial in result.trials if trial.usable and trial.seen]
    low, high = min(tried, key=lambda pair: pair[0]), max(tried, key=lambda pair: pair[0])
    if low[0] <= target <= high[0]:
        return (
            f"{head}, though values from {words.span(low[0], high[0])} {unit} were seen: other "
            "--vary ranges, a larger --error or another --seed"
        )
    extreme, at = high if target > high[0] else low
    side = "largest" if target > high[0] else "smallest"
    most = f"the {side} {wish.of} found is {words.number(extreme, 4)} {unit}"
    return f"{head}; {most}, {_limit(job, result, at)}"


def _limit(job: Job, result: Search, extreme: Trial) -> str:
    """Limit that an extreme trial stands at: a bound of a key, or what cannot be made."""
    held = []
    for span in job.box.spans:
        value, near = extreme.values[span.key], 0.05 * (span.high - span.low)
        if min(value - span.low, span.high - value) <= near:
            end = "lower" if value - span.low <= near else "upper"
            bound = span.low if end == "lower" else span.high
            held.append(f"the {end} bound of --vary {span.key} ({bound:g})")
    missed = int((~result.survey.feasible).sum())
    if missed:
        share = f"{missed} of {len(result.survey.x)} designs"
        held.append(f"what cannot be made or printed, or has no speed without a run ({share})")
    at = ", ".join(f"{key} = {words.number(value, 6)}" for key, value in extreme.values.items())
    if not held:
        return f"within the ranges, at {at}: vary other keys"
    return f"at {at}, stopped by {' and '.join(held)}"
