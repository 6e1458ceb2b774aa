"""Report of a card: its numbers with errors, how they were found, and what is assumed."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

from walkergen.analysis import walls
from walkergen.crowd.card import Card, Known
from walkergen.crowd.cards import overdamped
from walkergen.crowd.cards.walker_motion import Measured
from walkergen.crowd.cards.walled import Walled
from walkergen.files import report, words
from walkergen.files.report import Column, Report, Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

QUANTITIES = {
    "speed_mm_s": ("speed along the heading", "mm/s"),
    "sideways_mm_s": ("velocity to its left", "mm/s"),
    "velocity_relaxation_s": ("velocity relaxes within", "s"),
    "delay_s": ("velocity lags by", "s"),
    "translational_diffusion_mm2_s": ("translational diffusion D_T", "mm²/s"),
    "turning_rad_s": ("mean turning rate", "rad/s"),
    "turning_sd_rad_s": ("its spread, print to print", "rad/s"),
    "turning_relaxation_s": ("turning relaxes within", "s"),
    "rotational_diffusion_rad2_s": ("rotational diffusion D_R", "rad²/s"),
    "wall_alignment": ("alignment by a wall", ""),
    "wall_turning_rad_s": ("turning along it", "rad/s"),
    "wall_torque_g_mm2_s2": ("torque of the wall", "g mm²/s²"),
}
"""Names and units that people read, by the keys of a card."""

BY_WALL = tuple(key for key in QUANTITIES if key.startswith("wall_"))
"""Keys of what only runs against a wall tell."""

CONTACTS = ("restitution", "friction", "wall_restitution", "wall_friction")


class Row(NamedTuple):
    """Number of a card; the field names are the columns of card.csv."""

    quantity: str
    value: float | None
    se: float | None
    runs: int | None
    note: str
    """Reason why it is not known, or why less is known of it."""


@dataclass(frozen=True, kw_only=True, repr=False)
class CardReport(Report):
    """Card of a walker, with the motion that it is from."""

    card: Card
    measured: Measured | None
    """None for a card that was read from a file."""
    walled: Walled | None
    """None for a walker that did not run against walls."""


COLUMNS = (
    Column("", lambda row: QUANTITIES[row.quantity][0]),
    Column("", lambda row: QUANTITIES[row.quantity][1]),
    Column("value ± standard error", lambda row: _value(row)),
    report.number("runs", "runs", 6),
)


def of(card: Card, measured: Measured | None, walled: Walled | None = None) -> CardReport:
    """Report of a card; of one that was measured also how."""
    known = [key for key in QUANTITIES if key not in BY_WALL or getattr(card, key) is not None]
    rows = [_row(card, key, measured) for key in known]
    contacts = [(key, getattr(card, key)) for key in CONTACTS]
    draw: dict[str, Callable[[], Figure]] = {}
    if measured is not None:
        draw = {"card": partial(_draw, card, measured)}
    notes = [*_notes(card, measured)]
    if walled is not None:
        draw["walls"] = partial(_draw_walls, card, walled)
        notes.insert(-1, _of_walls(walled))
    return CardReport(
        name="card",
        title=f"Card of {card.name}",
        caption=", ".join(
            filter(
                None,
                (
                    card.scene,
                    f"{words.number(card.mass_g)} g",
                    f"{words.number(card.inertia_g_mm2)} g mm² about the vertical axis",
                    f"{words.number(card.length_mm)} mm long",
                ),
            )
        ),
        tables=[
            Table("card", rows, Row._fields, COLUMNS, "Motion of a walker alone"),
            Table(
                "contacts",
                contacts,
                ("quantity", "assumed"),
                report.every(("quantity", "assumed"), ("quantity",)),
                "Contacts, as the scene has them",
            ),
        ],
        facts={"card": card.model_dump(mode="json"), "notes": notes},
        lines=[f"{note}." for note in notes],
        figures=draw,
        card=card,
        measured=measured,
        walled=walled,
    )


def _row(card: Card, key: str, measured: Measured | None) -> Row:
    known: Known | None = getattr(card, key)
    note = _reason(key, measured)
    if known is None:
        return Row(key, None, None, None, note or "not known")
    return Row(key, known.value, known.se, known.runs, note)


def _reason(key: str, measured: Measured | None) -> str:
    """Why a number is not known, or what bounds it; '' where nothing is to be said."""
    if measured is None:
        return ""
    found, shortest = measured.motion.estimates, f"{words.number(measured.interval)} s"
    reasons = {
        "delay_s": measured.delay.mean.refused,
        "turning_sd_rad_s": found["turning_scatter"].refused,
        "sideways_mm_s": found["sideways_speed"].refused,
        "turning_relaxation_s": measured.turning.time.refused,
    }
    for own, relaxed in (("velocity_relaxation_s", measured.velocity), ("turning_relaxation_s", measured.turning)):
        if relaxed.time.value is not None and not relaxed.resolved:
            reasons[own] = f"not resolved: below {shortest}"
    return reasons.get(key, "")


def _value(row: Row) -> str:
    if row.value is None:
        return row.note
    known = words.with_error(row.value, 0.0 if row.se is None else row.se)
    return f"{known} ({row.note})" if row.note else known


def _notes(card: Card, measured: Measured | None) -> Iterator[str]:
    if card.overdamped is not None:
        yield overdamped.in_words(card.overdamped)
        yield overdamped.SOURCES
    if measured is not None:
        yield from measured.notes
        yield from _of_motion(measured)
    yield (
        "restitution and friction of contacts are those of the scene ([crowd], [arena]), assumed, "
        "not measured; outlines are those of bodies, legs left out"
    )


def _of_motion(measured: Measured) -> Sequence[str]:
    """Method of speeds and their errors, and what a delay was found with."""
    own, delayed, leaning = [measured.motion.method], measured.delay.mean, measured.leaning
    spread = measured.velocity.deviation
    own.append(
        f"velocities fluctuate by {words.number(spread)} mm/s along each axis; the relaxation is "
        "that of their correlation, once what the heading explains is taken off"
    )
    if delayed.value is not None:
        own.append(f"the delay is from the delay function up to {words.number(measured.delay.until)} s")
    if leaning.value is not None and leaning.se is not None:
        sideways = words.with_error(leaning.value, leaning.se)
        own.append(
            f"pushes that turn it by 1 rad/s move it by {sideways} mm/s to "
            "the same side: above 0 its velocity leads the heading by them, which the delay counts"
        )
    return own


def _of_walls(walled: Walled) -> str:
    """How motion by a wall was measured, and what an alignment means."""
    low, high = (round(math.degrees(angle)) for angle in walls.ASKEW)
    return (
        f"by the wall of {walled.dish.words}: {walled.runs} runs, let go beside it at angles from "
        "head on to along it; alignment is -1 head on, 1 along it, over the second half of each; "
        f"turning and torque are those of walkers that run against it at {low} to {high} degrees"
    )


def _draw_walls(card: Card, walled: Walled) -> "Figure":
    from walkergen.crowd.cards import figures

    return figures.of_walls(card, walled)


def _draw(card: Card, measured: Measured) -> "Figure":
    from walkergen.crowd.cards import figures

    return figures.of_card(card, measured)
