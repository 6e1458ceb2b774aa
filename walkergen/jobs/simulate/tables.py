"""Tables of simulated walkers: what the model is, how they move, how they land."""

from collections.abc import Iterator, Mapping
from typing import Any

from walkergen.analysis.estimates import IN_A_LANE, with_error
from walkergen.analysis.landings import TOGETHER_S, Landings, shares_by_impulse
from walkergen.analysis.motion import Motion
from walkergen.jobs.simulate.make import Simulated
from walkergen.scene import Scene
from walkergen.simulation.record import KINDS

MOVED = {
    "lane_speed": ("along x", "mm/s"),
    "sideways_speed": ("sideways drift", "mm/s to the left"),
    "turning_bias": ("turning", "rad/s to the left"),
    "turning_scatter": ("turning scatter", "rad/s between runs"),
    "rotational_diffusion": ("rotational D_r", "rad²/s"),
    "persistence_time": ("persistence", "s"),
    "persistence_length": ("", "mm"),
    "diffusivity": ("diffusivity", "mm²/s"),
    "crossover_time": ("crossover", "s, ballistic to diffusive"),
}
"""Names and units of the estimates that a summary shows."""


def model_in_words(found: Simulated, scene: Scene) -> str:
    """Model, method and contact law of a simulation: elastic feet in space know no impact law."""
    told = f"{found.point.model}, method {found.point.method}"
    contact = scene.contact
    if found.point.model != "space":
        return f"{told}, law {contact.law}"
    label = f"label {contact.restitution:g}, friction {contact.friction:g}"
    return f"{told}, {scene.feet.damping} feet, {label}"


def model_as_dict(found: Simulated, scene: Scene) -> dict[str, Any]:
    """Model, method and contact law of a simulation for JSON."""
    named = {"model": found.point.model, "method": found.point.method}
    contact = scene.contact
    if found.point.model != "space":
        return named | {"law": contact.law}
    label = {"label": contact.restitution, "friction": contact.friction}
    return named | {"feet": scene.feet.damping} | label


def motion_rows(found: Simulated) -> Iterator[tuple[str, str]]:
    """Rows of a summary on how walkers in space move, each number with its error or a reason."""
    if found.untold:
        yield "motion", f"unknown: {found.untold}"
    if found.motion is None:
        return
    before = ""
    in_lane = found.motion.estimates["sideways_speed"].reason == IN_A_LANE
    for name, (title, unit) in MOVED.items():
        one = found.motion.estimates[name]
        if in_lane and name == "lane_speed":
            continue  # the summary's mean speed
        if one.reason != IN_A_LANE and (one.value is not None or one.reason != before):
            value = with_error(one)
            told = f"{value} {unit}"
            if name == "rotational_diffusion" and one.value:
                told += f" (1/D_r = {1.0 / one.value:.3g} s)"
            yield title, value if one.value is None else told
        before = one.reason
    yield "msd exponent", _exponents(found.motion)
    for note in (found.motion.method, *found.motion.doubts):
        yield "note", note


def _exponents(motion: Motion) -> str:
    """Local exponents of the squared displacement at the known lags nearest to 0.1 s and 1 s."""
    known = [
        (at, value, se)
        for at, value, se in zip(*motion.exponent, strict=True)
        if value == value and se == se  # not NaN
    ]
    if not known:
        return "runs are too short"
    nearest = [min(known, key=lambda one: abs(one[0] / lag - 1.0)) for lag in (0.1, 1.0)]
    return ", ".join(
        f"{value:.3f} ± {se:.1g} at {at:.2g} s" for at, value, se in dict.fromkeys(nearest)
    )


def landing_rows(found: Landings | None) -> Iterator[tuple[str, str]]:
    """Rows of a summary on landings: types by impulse, and numbers by corner, edge and foot."""
    if found is None or not found.duration > 0:
        return
    shares = _by_impulse(found)
    told = ", ".join(f"{name} {100 * one:.1f} %" for name, one in shares.items())
    yield "by impulse", told or "none"
    per = {name: f"{value:.1f}" for name, value in _rates(found).items()}
    yield (
        "by corner, /s",
        f"back {per['back_left']} left, {per['back_right']} right; "
        f"front {per['front_left']} left, {per['front_right']} right",
    )
    yield (
        f"in {1e6 * TOGETHER_S:.0f} us, /s",
        f"edges {per['back_edge']} back, {per['front_edge']} front; both feet "
        f"{per['both_feet']}; one corner alone {per['alone']}",
    )


def _rates(found: Landings) -> Mapping[str, float]:
    """Landings per second, by corner, edge and foot. Corners with z > 0 are on the right."""
    counts = {
        "back_left": found.corners[0], "back_right": found.corners[1],
        "front_left": found.corners[2], "front_right": found.corners[3],
        "back_edge": found.edges[0], "front_edge": found.edges[1],
        "both_feet": found.pairs, "alone": found.alone,
    }  # fmt: skip
    return {name: float(number) / found.duration for name, number in counts.items()}


def _by_impulse(found: Landings) -> dict[str, float]:
    """Shares of the types that occur in the normal impulse, by their names, in their order."""
    shares = shares_by_impulse(found)
    return {name: shares[kind] for name, kind in KINDS.items() if shares.get(kind)}


def landings_as_dict(found: Landings) -> dict[str, Any]:
    """Landings for JSON: rates per second, and shares of types in the normal impulse."""
    rates = {f"{name}_per_s": value for name, value in _rates(found).items()}
    return rates | {"type_fractions_by_impulse": _by_impulse(found)}
