"""Errors of numbers by the jackknife, whether turning lasts, and reasons to refuse a number.

Turning noise may have a correlation time (a memory): tracks show it, exclude it, or leave it open. If it is open, the
persistence is that of the fit with a memory, whose error holds for walkers without one as well.

`fitted` is the fit of the squared displacement (None in a lane), `longest_s` its longest lag. Reasons to refuse numbers
are texts, by the names of the numbers.
"""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from walkergen.analysis import interval_laws
from walkergen.analysis.displacement_fit import DisplacementFit
from walkergen.analysis.estimates import (
    ACROSS_NAMES,
    ALONG_NAMES,
    HEADING_NAMES,
    HEADINGS_KNOWN_REASON,
    LANE_REASON,
    MIN_SAMPLES,
    MIN_SIGNIFICANCE,
    NO_HEADINGS_REASON,
    TURNING_NAMES,
    UNITS,
    Settings,
    evaluate,
    quantity,
    refusal,
)
from walkergen.analysis.moments import Moments
from walkergen.core.numerics import statistics
from walkergen.core.numerics.distributions import student_quantile
from walkergen.core.numerics.quantity import Quantity

Numbers = Mapping[str, Quantity]
"""Numbers with errors by their names."""

TOO_FEW_REASON = "too few data for its fit: film for longer"

POSITIVE_P_VALUE = 5e-3
"""Probability that a number counts as larger than 0 though the true value is 0 (Student's t)."""

MEMORY_P_VALUE = 0.025
"""Probability, for walkers whose memory lasts for a sample, of one that counts as shorter."""


def jackknife_quantity(numbers: Sequence[Mapping[str, float]], name: str) -> Quantity:
    """Return the number `name` with its jackknife error, or refused. `numbers`: all samples, then one left out."""
    value, error = numbers[0][name], _jackknife_error(numbers[1:], name)
    if not (math.isfinite(value) and math.isfinite(error)):
        return refusal(name, TOO_FEW_REASON)
    return quantity(name, value, error, len(numbers) - 2.0)


def is_resolved(number: Quantity) -> bool:
    """Return whether a number is significantly larger than 0."""
    if number.value is None or number.se is None:
        return False
    return number.value > student_quantile(number.freedom, 1.0 - POSITIVE_P_VALUE) * number.se


def _jackknife_error(replicates: Sequence[Mapping[str, float]], name: str) -> float:
    """Return the jackknife error of a number; NaN with too few replicates, or if one is not finite."""
    spread = np.array([[replicate[name]] for replicate in replicates])
    if len(spread) < MIN_SAMPLES or not np.isfinite(spread).all():
        return math.nan
    return float(statistics.jackknife_error(spread)[0])


def choose_memory(sums: Sequence[Moments], settings: Settings) -> tuple[Settings, list[dict[str, float]]]:
    """Decide whether turning has a memory. Return `settings` with the decision, and the numbers that follow from it.

    `sums` and numbers have an entry for all samples, then one with each sample left out.
    """
    if settings.lane or not settings.headed:
        return settings, evaluate_all(sums, settings)
    with_memory = settings._replace(memory=True)
    numbers = evaluate_all(sums, with_memory)
    memory = jackknife_quantity(numbers, "turning_memory")
    # Within a sample it looks like less noise of the headings.
    if is_resolved(memory) and numbers[0]["turning_memory"] > settings.interval:
        return with_memory, numbers
    plain = evaluate_all(sums, settings)
    if memory.value is not None and memory.se is not None:  # significantly shorter than a sample
        errors = student_quantile(memory.freedom, 1.0 - MEMORY_P_VALUE)
        if memory.value + errors * memory.se < settings.interval:
            return settings, plain
    return settings._replace(memory_open=True), _merge_persistence(plain, numbers)


def evaluate_all(sums: Sequence[Moments], settings: Settings) -> list[dict[str, float]]:
    """Compute the numbers of each entry of `sums`, by name. If `settings` leaves the memory open, merge both fits."""
    values = [evaluate(sample, settings) for sample in sums]
    if not settings.memory_open:
        return values
    with_memory = settings._replace(memory=True)
    return _merge_persistence(values, [evaluate(sample, with_memory) for sample in sums])


def _merge_persistence(
    plain: Sequence[Mapping[str, float]], with_memory: Sequence[Mapping[str, float]]
) -> list[dict[str, float]]:
    """Return the numbers of `plain` (fits without a memory), with persistence and memory replaced by `with_memory`."""
    names = "persistence_rate", "persistence_time", "turning_memory"
    return [
        {
            **numbers,
            **{name: lasting[name] for name in names},
            "persistence_length": abs(numbers["speed"]) * lasting["persistence_time"],
        }
        for numbers, lasting in zip(plain, with_memory, strict=True)
    ]


def attach_errors(
    values: Mapping[str, float],
    replicates: Sequence[Mapping[str, float]],
    settings: Settings,
    fitted: DisplacementFit | None,
    without_one: Sequence[Mapping[str, float]],
    longest_s: float,
    freedom: float,
    differ: bool,
) -> dict[str, Quantity]:
    """Return the numbers with jackknife errors, or with reasons to refuse them.

    `values` are those of all samples. `replicates` leave out a sample each, `without_one` a walker each if samples are
    pieces of a few walkers. If walkers differ by more than their pieces show, the error is that over walkers. So is the
    error of runs if walkers are known to `differ` in speed or turning. `freedom`: degrees of freedom of the samples;
    some may hold little free motion.
    """
    numbers = {
        name: quantity(name, value, _jackknife_error(replicates, name), freedom) for name, value in values.items()
    }
    refused = _meaningless_reasons(settings) | _unresolved_reasons(numbers, settings, fitted, longest_s)
    if len(replicates) < MIN_SAMPLES:
        few = f"{len(replicates)} independent samples; at least {MIN_SAMPLES}: film for longer"
        refused = dict.fromkeys(UNITS, few)
    estimates, share = {}, _detection_share(numbers, settings, fitted, longest_s)
    for name in UNITS:
        reason = refused.get(name, "")
        if not reason and not all(map(math.isfinite, numbers[name].pair)):
            reason = TOO_FEW_REASON
        if reason:
            estimates[name] = refusal(name, reason)
            continue
        within = interval_laws.with_detection_limit(numbers[name], share)
        surely = differ and not settings.lane and name in interval_laws.RUN_QUANTITIES
        estimates[name] = interval_laws.with_walker_error(within, [others[name] for others in without_one], surely)
    return interval_laws.with_variance_laws(estimates, fitted is not None and fitted.run)


def _bound_reason(number: Quantity, unit: str, scale: float = 1.0, root: bool = False) -> str:
    """Return the upper bound (95 %) of a number (or its square `root`) times `scale` as text; '' if infinite."""
    value, se = number.pair
    most = max(value, 0.0) + 2.0 * se
    bound = scale * (math.sqrt(most) if root else most)
    return f"not resolved: below {bound:.2g} {unit} (95 %)" if math.isfinite(bound) else ""


def _detection_share(numbers: Numbers, settings: Settings, fitted: DisplacementFit | None, longest_s: float) -> float:
    """Return the smallest rate of losing direction that is reported, over the estimated rate; 0 without a limit."""
    rate, error = numbers["msd_rate"].pair
    if fitted is None or not fitted.run or not rate > 0.0:
        return 0.0
    decayed = settings.decayed / (rate * longest_s)
    if fitted.spreads[0].smooth_rate:
        return decayed
    return max(decayed, student_quantile(numbers["msd_rate"].freedom, 1.0 - POSITIVE_P_VALUE) * error / rate)


def _meaningless_reasons(settings: Settings) -> dict[str, str]:
    """Return reasons to refuse numbers without meaning: in a lane, without headings, or if headings are known."""
    if settings.lane:
        names = (*TURNING_NAMES, *HEADING_NAMES, *ACROSS_NAMES, "motion_speed", "ballistic_speed")
        also = ("localisation_noise", "translational_diffusion")
        return dict.fromkeys((*names, *also), LANE_REASON)
    if settings.headed:
        return {"motion_speed": HEADINGS_KNOWN_REASON}
    return dict.fromkeys((*HEADING_NAMES, *ALONG_NAMES, *ACROSS_NAMES), NO_HEADINGS_REASON)


def _unresolved_reasons(
    numbers: Numbers, settings: Settings, fitted: DisplacementFit | None, longest_s: float
) -> dict[str, str]:
    """Return reasons to refuse roots of, and quotients by, numbers that may be 0: their errors mean nothing."""
    if settings.lane or fitted is None:
        reason = "the spread about the mean run is too small to tell"
        return {} if is_resolved(numbers["diffusivity"]) else {"crossover_time": reason}
    refused = _unresolved_persistence(numbers, settings, longest_s)
    if settings.headed:
        if settings.memory_open:
            refused["turning_memory"] = _bound_reason(numbers["turning_memory"], "s")
        elif math.isnan(numbers["turning_memory"].number):
            refused["turning_memory"] = "not resolved: headings lose direction from the first on"
        if not is_resolved(numbers["heading_variance"]):
            refused["heading_noise"] = _bound_reason(numbers["heading_variance"], "rad", root=True)
        if abs(numbers["speed"].number) <= MIN_SIGNIFICANCE * numbers["speed"].pair[1]:
            refused["persistence_length"] = "the speed is not resolved"
    elif not is_resolved(numbers["amplitude"]):
        window = settings.grid.step * settings.interval
        reason = _bound_reason(numbers["lasting"], f"mm/s over {window:.2g} s", 1.0 / window, root=True)
        refused |= dict.fromkeys(("speed", "motion_speed", *TURNING_NAMES), reason)
    return refused | _unresolved_spread(numbers, settings, fitted, longest_s)


def _unresolved_persistence(numbers: Numbers, settings: Settings, longest_s: float) -> dict[str, str]:
    """Return reasons to refuse persistence time and length: a rate of losing direction too small or uncertain."""
    rate = numbers["persistence_rate"].number
    lost, bounds = rate * longest_s > settings.decayed, numbers["persistence_rate"].interval()
    if lost and bounds is not None and bounds[0] > 0.0:
        return {}
    reason = f"the direction hardly changes within {longest_s:.3g} s: {settings.advice}"
    if lost and settings.memory_open:
        reason = (
            f"{longest_s:.3g} s do not resolve how fast direction is lost, because rates of turning may "
            f"last for a while: {settings.advice}"
        )
    at_least = max(rate, 0.0) + 2.0 * numbers["persistence_rate"].pair[1]
    if math.isfinite(at_least) and at_least > 0:
        reason += f"; more than {1.0 / at_least:.3g} s (95 %)"
    return dict.fromkeys(("persistence_time", "persistence_length"), reason)


def _unresolved_spread(
    numbers: Numbers, settings: Settings, fitted: DisplacementFit, longest_s: float
) -> dict[str, str]:
    """Return reasons to refuse terms of the squared displacement that cannot be told from 0, or from each other."""
    if math.isnan(fitted.spreads[0].offset):
        return {}  # nothing was fitted, which is reason enough
    first_s = settings.interval
    if not fitted.run:
        refused = _noise_and_diffusion(numbers)
        reason = f"no run shows: diffusive at all lags from {first_s:.2g} to {longest_s:.3g} s"
        refused |= dict.fromkeys(("ballistic_speed", "crossover_time"), reason)
        if is_resolved(numbers["diffusivity"]):
            refused["translational_diffusion"] = (
                f"diffusion and runs that turn within {first_s:.2g} s cannot be separated: film more frames a second"
            )
        else:
            refused["diffusivity"] = _bound_reason(numbers["diffusivity"], "mm²/s")
        return refused | _hidden_run(numbers, settings, fitted, longest_s)
    refused = _noise_and_diffusion(numbers)
    if not is_resolved(numbers["msd_speed2"]):
        reason = _bound_reason(numbers["msd_speed2"], "mm/s", root=True)
        refused |= dict.fromkeys(("ballistic_speed", "crossover_time"), reason)
    smooth = fitted.spreads[0].smooth_rate
    if smooth:
        refused["translational_diffusion"] = f"hidden by inertia: runs set in smoothly, over some {1.0 / smooth:.2g} s"
        if fitted.at_its_limit:
            reason = f"the onset of runs cannot be separated from their duration: {settings.advice}"
            refused |= dict.fromkeys(("diffusivity", "crossover_time"), reason)
    turned = numbers["msd_rate"].number * longest_s > settings.decayed
    needed = ("diffusivity",) if smooth else ("msd_rate", "diffusivity")
    if not (turned and all(is_resolved(numbers[name]) for name in needed)):
        reason = f"{fitted.regime(longest_s)}: {settings.advice}"
        refused |= dict.fromkeys(("diffusivity", "crossover_time"), reason)
    return refused


def _hidden_run(numbers: Numbers, settings: Settings, fitted: DisplacementFit, longest_s: float) -> dict[str, str]:
    """Return the reason to refuse diffusivity if runs, hidden at such short lags, may add more than its bounds allow.

    With headings runs may add v^2 / (2 rate), with the largest speed v (95 %). Without them it is refused if products
    of displacements show a run, or the squared displacement may have one.
    """
    if not settings.headed:
        hidden = math.inf if fitted.suspected or is_resolved(numbers["amplitude"]) else 0.0
    else:
        most = abs(numbers["speed"].number) + 2.0 * numbers["speed"].pair[1]
        rate = numbers["persistence_rate"].number
        hidden = most**2 / (2.0 * rate) if rate > 0.0 else math.inf
    if hidden <= numbers["diffusivity"].half_width():
        return {}
    return {"diffusivity": f"lags up to {longest_s:.3g} s do not show what runs add: {settings.advice}"}


def _noise_and_diffusion(numbers: Numbers) -> dict[str, str]:
    """Return reasons to refuse noise of the positions and diffusion if these are not resolved in addition to runs."""
    noise, diffusion = "localisation_noise", "translational_diffusion"
    refused: dict[str, str] = {}
    if not is_resolved(numbers["msd_offset"]):
        refused[noise] = _bound_reason(numbers["msd_offset"], "mm", 0.5, root=True)
    if not is_resolved(numbers[diffusion]):
        refused[diffusion] = _bound_reason(numbers[diffusion], "mm²/s")
    if len(refused) == 2 and is_resolved(numbers["msd_first"]):
        together = math.sqrt(numbers["msd_first"].number)
        reason = (
            f"noise and diffusion, {together:.2g} mm a sample together, cannot be separated: film "
            "a walker at rest, which shows noise alone, or for longer"
        )
        refused |= dict.fromkeys((noise, diffusion), reason)
    return refused
