"""Table of the predicted speeds of a design's walkers, as shown to users: its caption, columns and notes."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from walkergen.core.files import formatting
from walkergen.core.numerics.quantity import CONFIDENCE, Quantity
from walkergen.core.scene import Scene
from walkergen.core.theory import prediction
from walkergen.core.theory.uncertain_inputs import Share
from walkergen.core.walker.design import Design
from walkergen.files import report
from walkergen.files.report import Column, Table
from walkergen.points import members
from walkergen.points.members import Member


def caption(design: Design, scene: Scene, mode: str) -> str:
    """Return the caption of a table of speeds: how they were computed, and the assumed contact."""
    contact, assumed = scene.contact, scene.prediction
    what = "mean factor v/w" if design.is_symmetric_pair else "balanced factor v/w"
    origin = contact.origin[0].upper() + contact.origin[1:]
    swing = "motor's" if scene.drive.kind == "motor" else "plate's"
    return (
        f"As designed: the model in space, from its surrogate or a short simulation. Your print: the median over "
        f"uncertain contact, print and masses, with an error of {100 * assumed.model_sd:g} % of the model. "
        f"{origin}: restitution "
        f"{contact.restitution:g} ± {contact.restitution_sd:g}, friction {contact.friction:g} ± "
        f"{contact.friction_sd:g}. Theory (eq. 15): {what} x impact speed, {assumed.impact_speed_factor:g} of the "
        f"{swing} peak speed; mode {mode}"
    )


def headline(design: str, walkers: Sequence[Member], folder: Path | None = None) -> str:
    """Return a sentence on the walkers of the design named `design`: what the only, or the fastest one does."""
    start = count_walkers(design, walkers, folder)
    if len(walkers) == 1:
        only = walkers[0].design
        told = f"{only.kind} legs, tilt {only.tilt_deg:g} deg: {describe_fastest(walkers)}"
        return f"{start}: {told}" if folder else f"{design}, {told}"
    told = describe_fastest(walkers)
    return f"{start}{'; ' if told.startswith(('the', 'all')) else ', '}{told}"


def describe_fastest(walkers: Sequence[Member]) -> str:
    """Return what the fastest of the walkers does, in words, and how many have no speed."""
    if len(walkers) == 1:
        return prediction.describe_speed(walkers[0].row)
    by_speed = [(abs(speed), number) for number, one in enumerate(walkers) if (speed := _shown_speed(one)) is not None]
    if not by_speed:
        return "none with a speed"
    missing = len(walkers) - len(by_speed)
    rest = f"; {missing} {'has' if missing == 1 else 'have'} no speed" if missing else ""
    fastest = walkers[max(by_speed)[1]]
    if prediction.is_standing(fastest.row):
        return f"{'all' if not missing else 'the others'} stand{rest}"
    return f"the fastest, {_describe_member(fastest, walkers)}, {_describe_run(fastest)}{rest}"


def count_walkers(design: str, walkers: Sequence[Member], folder: Path | None = None) -> str:
    """Return the number of walkers as text, with their folder or, without one, the name of their design."""
    return f"{len(walkers)} walker{'s' * (len(walkers) > 1)} {f'in {folder}' if folder else f'of {design}'}"


def _shown_speed(walker: Member) -> float | None:
    """Return the predicted speed of a walker, mm/s, or the theory's if only that was requested; None without one."""
    return walker.row.theory_mm_s if walker.row.has_theory_alone else walker.row.speed.value


def _describe_member(walker: Member, walkers: Sequence[Member]) -> str:
    """Return words that distinguish a walker from the others: its kind of legs, its tilt or both, else its name."""
    kinds, tilts = {one.design.kind for one in walkers}, {one.design.tilt_deg for one in walkers}
    kind = [f"{walker.design.kind} legs"] * (len(kinds) > 1)
    return " at ".join([*kind, *[f"{walker.design.tilt_deg:g} deg"] * (len(tilts) > 1)]) or walker.name


def _describe_run(walker: Member) -> str:
    """Return words on how fast a walker runs, in whole mm/s, with the bounds of 95 %."""
    speed, bounds = _shown_speed(walker) or 0.0, _format_bounds(walker.row.speed)
    source = "the paper's theory, eq. 15" if walker.row.has_theory_alone else f"95 %: {bounds}"
    return f"runs {'backward ' * (speed < 0.0)}at {formatting.format_fixed(abs(speed), 0)} mm/s ({source})"


def needs_notes(walkers: Sequence[Member], scene: Scene) -> bool:
    """Return whether notes are shown without a request: for a missing speed, an accepted error, or theory alone."""
    rows = [walker.row for walker in walkers]
    missing = any(row.speed.value is None and row.falls == 0.0 for row in rows)
    return missing or scene.run.accepted_error is not None or all(row.has_theory_alone for row in rows)


WEIGHED_NOTE = (
    "Weighed: a mass of the whole walker (grams) scales all masses by one factor. The predicted speed then changes "
    "only with the legs' frequency. A body or leg that is weighed separately (body_g, leg_g) changes it more."
)


BODY_MEANING = "M, J: mass and moment of inertia of the body, with its braced legs"
LEG_MEANING = "m, j: those of one flexible leg"
FACTORS_MEANING = (
    "back, front, mean (v/w): speed that the back foot, the front foot or both would settle at, "
    "over the impact speed w of the theory"
)
MEANINGS = {
    "total_g": "mass: of the whole walker, as a balance shows it",
    "M_g": BODY_MEANING,
    "J_g_mm2": BODY_MEANING,
    "m_g": LEG_MEANING,
    "j_g_mm2": LEG_MEANING,
    "theory_mm_s": "eq. 15: the paper's theory",
    "factor_back": FACTORS_MEANING,
    "factor_front": FACTORS_MEANING,
    "factor_mean": FACTORS_MEANING,
}
"""Meanings of short headings, by the keys of their columns."""

MASS_KEYS = ("tilt_deg", "legs", "total_g", "M_g", "J_g_mm2", "m_g", "j_g_mm2")
"""Columns of a table of walkers without speeds."""

MIN_FOLDED_WALKERS = 3
"""Minimum number of walkers on braced legs that share one line."""


def tables(name: str, design: str, walkers: Sequence[Member], why: bool = True) -> list[Table]:
    """Return the table of a design's speeds and, if walkers were weighed, a table of weighed and mesh masses.

    `name`: of the table. `design`: name of the design. `why`: True to add the numbers of notes to speeds.
    """
    rows = [members.columns(member) for member in walkers]
    standing = {member.row for member in _folded_walkers(walkers)}
    moving = [members.row(member) for member in walkers if member.row not in standing]
    speeds = Table(
        name,
        [tuple(row.values()) for row in rows],
        tuple(rows[0]),
        columns(walkers, why),
        f"Predicted speeds of {design}",
        read=moving,
    )
    if not _has_weighings(walkers):
        return [speeds]
    return [speeds, Table("weighed", [members.row(member) for member in walkers], (), MASS_COLUMNS, "Weighed")]


def masses_table(name: str, design: str, walkers: Sequence[Member]) -> Table:
    """Return the table, called `name`, of the masses of the walkers of the design named `design`, without speeds."""
    rows = [{key: value for key, value in member.row.columns().items() if key in MASS_KEYS} for member in walkers]
    shown = (
        report.number_column("tilt\n(deg)", "tilt_deg", 6),
        report.text_column("legs", "legs"),
        _mass_column("mass\n(g)", "total_g"),
    )
    read = [member.row for member in walkers]
    return Table(name, [tuple(row.values()) for row in rows], MASS_KEYS, shown, f"Walkers of {design}", read=read)


def note_lines(walkers: Sequence[Member], why: bool = True) -> list[str]:
    """Return the lines below the table: numbered notes (if `why`), walkers that stand, and weighed masses."""
    notes = [f"[{number}] {note}" for number, note in enumerate(_distinct_notes(walkers), start=1)] if why else []
    standing = _folded_walkers(walkers)
    if standing:
        tilts = [member.design.tilt_deg for member in standing]
        grams = [member.row.total_g for member in standing]
        notes.append(
            f"braced legs, {min(tilts):g} to {max(tilts):g} deg: {len(standing)} walkers of "
            f"{min(grams):.3g} to {max(grams):.3g} g stand still: each runs at less than "
            f"{prediction.STANDING_MM_S:g} mm/s, and 0 lies within its bounds"
        )
    return [*notes, *((WEIGHED_NOTE,) if _has_weighings(walkers) else ())]


def columns(walkers: Sequence[Member], why: bool = True) -> tuple[Column, ...]:
    """Return the columns of the table of speeds. `why`: True to add the numbers of notes to speeds.

    If only the theory was requested, the columns are its inputs and results.
    """
    simulated, notes = any(member.simulated for member in walkers), _distinct_notes(walkers)
    by_theory = any(member.row.speed_by == "theory" for member in walkers)

    def note_mark(note: str) -> str:
        """Return the number of a note in brackets; "" if it is not listed."""
        return f" [{notes.index(note) + 1}]" if note in notes and why else ""

    def format_nominal_speed(row: Any) -> str:
        return (_format_outcome(row) or formatting.format_fixed(row.nominal.number, 1)) + note_mark(row.note)

    def format_theory(row: Any) -> str:
        return formatting.format_fixed(row.theory_mm_s, 1) + note_mark(row.theory_note)

    def format_print_speed(row: Any) -> str:
        speed = row.speed.value
        return "" if speed is None or prediction.is_standing(row) else formatting.format_fixed(speed, 1)

    alone = _has_theory_alone(walkers)
    given = (report.number_column("tilt\n(deg)", "tilt_deg", 6), report.text_column("legs", "legs"))
    masses = (
        _mass_column("M\n(g)", "M_g", wide=not alone),
        _mass_column("J\n(g mm²)", "J_g_mm2", wide=not alone),
        _mass_column("m\n(g)", "m_g", wide=not alone),
        _mass_column("j\n(g mm²)", "j_g_mm2", wide=not alone),
    )
    factors = (
        _factor_column("back\n(v/w)", "factor_back", wide=not alone),
        _factor_column("front\n(v/w)", "factor_front", wide=not alone),
        _factor_column("mean\n(v/w)", "factor_mean", wide=True),
    )
    eq_15 = _with_meaning(Column("eq. 15\n(mm/s)", format_theory, right=True, wide=not by_theory), "theory_mm_s")
    if alone:
        return (*given, *masses, *factors, eq_15)
    return (
        *given,
        _mass_column("mass\n(g)", "total_g"),
        *masses,
        Column("as designed\n(mm/s)", format_nominal_speed, right=True),
        Column("your print\n(mm/s)", format_print_speed, right=True),
        _bounds_column("68 %\n(mm/s)", 0.68),
        _bounds_column("95 %\n(mm/s)", 0.95, wide=simulated),
        eq_15,
        *factors,
        *(RUN_COLUMNS if simulated else ()),
    )


def _format_outcome(row: Any) -> str:
    """Return the text shown instead of a speed: "stands", "falls over" or "-" if unknown; "" for a walker that runs."""
    if prediction.is_standing(row):
        return "stands"
    if row.nominal.value is None:
        return "falls over" if row.falls > 0.0 else "-"
    return ""


def _mass_column(heading: str, key: str, wide: bool = False) -> Column:
    """Return the column of a mass or moment of inertia. `wide`: shown only in wide tables."""
    return _with_meaning(report.number_column(heading, key, wide=wide), key)


def _factor_column(heading: str, key: str, wide: bool) -> Column:
    """Return the column of a factor v/w of the theory. `wide`: shown only in wide tables."""
    return _with_meaning(report.fixed_column(heading, key, 3, wide=wide), key)


def _with_meaning(column: Column, key: str) -> Column:
    """Return the column with the explanation of its short heading, MEANINGS[key]."""
    return column._replace(meaning=MEANINGS[key])


def _has_weighings(walkers: Sequence[Member]) -> bool:
    """Return whether the mass of any walker comes from a balance."""
    return any(member.weighing is not None for member in walkers)


def _folded_walkers(walkers: Sequence[Member]) -> list[Member]:
    """Return the walkers on braced legs that stand and were not simulated; none if fewer than MIN_FOLDED_WALKERS."""
    standing = [
        member
        for member in walkers
        if member.design.kind == "braced" and member.simulated is None and prediction.is_standing(member.row)
    ]
    return standing if len(standing) >= MIN_FOLDED_WALKERS else []


def _distinct_notes(walkers: Sequence[Member]) -> list[str]:
    """Return the different notes on walkers with a row in the table of speeds, in the order of rows."""
    standing = {id(member) for member in _folded_walkers(walkers)}  # equality compares designs and meshes
    shown = [member.row for member in walkers if id(member) not in standing]
    alone = _has_theory_alone(walkers)
    return list(dict.fromkeys(filter(None, (row.theory_note if alone else row.note for row in shown))))


def _has_theory_alone(walkers: Sequence[Member]) -> bool:
    """Return whether only the theory's speeds were requested for all walkers."""
    return all(member.row.has_theory_alone for member in walkers)


def _bounds_column(heading: str, confidence: float, wide: bool = False) -> Column:
    """Return the column of the bounds of the speed at a confidence from 0 to 1. `wide`: shown only in wide tables."""
    return Column(heading, lambda row: _format_bounds(row.speed, confidence), True, wide)


def _format_bounds(speed: Quantity, confidence: float = CONFIDENCE) -> str:
    """Format the bounds of a speed at this confidence as "low to high" in whole mm/s; "" without bounds."""
    return " to ".join(formatting.format_fixed(end, 0) for end in speed.interval(confidence) or ())


def _format_runs(row: Any) -> str:
    """Format the simulated speed of a walker with its 95 % bounds; "-" without a speed."""
    if row.sim_speed.value is None:
        return "-"
    return f"{formatting.format_fixed(row.sim_speed.number, 1)}, {_format_bounds(row.sim_speed)}"


RUN_COLUMNS = (
    Column("simulated\n(mm/s, 95 %)", _format_runs),
    report.text_column("verdict", "verdict"),
    report.text_column("ended", "sim_outcomes"),
)
"""Columns of simulated speeds."""


def _format_mass(row: Any) -> str:
    """Format the weighed mass of a walker with its standard error, g."""
    error = "" if row.mass.se is None else f" ± {formatting.format_number(row.mass.se, 2)}"
    return f"{formatting.format_number(row.mass.number, 4)}{error}"


def _format_mesh_speed(speed: float | None) -> str:
    """Format a speed in the table of weighed masses, mm/s, with two decimals; "" for None."""
    return "" if speed is None else formatting.format_fixed(speed, 2)


def _format_change(row: Any) -> str:
    """Format the predicted speed from weighed masses minus the one from the mesh's masses, mm/s; "" if unknown."""
    speed, mesh_speed = row.speed.value, row.speed_mesh_mm_s
    return _format_mesh_speed(None if speed is None or mesh_speed is None else speed - mesh_speed)


MASS_COLUMNS = (
    report.number_column("tilt\n(deg)", "tilt_deg", 6),
    report.text_column("legs", "legs"),
    report.number_column("weighings", "weighings"),
    Column("mass\n(g)", _format_mass, right=True),
    report.number_column("mesh's\n(g)", "mass_mesh_g"),
    Column("speed\n(mm/s)", lambda row: _format_mesh_speed(row.speed.value), right=True),
    Column("mesh's\n(mm/s)", lambda row: _format_mesh_speed(row.speed_mesh_mm_s), right=True),
    Column("change\n(mm/s)", _format_change, right=True),
)
"""Columns of weighed masses and their speeds, next to those of the mesh."""


def _percent_column(heading: str, key: str) -> Column:
    """Return the column of a share of a variance with its error, percent. `key`: attribute of rows with the share."""

    def format_share(row: Any) -> str:
        value, error = getattr(row, key).pair
        return f"{100 * value:.0f} ± {100 * error:.0f}"

    return Column(f"{heading}, %", format_share, right=True)


SHARE_COLUMNS = (
    report.text_column("measure next", "name"),
    _percent_column("alone", "first"),
    _percent_column("with all others", "total"),
)
"""Columns of an input's shares of a variance: measure the first input next."""


def shares_table(name: str, listed: Sequence[Share], title: str) -> Table:
    """Return the table, called `name`, of uncertain inputs with their shares of the variance of the speed."""
    from walkergen.core.numerics.quantity import column_values

    rows = [tuple(column_values(share).values()) for share in listed]
    return Table(name, rows, ("name", "first", "first_se", "total", "total_se"), SHARE_COLUMNS, title, read=listed)
