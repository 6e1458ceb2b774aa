"""Tables, answers and settings of the bench tests."""

from walkergen.jobs.bench import inverse, still
from walkergen.jobs.bench.drop import Dropped, Rebounds
from walkergen.jobs.bench.inverse import Measured
from walkergen.jobs.bench.report import Answer, Report, Rows, Value
from walkergen.scene import Scene
from walkergen.walker.design import Design

UNITS = {"tilt": "tilt_deg", "friction": "friction", "height": "height_mm"}
"""Columns of what a drop depends on beside the restitution."""


def of_drop(
    found: Dropped,
    scene: Scene,
    design: Design,
    height: float,
    turn_deg: float,
    measured: Measured | None,
) -> Report:
    """Report of a drop; without a first turn (`turn_deg` 0) only the flat drop counts."""
    hand = f"pitch and roll ± {turn_deg:g} deg"
    labelled = zip(found.labels, found.by_label, strict=True)
    rows = [
        Rows("drop", "rebound by the feet's restitution", ("restitution", *_COLUMNS),
             [(float(label), *_row(one)) for label, one in labelled])
    ]  # fmt: skip
    for what, table in found.by.items():
        lines = [(at, *_row(one)) for at, one in table]
        rows.append(Rows(f"{what}s", f"rebound by {what}", (UNITS[what], *_COLUMNS), lines))
    columns = ("turn_deg", "rebound_rolled", "rebound_pitched")
    rows.append(Rows("turns", "rebound by the first turn", columns, found.by_turn))
    where = f" at {design.legs.tilt_deg:g} deg"
    answers = []
    for flat, condition in ((True, "let go flat"), (False, f"from the hand ({hand})")):
        curve = found.curve(flat)
        if measured is None or curve is None or (turn_deg == 0.0 and not flat):
            continue
        one = inverse.invert(curve, measured)
        ends = float(curve.at[0]), float(curve.at[-1])
        answers.append(
            Answer(condition, inverse.in_words(one, "foot restitution", ends, where), one)
        )
    notes = [
        f"from the hand: {hand}, {height:g} mm; rebound: root of the height regained over that "
        "of the drop, of the body's middle over where it stands",
        *_on_flatness(found),
    ]
    caption = f"{still.in_words(scene, design)}; dropped by {height:g} mm"
    title = f"Drop of {design.name}, {design.legs.tilt_deg:g} deg, {design.legs.kind}"
    return Report("drop", title, caption, rows, answers, notes, _settings(answers))


_COLUMNS = ("flat", "from_hand", "sd_of_a_drop", "fell_over")


def _row(one: Rebounds) -> tuple[Value, ...]:
    return one.flat, one.mean, one.sd, one.fell


def _on_flatness(found: Dropped) -> list[str]:
    """Note on how flat a drop has to be to count as flat."""
    alike = found.flat_within
    if alike is None:
        return []
    last = found.by_turn[-1][0]
    if alike == last:
        return [f"a first roll up to {last:g} deg changes nothing that shows"]
    return [f"flat means a roll of at most {alike:g} deg: beyond it one corner lands alone"]


def _settings(answers: list[Answer]) -> dict[str, float]:
    """Restitution and its deviation, where the last answer (from the hand, if it is) has one."""
    if not answers or len(answers[-1].inverse.branches) != 1 or answers[-1].inverse.everywhere:
        return {}
    (one,) = answers[-1].inverse.branches
    sd = 0.5 * (one.high - one.low)
    return {"contact.restitution": one.value, "contact.restitution_sd": sd}
