"""Tables, answers and settings of the bench tests."""

import math
from collections.abc import Sequence

from walkergen.analysis import beams, inverse
from walkergen.analysis.inverse import Branch, Inverse, Measured
from walkergen.lab import drops, resting
from walkergen.lab.bench import pluck, report
from walkergen.lab.bench.drop import Dropped
from walkergen.lab.bench.pluck import Plucked
from walkergen.lab.bench.report import Answer, BenchReport, Value
from walkergen.lab.bench.slide import Incline
from walkergen.lab.drops import Rebounds
from walkergen.scene import Scene
from walkergen.walker.design import Design

UNITS = {"tilt": "tilt_deg", "friction": "friction", "height": "height_mm"}
"""Columns of what a drop depends on beside the restitution."""


def of_drop(
    dropped: Dropped, scene: Scene, design: Design, height: float, turn_deg: float, measured: Measured | None
) -> BenchReport:
    """Report of a drop; without a first turn (`turn_deg` 0) only the flat drop counts."""
    hand = f"pitch and roll ± {turn_deg:g} deg"
    labelled = zip(drops.LABELS, dropped.by_label, strict=True)
    rows = [
        report.rows(
            "drop",
            "rebound by the feet's restitution",
            ("restitution", *_COLUMNS),
            [(float(label), *_row(rebounds)) for label, rebounds in labelled],
        )
    ]
    for what, table in dropped.by.items():
        lines = [(at, *_row(rebounds)) for at, rebounds in table]
        rows.append(report.rows(f"{what}s", f"rebound by {what}", (UNITS[what], *_COLUMNS), lines))
    columns = ("turn_deg", "rebound_rolled", "rebound_pitched")
    rows.append(report.rows("turns", "rebound by the first turn", columns, dropped.by_turn))
    where = f" at {design.tilt_deg:g} deg"
    answers = []
    for flat, condition in ((True, "let go flat"), (False, f"from the hand ({hand})")):
        curve = dropped.curve(flat)
        if measured is None or curve is None or (turn_deg == 0.0 and not flat):
            continue
        solution = inverse.invert(curve, measured)
        ends = float(curve.at[0]), float(curve.at[-1])
        answers.append(Answer(condition, inverse.in_words(solution, "foot restitution", ends, where), solution))
    notes = [
        f"from the hand: {hand}, {height:g} mm; rebound: root of the height regained over that "
        "of the drop, of the body's middle over where it stands",
        *_on_flatness(dropped),
    ]
    caption = f"{resting.in_words(scene, design)}; dropped by {height:g} mm"
    title = f"Drop of {design.name}, {design.tilt_deg:g} deg, {design.kind}"
    keys = "contact.restitution", "contact.restitution_sd"
    settings = _settings(answers[-1:], keys)
    return report.of("drop", title, caption, rows, answers, notes, settings)


def of_slide(incline: Incline, scene: Scene, design: Design, measured: Measured | None) -> BenchReport:
    """Report of an incline."""
    lines: list[tuple[Value, ...]] = []
    for place, friction in enumerate(incline.frictions):
        slid = {facing: row[place] for facing, row in incline.by_heading.items()}
        fell = ", ".join(facing for facing, outcome in slid.items() if outcome.toppled)
        angles = [outcome.angle for outcome in slid.values()]
        block = math.degrees(math.atan(friction))
        lines.append((friction, block, *angles, incline.slips[place], fell))
    columns = (
        "friction",
        "block_deg",
        *(f"{facing}_deg" for facing in incline.by_heading),
        "uphill_slips_deg",
        "falls_over",
    )
    rows = report.rows("slide", "slope at which it gives way, by the way it faces", columns, lines)
    answers = []
    for facing in ("downhill", "uphill"):
        curve = incline.curve(facing)
        if measured is None or curve is None:
            continue
        solution = inverse.invert(curve, measured)
        ends = float(curve.at[0]), float(curve.at[-1])
        text = inverse.in_words(solution, "friction", ends)
        answers.append(Answer(f"facing {facing}", text, solution))
    title = f"Incline under {design.name}, {design.tilt_deg:g} deg, {design.kind}"
    caption = f"{resting.in_words(scene, design)}; the plate is tilted slowly"
    settings = _settings(answers[:1], ("contact.friction", "contact.friction_sd"))
    notes = _on_inclines(incline)
    return report.of("slide", title, caption, [rows], answers, notes, settings)


def _on_inclines(incline: Incline) -> list[str]:
    """Notes on how far a walker is a rigid block, and on where it falls over."""
    notes = [
        f"facing downhill it slides like a rigid block, at tan(slope) = friction, within "
        f"{incline.off('downhill'):.2f} deg"
    ]
    if incline.off("uphill") > 0.5:
        notes.append(
            "facing uphill its upper foot slips first where friction exceeds tan(tilt), and well "
            "beyond the walker chatters down from there: let it face downhill"
        )
    falls = ", ".join(f"{edge:.1f} {facing}" for facing, edge in incline.edges.items())
    most = math.tan(math.radians(incline.edges["downhill"]))
    notes.append(f"it falls over at (deg) {falls}: no friction beyond {most:.2f} shows")
    notes.append("the model has one friction: nudge the walker, and take the slope at which it keeps sliding")
    return notes


def of_pluck(
    plucked: Plucked, scene: Scene, design: Design, measured: Measured | None, decrement: Measured | None
) -> BenchReport:
    """Report of a plucked leg."""
    spring, free = scene.legs.spring, plucked.free
    lines: list[tuple[Value, ...]] = [
        ("the printed leg, a cantilever; body held", plucked.cantilever),
        *((f"hinge, spring = {name!r}; body held", hertz) for name, hertz in plucked.hinges.items()),
        (f"hinge, {spring}, damped, simulated; body held", plucked.held.frequency),
        (f"hinge, {spring}; body free, lowest", free[0]),
        (f"hinge, {spring}; body free, highest", free[-1]),
    ]
    rows = report.rows("pluck", "frequency of a plucked leg", ("what_swings", "hz"), lines)
    moduli = report.rows(
        "moduli",
        "frequency heard, by Young's modulus",
        ("youngs_modulus_gpa", "hz"),
        pluck.by_modulus(design, plucked.leg_mass),
    )
    damping = report.rows(
        "damping",
        "swings that die out, by the leg's damping",
        ("damping_ratio", "decrement", "next_swing_over_swing"),
        pluck.by_damping(),
    )
    answers: list[Answer] = []
    settings: dict[str, float] = {}
    notes = _on_plucking(plucked, scene)
    if measured is not None:
        errors = pluck.errors(design, measured.sd / measured.value)
        value = pluck.modulus(design, plucked.leg_mass, measured.value)
        answers.append(_with_error("Young's modulus", value, errors.modulus * value, "GPa"))
        settings |= {"material.youngs_modulus_gpa": value, "material.youngs_modulus_sd_gpa": errors.modulus * value}
        thick = pluck.thickness(design, plucked.leg_mass, measured.value)
        notes = [
            f"or {_thickness_key(design)} = {thick:.3f} ± {errors.thickness * thick:.3f} with "
            f"{design.material.youngs_modulus_gpa:g} GPa: the frequency tells E s^3 only, "
            f"within {100 * errors.bending:.1f} %",
            *notes,
        ]
    if decrement is not None:
        ratio = beams.damping_ratio(decrement.value)
        sd = ratio * (1.0 - ratio * ratio) * decrement.sd / decrement.value
        answers.append(_with_error("damping ratio of the leg", ratio, sd, ""))
        settings |= {"legs.damping_ratio": ratio, "legs.damping_ratio_sd": sd}
    leg = f"a leg{pluck.which(design)}"
    title = f"Pluck of {leg} of {design.name}, {design.tilt_deg:g} deg"
    caption = f"{resting.in_words(scene, design)}; leg's damping ratio {scene.legs.damping_ratio:g}"
    return report.of("pluck", title, caption, [rows, moduli, damping], answers, notes, settings)


def _thickness_key(design: Design) -> str:
    """Key of the plucked leg's thickness in a design."""
    if design.pair:
        return "legs.flexible_thickness_mm"
    return f"legs[{pluck.plucked_leg(design) + 1}].thickness_mm"


def _with_error(what: str, value: float, sd: float, unit: str) -> Answer:
    """Answer with a symmetric error."""
    digits = inverse.digits_of(sd)
    text = f"{what} {value:.{digits}f} ± {sd:.{digits}f} {unit}".rstrip()
    branch = Branch(value, value - sd, value + sd)
    return Answer("", text, Inverse([branch], value, value, 0.0, False))


def _on_plucking(plucked: Plucked, scene: Scene) -> list[str]:
    """Notes on what swings in the model and what on the bench."""
    own, spring = plucked.hinges[scene.legs.spring], scene.legs.spring
    return [
        f"hold the body: free, the legs swing at {plucked.free[0] / own:.3f} to {plucked.free[-1] / own:.3f} of it",
        f"the model's hinge ({spring}) swings at {own / plucked.cantilever:.3f} of the leg that "
        "you hear: 'cantilever' has its stiffness under a slow load, 'frequency' its first mode",
        "the leg counts as a beam; one as wide as long is stiffer by up to 15 %, and a soft root "
        "softens it: the modulus found is what this leg acts with, as the hinge needs it",
    ]


_COLUMNS = ("flat", "from_hand", "sd_of_a_drop", "fell_over")


def _row(rebounds: Rebounds) -> tuple[Value, ...]:
    return rebounds.flat, rebounds.mean, rebounds.sd, rebounds.fell


def _on_flatness(dropped: Dropped) -> list[str]:
    """Note on how flat a drop has to be to count as flat."""
    alike = dropped.flat_within
    if alike is None:
        return []
    last = dropped.by_turn[-1][0]
    if alike == last:
        return [f"a first roll up to {last:g} deg changes nothing that shows"]
    return [f"flat means a roll of at most {alike:g} deg: beyond it one corner lands alone"]


def _settings(answers: Sequence[Answer], keys: tuple[str, str]) -> dict[str, float]:
    """Keys of a value and its deviation that the answer, if it is one, has a single branch for."""
    if not answers or len(answers[0].inverse.branches) != 1 or answers[0].inverse.everywhere:
        return {}
    (branch,) = answers[0].inverse.branches
    return dict(zip(keys, (branch.value, 0.5 * (branch.high - branch.low)), strict=True))
