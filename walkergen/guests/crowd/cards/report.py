"""Report of a card: its numbers with errors, the methods, and the assumptions."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

from walkergen.core import format_number, format_with_error
from walkergen.files import report
from walkergen.files.report import Column, Report, Table
from walkergen.guests.crowd.cards import overdamped
from walkergen.guests.crowd.cards.card import Card, run_count
from walkergen.guests.crowd.cards.walker_motion import Measured

if TYPE_CHECKING:
    from matplotlib.figure import Figure

QUANTITY_LABELS = {
    "speed_mm_s": ("speed along the heading", "mm/s"),
    "sideways_mm_s": ("velocity to its left", "mm/s"),
    "velocity_relaxation_s": ("velocity along the heading relaxes within", "s"),
    "sideways_relaxation_s": ("velocity across it relaxes within", "s"),
    "delay_s": ("velocity lags by", "s"),
    "translational_diffusion_mm2_s": ("translational diffusion D_T", "mm²/s"),
    "turning_rad_s": ("mean turning rate", "rad/s"),
    "turning_sd_rad_s": ("its spread, print to print", "rad/s"),
    "turning_relaxation_s": ("turning relaxes within", "s"),
    "rotational_diffusion_rad2_s": ("rotational diffusion D_R", "rad²/s"),
    "self_alignment_per_mm": ("self-alignment, > 0 toward a push", "1/mm"),
}
"""Names and units that people read, by the keys of a card."""

CONTACT_KEYS = ("restitution", "friction", "wall_restitution", "wall_friction")


@dataclass(frozen=True, kw_only=True, repr=False)
class CardReport(Report):
    """Report of a card, with the measured motion of its walker."""

    card: Card
    measured: Measured


def make_report(card: Card, measured: Measured) -> CardReport:
    """Make the report of a card and of how it was measured."""
    about = [card.scene] if card.scene else []
    about += [
        f"{format_number(card.mass_g)} g",
        f"{format_number(card.inertia_g_mm2)} g mm² about the vertical axis",
        f"{format_number(card.length_mm)} mm long",
    ]
    notes = list(_notes(card, measured))
    contacts = [(key, getattr(card, key)) for key in CONTACT_KEYS]
    assumed = report.key_columns(("quantity", "assumed"), ("quantity",))
    return CardReport(
        name="card",
        title=f"Card of {card.name}",
        caption=", ".join(about),
        tables=[
            _numbers_table(card, measured),
            Table("contacts", contacts, ("quantity", "assumed"), assumed, "Contacts, from the scene"),
        ],
        facts={"card": card.model_dump(mode="json"), "notes": notes},
        lines=[f"{note}." for note in notes],
        figures={"card": partial(_draw_card, card, measured)},
        card=card,
        measured=measured,
    )


def _numbers_table(card: Card, measured: Measured) -> Table:
    """Return the table of a card's numbers. Notes explain why a number is unknown or only bounded."""
    notes = _missing_reasons(measured)
    rows = []
    for key in QUANTITY_LABELS:
        number, note = getattr(card, key), notes.get(key, "")
        if number is not None:
            rows.append((key, number.value, number.se, run_count(number), note))
        else:
            rows.append((key, None, None, None, note or "unknown"))

    def format_value(row: tuple[str, float | None, float | None, int | None, str]) -> str:
        _, value, se, _, note = row
        if value is None:
            return note
        return format_with_error(value, se or 0.0) + (f" ({note})" if note else "")

    columns = (
        Column("", lambda row: QUANTITY_LABELS[row[0]][0]),
        Column("", lambda row: QUANTITY_LABELS[row[0]][1]),
        Column("value ± standard error", format_value),
        Column("runs", lambda row: "" if row[3] is None else str(row[3]), right=True),
    )
    return Table("card", rows, ("quantity", "value", "se", "runs", "note"), columns, "Motion of a walker alone")


def _missing_reasons(measured: Measured) -> dict[str, str]:
    """Return why numbers are unknown or only bounded, by their keys in the card."""
    found = measured.motion.estimates
    reasons = {
        "delay_s": measured.delay.mean.refused,
        "turning_sd_rad_s": found["turning_scatter"].refused,
        "sideways_mm_s": found["sideways_speed"].refused,
        "sideways_relaxation_s": measured.sideways.refused,
        "turning_relaxation_s": measured.turning.time.refused,
        "self_alignment_per_mm": measured.aligning.refused,
    }
    for key, relaxed in (("velocity_relaxation_s", measured.velocity), ("turning_relaxation_s", measured.turning)):
        if relaxed.time.value is not None and not relaxed.resolved:
            reasons[key] = f"not resolved: below {format_number(measured.interval)} s"
    return reasons


def _notes(card: Card, measured: Measured) -> Iterator[str]:
    """Yield notes: whether a model without inertia is enough, how numbers were measured, and what is assumed."""
    if card.overdamped is not None:
        yield overdamped.format_verdict(card.overdamped)
        yield overdamped.SOURCES
    yield from measured.notes
    yield from _motion_notes(measured)
    yield "restitution and friction of contacts come from the scene ([crowd], [arena]) and are not measured"
    yield "outlines show the bodies without their legs"


def _motion_notes(measured: Measured) -> Iterator[str]:
    """Yield the method of speeds and their errors, and the data behind a delay."""
    yield measured.motion.method
    yield (
        f"velocities fluctuate by {format_number(measured.velocity.deviation)} mm/s about the part that follows the "
        "heading. The relaxation is that of the correlation of these fluctuations"
    )
    if measured.delay.mean.value is not None:
        yield f"the delay is from the delay function up to {format_number(measured.delay.until)} s"


def _draw_card(card: Card, measured: Measured) -> "Figure":
    from walkergen.guests.crowd.cards import figures

    return figures.draw_card(card, measured)
