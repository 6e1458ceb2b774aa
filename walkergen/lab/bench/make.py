"""Bench tests: drop, incline and pluck, each simulated, inverted where a number was measured, and reported."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from walkergen.errors import InputError
from walkergen.files import report, words
from walkergen.files.progress import Progress
from walkergen.files.report import Table
from walkergen.lab import drops, inverse, resting
from walkergen.lab.bench import drop, pluck, slide
from walkergen.lab.bench.drop import Dropped
from walkergen.lab.bench.pluck import Plucked
from walkergen.lab.bench.slide import Incline
from walkergen.lab.calibrate.modulus import SOFTEST, STIFFEST
from walkergen.lab.inverse import Answer, Curve, Measured
from walkergen.lab.report import LabReport, check, check_drops, written
from walkergen.numerics.quantity import Quantity
from walkergen.scene import Scene
from walkergen.walker import names
from walkergen.walker.design import Design

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.figure import Figure

HIGHEST_MM = 1000.0
"""Largest height of a drop."""

MOST = {"drop": 1.0, "slide": 89.0, "pluck": 1e6}
"""Largest number that each test may measure: rebound, slope (deg), frequency (Hz)."""

MOST_DECREMENT = 100.0

REBOUNDS = ("flat", "from_hand", "sd_of_a_drop", "fell_over")
"""Columns of the rebounds under one condition."""

Value = float | str | None


class Test(NamedTuple):
    """What every bench test needs: walker, feet, a number measured on a real bench, pictures."""

    design: Design
    scene: Scene
    measured: Measured | None
    pictures: bool


class Drop(NamedTuple):
    """Choices of a drop: height (mm), deviation of pitch and roll from the hand (deg), drops."""

    height: float = 10.0
    turn_deg: float = 1.0
    drops: int = 24


def folder_of(bench: str, design: Design) -> Path:
    """Folder of a test by default: below out/ and the walker's name."""
    return Path("out") / design.name / f"bench_{bench}_{names.part(design)}"


def dropped(test: Test, how: Drop, folder: Path, progress: Progress) -> LabReport:
    """Drop a walker; writes drop.csv and a table for all else that counts, figure and page.

    Without a first turn only the flat drop counts. Raises InputError before anything is simulated.
    """
    check("--height-mm", how.height, 0.01, HIGHEST_MM)
    check_drops(how.turn_deg, how.drops)
    rebounds = drop.drop(test.scene, test.design, *how, progress)
    hand = f"pitch and roll ± {how.turn_deg:g} deg"
    curves = {"let go flat": rebounds.curve(flat=True), f"from the hand ({hand})": rebounds.curve(flat=False)}
    if how.turn_deg == 0.0:
        curves.popitem()
    answers = _answers(test, curves, "foot restitution", f" at {test.design.tilt_deg:g} deg")
    notes = [
        f"from the hand: {hand}, {how.height:g} mm; rebound: root of the height regained over that "
        "of the drop, of the body's middle over where it stands",
        *_on_flatness(rebounds),
    ]
    return _reported(
        test,
        "drop",
        f"Drop of {test.design.name}, {test.design.tilt_deg:g} deg, {test.design.kind}",
        f"dropped by {how.height:g} mm",
        _tables_of_drop(rebounds),
        answers,
        _settings(answers, -1, "contact.restitution"),
        notes,
        folder,
        lambda figures, title: figures.of_drop(rebounds, title, how.turn_deg, test.measured),
        how._asdict(),
    )


def slid(test: Test, folder: Path, progress: Progress) -> LabReport:
    """Tilt the plate under a walker; writes slide.csv, figure and page."""
    incline = slide.slide(test.scene, test.design, progress)
    curves = {f"facing {facing}": incline.curve(facing) for facing in ("downhill", "uphill")}
    answers = _answers(test, curves, "friction")
    return _reported(
        test,
        "slide",
        f"Incline under {test.design.name}, {test.design.tilt_deg:g} deg, {test.design.kind}",
        "the plate is tilted slowly",
        [_table_of_slide(incline)],
        answers,
        _settings(answers, 0, "contact.friction"),
        _on_inclines(incline),
        folder,
        lambda figures, title: figures.of_slide(incline, title, test.measured),
        {},
    )


def plucked(test: Test, decrement: Measured | None, folder: Path, progress: Progress) -> LabReport:
    """Pluck a leg; writes pluck.csv, moduli.csv, damping.csv, figure and page.

    Raises InputError for legs that do not swing.
    """
    progress("plucking", 0, 1)
    design, scene = test.design, test.scene
    leg = pluck.pluck(scene, design)
    answers: dict[str, Quantity] = {}
    notes = _on_plucking(leg, scene)
    if test.measured is not None:
        hertz, sd = test.measured.number.pair
        by_frequency = pluck.by_frequency(design, leg.leg_mass, hertz, sd)
        _check_plastic(hertz, by_frequency.modulus.pair[0], leg.cantilever)
        answers["Young's modulus"] = by_frequency.modulus
        notes = [_on_thickness(design, by_frequency), *notes]
    if decrement is not None:
        answers["damping ratio of the leg"] = pluck.damping(decrement.number)
    keys = {"Young's modulus": "material.youngs_modulus", "damping ratio of the leg": "legs.damping_ratio"}
    settings: dict[str, float] = {}
    for what, number in answers.items():
        settings |= _of_keys(keys[what], number)
    return _reported(
        test,
        "pluck",
        f"Pluck of a leg{pluck.which(design)} of {design.name}, {design.tilt_deg:g} deg",
        f"leg's damping ratio {scene.legs.damping_ratio:g}",
        _tables_of_pluck(leg, scene, design),
        [("", inverse.with_error(what, number, number.unit.replace("gpa", "GPa"))) for what, number in answers.items()],
        settings,
        notes,
        folder,
        lambda figures, title: figures.of_pluck(leg, title, test.measured, pluck.by_modulus(design, leg.leg_mass)),
        {"decrement": None if decrement is None else decrement.facts},
    )


def _check_plastic(hertz: float, modulus: float, expected: float) -> None:
    """Raise InputError for a frequency that no plastic's leg has: a slip of the unit, mostly."""
    if not SOFTEST <= modulus <= STIFFEST:
        slip = "is it in kHz? Give Hz" if modulus < SOFTEST else "is it of another leg, or an overtone?"
        raise InputError(
            f"--measured {hertz:g}: Hz would mean a Young's modulus of {modulus:.3g} GPa; plastics have {SOFTEST:g} to "
            f"{STIFFEST:g}; this leg swings at about {expected:.0f} Hz: {slip}",
            "measured",
        )


def _reported(
    test: Test,
    bench: str,
    title: str,
    how: str,
    tables: Sequence[Table],
    answers: "Sequence[tuple[str, Answer]]",
    settings: Mapping[str, float],
    notes: Sequence[str],
    folder: Path,
    drawn: "Callable[[Any, str], Figure]",
    choices: Mapping[str, Any],
) -> LabReport:
    """Report of a test, once it is written with its `choices`; answers stand by their conditions."""

    def draw() -> "Figure":
        from walkergen.lab.bench import figures

        return drawn(figures, title)

    caption = f"{resting.in_words(test.scene, test.design)}; {how}"
    lines = [f"{condition}: {answer.text}" if condition else answer.text for condition, answer in answers]
    if settings:
        lines.append("set " + ", ".join(f"{key} = {words.number(value, 4)}" for key, value in settings.items()))
    facts = {
        "bench": bench,
        "caption": caption,
        "tables": {table.name: list(table) for table in tables},
        "answers": [{"condition": condition, **answer.facts} for condition, answer in answers],
        "settings": settings,
        "notes": notes,
    }
    made = LabReport(
        name=bench,
        title=title,
        caption=caption,
        tables=tables,
        facts=facts,
        lines=[*lines, *notes],
        settings=settings,
        notes=notes,
        figures={bench: draw},
        folder=folder,
        design=test.design,
        scene=test.scene,
    )
    measured = None if test.measured is None else test.measured.facts
    return written(made, test, {"bench": bench, "measured": measured, **choices})


def _answers(test: Test, curves: Mapping[str, Curve | None], what: str, where: str = "") -> list[tuple[str, Answer]]:
    """What the measured number tells by curves, each under its condition."""
    if test.measured is None:
        return []
    return [
        (condition, inverse.invert(curve, test.measured, what, where))
        for condition, curve in curves.items()
        if curve is not None
    ]


def _settings(answers: Sequence[tuple[str, Answer]], place: int, key: str) -> dict[str, float]:
    """Keys that one of the answers sets, the first or the last, where it has a single branch."""
    number = answers[place][1].number(key) if answers else Quantity(key, "", None)
    return _of_keys(key, number) if number.known else {}


def _of_keys(key: str, number: Quantity) -> dict[str, float]:
    """A key of scene or design and that of its standard deviation, with their values."""
    end = f"_{number.unit}" if number.unit else ""
    return dict(zip((f"{key}{end}", f"{key}_sd{end}"), number.pair, strict=True))


def _rows(name: str, title: str, keys: Sequence[str], values: Sequence[Sequence[Value]]) -> Table:
    """Table of a bench test, every key of which people read."""
    texts = [key for key, first in zip(keys, values[0], strict=True) if isinstance(first, str)]
    return Table(name, values, keys, report.every(keys, texts), title)


def _tables_of_drop(rebounds: Dropped) -> list[Table]:
    """Rebounds by restitution, by what else counts, and by the first turn."""
    conditions = {"restitution": list(zip(drops.RESTITUTIONS, rebounds.by_label, strict=True)), **rebounds.by}
    units = {"tilt": "tilt_deg", "height": "height_mm"}
    tables = []
    for what, table in conditions.items():
        name, title = ("drop", "the feet's restitution") if what == "restitution" else (f"{what}s", what)
        keys = (units.get(what, what), *REBOUNDS)
        rows = [(float(at), each.flat, each.mean, each.sd, each.fell) for at, each in table]
        tables.append(_rows(name, f"rebound by {title}", keys, rows))
    turns = ("turn_deg", "rebound_rolled", "rebound_pitched")
    return [*tables, _rows("turns", "rebound by the first turn", turns, rebounds.by_turn)]


def _on_flatness(rebounds: Dropped) -> list[str]:
    """Note on how flat a drop has to be to count as flat."""
    alike = rebounds.flat_within
    if alike is None:
        return []
    if alike == rebounds.by_turn[-1][0]:
        return [f"a first roll up to {alike:g} deg changes nothing that shows"]
    return [f"flat means a roll of at most {alike:g} deg: beyond it one corner lands alone"]


def _table_of_slide(incline: Incline) -> Table:
    """Slopes by friction, for a block and by the way in which a walker faces."""
    lines: list[tuple[Value, ...]] = []
    for place, friction in enumerate(incline.frictions):
        row = {facing: outcomes[place] for facing, outcomes in incline.by_heading.items()}
        fell = ", ".join(facing for facing, outcome in row.items() if outcome.toppled)
        block = math.degrees(math.atan(friction))
        lines.append((friction, block, *(outcome.angle for outcome in row.values()), incline.slips[place], fell))
    facing = (f"{facing}_deg" for facing in incline.by_heading)
    keys = ("friction", "block_deg", *facing, "uphill_slips_deg", "falls_over")
    return _rows("slide", "slope at which it gives way, by the way it faces", keys, lines)


def _on_inclines(incline: Incline) -> list[str]:
    """Notes on how far a walker is a rigid block, and on where it falls over."""
    off = incline.off("downhill")
    notes = [f"facing downhill it slides like a rigid block, at tan(slope) = friction, within {off:.2f} deg"]
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


def _tables_of_pluck(leg: Plucked, scene: Scene, design: Design) -> list[Table]:
    """Frequencies of a plucked leg, and what others would be heard and die out."""
    spring = scene.legs.spring
    lines: list[tuple[Value, ...]] = [
        ("the printed leg, a cantilever; body held", leg.cantilever),
        *((f"hinge, spring = {name!r}; body held", hertz) for name, hertz in leg.hinges.items()),
        (f"hinge, {spring}, damped, simulated; body held", leg.held.frequency),
        (f"hinge, {spring}; body free, lowest", leg.free[0]),
        (f"hinge, {spring}; body free, highest", leg.free[-1]),
    ]
    moduli, damping = pluck.by_modulus(design, leg.leg_mass), pluck.by_damping()
    decays = ("damping_ratio", "decrement", "next_swing_over_swing")
    return [
        _rows("pluck", "frequency of a plucked leg", ("what_swings", "hz"), lines),
        _rows("moduli", "frequency heard, by Young's modulus", ("youngs_modulus_gpa", "hz"), moduli),
        _rows("damping", "swings that die out, by the leg's damping", decays, damping),
    ]


def _on_thickness(design: Design, heard: pluck.ByFrequency) -> str:
    """Note on the thickness that would ring as well."""
    key = "legs.flexible_thickness_mm" if design.pair else f"legs[{pluck.plucked_leg(design) + 1}].thickness_mm"
    thick, sd = heard.thickness.pair
    return (
        f"or {key} = {thick:.3f} ± {sd:.3f} with {design.material.youngs_modulus_gpa:g} GPa: "
        f"the frequency tells E s^3 only, within {100 * heard.bending:.1f} %"
    )


def _on_plucking(leg: Plucked, scene: Scene) -> list[str]:
    """Notes on what swings in the model and what on the bench."""
    own, spring = leg.hinges[scene.legs.spring], scene.legs.spring
    return [
        f"hold the body: free, the legs swing at {leg.free[0] / own:.3f} to {leg.free[-1] / own:.3f} of it",
        f"the model's hinge ({spring}) swings at {own / leg.cantilever:.3f} of the leg that "
        "you hear: 'cantilever' has its stiffness under a slow load, 'frequency' its first mode",
        "the leg counts as a beam; one as wide as long is stiffer by up to 15 %, and a soft root "
        "softens it: the modulus found is what this leg acts with, as the hinge needs it",
    ]
