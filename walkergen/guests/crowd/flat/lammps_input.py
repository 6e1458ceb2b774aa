"""LAMMPS input of a crowd as text: bodies, contacts, and output times.

Every walker is a rigid body of discs (fix rigid/small) with the card's mass and inertia. A particle without size at the
centre of mass C carries the push (fix propel/self), the noise and the drag (fix langevin), so these act at C and as
torque. For a turning walker a second particle ahead of C pushes sideways. Units are mm, g and s: `units lj` leaves all
factors 1. `parts`: forces, discs and contacts of the crowd's kinds, from `mechanics`. k: number of a kind.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from walkergen.core import Array, Dish, Whole
from walkergen.guests.crowd.cards.card import Card
from walkergen.guests.crowd.flat import contact, discs, motion

INPUT_FILE, DATA_FILE, BODIES_FILE, DUMP_FILE = "crowd.in", "crowd.data", "crowd.bodies", "crowd.dump"
"""Names of the files that LAMMPS reads, and of the one that it writes."""

DISC_TOLERANCE = 0.025
"""Bumps of a row of discs, as a share of the widest disc's radius of the narrowest walker."""

INFINITE_RELAXATION_S = 1e9
"""Relaxation time of the noise that only turns: large enough to leave velocities unchanged, s."""

BOX_MARGIN_MM = 20.0
"""Distance between the walls of a dish and the edge of the simulation box, mm."""

MAX_BINS = 500
"""Most neighbour bins along a side of the box."""


class Crowd(NamedTuple):
    """Walkers, dish, initial poses and settings of one run."""

    cards: Sequence[Card]
    kinds: Whole
    """Index in `cards` of each walker, shape (N,)."""
    dish: Dish
    places: Array
    """x, y (mm) and heading (rad) of each walker, shape (N, 3)."""
    turning: Array
    """Mean turning rate of each walker, rad/s, shape (N,)."""
    seconds: float
    rate_hz: float
    seed: int
    running: bool = False
    """Whether walkers start at the speeds and turning rates of their cards. Otherwise they start at rest."""

    @property
    def frames(self) -> int:
        """Number of frames that are written, the first at the start."""
        return frame_count(self.seconds, self.rate_hz)


def frame_count(seconds: float, rate_hz: float) -> int:
    """Return the number of frames in `seconds`, the first at the start."""
    return math.floor(seconds * rate_hz + 1e-9) + 1


class Mechanics(NamedTuple):
    """Mechanics of the cards in LAMMPS, by kind."""

    motions: list[motion.Motion]
    discs: list[discs.Discs]
    contacts: contact.Contacts


def outline_tolerance(cards: Sequence[Card]) -> float:
    """Return the allowed distance (mm) of outlines from their discs: a share of the narrowest walker's widest disc."""
    return DISC_TOLERANCE * min(discs.inscribed_radius(card) for card in cards)


def mechanics(cards: Sequence[Card]) -> Mechanics:
    """Compute the forces, the discs and the contact laws of each card."""
    motions = [motion.from_card(card) for card in cards]
    bodies = [discs.cover_outline(card, outline_tolerance(cards)) for card in cards]
    return Mechanics(motions, bodies, contact.contact_laws(cards, motions, bodies))


def steps_per_frame(crowd: Crowd, parts: Mechanics) -> int:
    """Return the number of steps between two frames."""
    return max(1, math.ceil(1.0 / (crowd.rate_hz * parts.contacts.longest_step)))


def input_files(crowd: Crowd, parts: Mechanics) -> dict[str, bytes]:
    """Return the input script, the particles and the bodies, by file name. Equal crowds give equal files."""
    texts = {
        INPUT_FILE: _input_script(crowd, parts),
        DATA_FILE: _particle_data(crowd, parts),
        BODIES_FILE: _body_data(crowd, parts),
    }
    return {name: text.encode("ascii") for name, text in texts.items()}


# Types of particles: 1..K at C, by kind; K + 1 the sideways push; then discs by kind


def _input_script(crowd: Crowd, parts: Mechanics) -> str:
    """Return the text of the input script."""
    count = len(crowd.cards)
    stride = steps_per_frame(crowd, parts)
    step = 1.0 / (crowd.rate_hz * stride)
    widest = max(float(body.radii.max()) for body in parts.discs)
    skin = 0.4 * widest
    reach = max(body.reach for body in parts.discs)
    bins = max(widest + 0.5 * skin, 2.0 * max(_half_box(crowd, parts)) / MAX_BINS)
    lines = [
        f"# {len(crowd.places)} walkers in {crowd.dish.words}; mm, g, s",
        "units lj",
        "dimension 2",
        f"boundary {'p p p' if crowd.dish.period else 'f f p'}",
        "atom_style hybrid sphere dipole ellipsoid",
        "atom_modify map array sort 0 0.0",  # sorted by place, the discs of a body would lie apart in memory
        f"comm_modify vel yes cutoff {_format_number(max(reach, 2.0 * widest) + 2.0 * skin)}",
        "processors * * 1",
        "newton on",
        "fix member all property/atom mol ghost yes",
        f"read_data {DATA_FILE} fix member NULL Molecules",
        f"group core type {_format_types(1, count)}",
        f"group points type {_format_types(1, count + 1)}",
        *(f"set type {k + 1} mass {_format_number(parts.motions[k].mass)}" for k in range(count)),
        f"neighbor {_format_number(skin)} bin",
        f"neigh_modify delay 0 every 1 check yes binsize {_format_number(bins)}",
        "neigh_modify exclude molecule/intra all",
        "neigh_modify exclude group points all",
        "pair_style granular",
        f"pair_coeff * * {_format_contact(next(iter(parts.contacts.pairs.values())))}",
        *(
            f"pair_coeff {count + 2 + i} {count + 2 + j} {_format_contact(one)}"
            for (i, j), one in parts.contacts.pairs.items()
        ),
        f"fix body all rigid/small molecule infile {BODIES_FILE}",
        *_wall_commands(crowd, parts),
        "fix push points propel/self dipole 1.0",
        "compute heading core property/atom quatw quatk",
        *_noise_commands(crowd, parts),
        *_sideways_drag_commands(parts),
        "fix plane all enforce2d",
        f"dump track core custom {stride} {DUMP_FILE} id xu yu c_heading[1] c_heading[2]",
        "dump_modify track sort id format float %.10g",
        f"timestep {_format_number(step)}",
        f"thermo {stride * max(1, crowd.frames // 200)}",
        "thermo_style custom step",
        f"run {stride * (crowd.frames - 1)}",
    ]
    return "\n".join(lines) + "\n"


def _format_contact(law: contact.Contact) -> str:
    """Format a contact law for the commands pair_style granular and fix wall/gran."""
    return (
        f"hooke {_format_number(law.stiffness)} {_format_number(law.damping)} damping velocity tangential "
        f"linear_nohistory {_format_number(law.grip / law.damping)} {_format_number(law.friction)} limit_damping"
    )


def _wall_commands(crowd: Crowd, parts: Mechanics) -> list[str]:
    """Return the commands for the dish's walls, which act on the discs of each kind."""
    kind, sizes, count = crowd.dish.kind, crowd.dish.sizes, len(crowd.cards)
    lines: list[str] = []
    if kind == "ring":
        lines.append(f"region inner cylinder z 0 0 {_format_number(0.5 * sizes[1])} INF INF side out")
    for k in range(count):
        law = f"granular {_format_contact(parts.contacts.walls[k])}"
        lines.append(f"group kind{k + 1} type {count + 2 + k}")
        if kind == "rectangle":
            for axis, size in zip("xy", sizes, strict=True):
                half = _format_number(0.5 * size)
                lines.append(f"fix wall{axis}{k + 1} kind{k + 1} wall/gran {law} {axis}plane -{half} {half}")
        elif kind in ("disc", "ring"):
            radius = _format_number(0.5 * sizes[0])
            lines.append(f"fix outer{k + 1} kind{k + 1} wall/gran {law} zcylinder {radius}")
        if kind == "ring":
            lines.append(f"fix inner{k + 1} kind{k + 1} wall/gran/region {law} region inner")
    return lines


def _noise_commands(crowd: Crowd, parts: Mechanics) -> list[str]:
    """Return the commands for drag and noise on the velocity and turning rate of each kind."""
    lines = []
    for k, model in enumerate(parts.motions):
        first, second = np.random.SeedSequence([crowd.seed, k]).generate_state(2) % 899_999_999
        lines += [
            f"group core{k + 1} type {k + 1}",
            f"fix drag{k + 1} core{k + 1} langevin {_format_number(model.heat)} {_format_number(model.heat)} "
            f"{_format_number(model.relaxation)} {first + 1}",
            f"fix turn{k + 1} core{k + 1} langevin {_format_number(model.spin_heat)} {_format_number(model.spin_heat)} "
            f"{_format_number(INFINITE_RELAXATION_S)} {second + 1} angmom "
            f"{_format_number(INFINITE_RELAXATION_S / model.turning_relaxation)}",
        ]
    return lines


def _sideways_drag_commands(parts: Mechanics) -> list[str]:
    """Return the commands for the extra drag across the heading; empty if no kind of walker has any."""
    lines = [
        'variable cosine atom "c_heading[1]*c_heading[1] - c_heading[2]*c_heading[2]"',
        'variable sine atom "2.0*c_heading[1]*c_heading[2]"',
        'variable left atom "vy*v_cosine - vx*v_sine"',
    ]
    for k, model in enumerate(parts.motions):
        extra_drag = model.mass / model.sideways_relaxation - model.mass / model.relaxation
        if extra_drag:
            lines += [
                f'variable sidex{k + 1} atom "{_format_number(extra_drag)}*v_left*v_sine"',
                f'variable sidey{k + 1} atom "{_format_number(-extra_drag)}*v_left*v_cosine"',
                f"fix side{k + 1} core{k + 1} addforce v_sidex{k + 1} v_sidey{k + 1} 0.0",
            ]
    return lines if len(lines) > 3 else []


def _half_box(crowd: Crowd, parts: Mechanics) -> tuple[float, float]:
    """Return half the size of the simulation box along x and y, mm."""
    room = 0.0 if crowd.dish.period else BOX_MARGIN_MM + 2.0 * max(one.reach for one in parts.discs)
    length, width = crowd.dish.box
    return 0.5 * length + room, 0.5 * width + room


def _particle_data(crowd: Crowd, parts: Mechanics) -> str:
    """Return the text of the particle file: for each walker, one particle at C, one ahead of C, and discs."""
    count = len(crowd.cards)
    atoms: list[str] = []
    ellipsoids: list[str] = []
    members: list[str] = []
    for number, (k, (x, y, angle)) in enumerate(zip(crowd.kinds, crowd.places, strict=True), 1):
        model, body = parts.motions[k], parts.discs[k]
        lever = math.sqrt(model.inertia / model.mass)
        aside = model.inertia * crowd.turning[number - 1] / model.turning_relaxation / lever
        c, s = math.cos(angle), math.sin(angle)
        # Type, place from C (forward, left), diameter, force (forward, left)
        rows = [(k + 1, 0.0, 0.0, 0.0, model.push, -aside), (count + 1, lever, 0.0, 0.0, 0.0, aside)]
        rows += [
            (count + 2 + k, u, v, 2.0 * radius, 0.0, 0.0)
            for (u, v), radius in zip(body.places, body.radii, strict=True)
        ]
        for row, (kind, u, v, diameter, ahead, left) in enumerate(rows):
            name = len(atoms) + 1
            place = f"{_format_number(x + c * u - s * v)} {_format_number(y + s * u + c * v)} 0"
            force = f"{_format_number(c * ahead - s * left)} {_format_number(s * ahead + c * left)} 0"
            atoms.append(f"{name} {kind} {place} {_format_number(diameter)} 1 0 {force} {int(row == 0)}")
            members.append(f"{name} {number}")
        # A ball of this radius and the walker's mass has the walker's inertia
        size = _format_number(2.0 * math.sqrt(2.5) * lever)
        ellipsoids.append(
            f"{len(atoms) - len(rows) + 1} {size} {size} {size} "
            f"{_format_number(math.cos(0.5 * angle))} 0 0 {_format_number(math.sin(0.5 * angle))}"
        )
    half = _half_box(crowd, parts)
    head = [
        "Particles of a crowd",
        "",
        f"{len(atoms)} atoms",
        f"{2 * count + 1} atom types",
        f"{len(ellipsoids)} ellipsoids",
        *(f"-{_format_number(h)} {_format_number(h)} {a}lo {a}hi" for h, a in zip(half, "xy", strict=True)),
        "-0.5 0.5 zlo zhi",
    ]
    sections = {"Atoms": atoms, "Ellipsoids": ellipsoids, "Molecules": members}
    tail = [line for name, rows in sections.items() for line in ("", name, "", *rows)]
    return "\n".join([*head, *tail]) + "\n"


def _body_data(crowd: Crowd, parts: Mechanics) -> str:
    """Return the text of the body file: mass, centre, inertia, velocity and angular momentum at the start."""
    rows = [str(len(crowd.places))]
    for number, (k, (x, y, angle)) in enumerate(zip(crowd.kinds, crowd.places, strict=True), 1):
        model = parts.motions[k]
        inertia = _format_number(model.inertia)
        speed = crowd.cards[k].speed_mm_s.number if crowd.running else 0.0
        vx, vy = speed * math.cos(angle), speed * math.sin(angle)
        spin = model.inertia * crowd.turning[number - 1] if crowd.running else 0.0
        rows.append(
            f"{number} {_format_number(model.mass)} {_format_number(x)} {_format_number(y)} 0 {inertia} "
            f"{inertia} {inertia} 0 0 0 "
            f"{_format_number(vx)} {_format_number(vy)} 0 0 0 {_format_number(spin)} 0 0 0"
        )
    return "\n".join(rows) + "\n"


def _format_types(first: int, last: int) -> str:
    """Format a range of particle types for LAMMPS."""
    return f"{first}" if first == last else f"{first}:{last}"


def _format_number(number: float) -> str:
    """Format a number for the input: the shortest text that reads back the same to twelve digits."""
    return f"{number:.12g}"
