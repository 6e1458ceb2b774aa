"""What a body that bends (6 kHz) and twists (10 kHz) would take from a landing: an estimate.

The model in space holds the body rigid. Here one spring and damper, as a corner of the paper's
walker at 10 deg has them, meets a plate along the normal alone, without friction; behind it are
the walker's inverse mass at that corner (docs/physics.md section 7) and the body's first modes, of
a free beam and a free shaft, each by its shape where the leg stands. Two feet that land level have
four such springs, excite the mean of the bending's shapes, and do not twist the body. Printed is
the speed that the walker as a whole keeps 1 ms later, over that of the landing. Legs, whose own
twist and swing the model has, are light; what a mode kept until the next landing is left out.

    python -m evidence.causes.body_mode        (15 s)
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from walkergen.files import templates
from walkergen.simulation.effects import feet
from walkergen.walker import solids
from walkergen.walker.design import Design

CORNER = 6.75
"""Inverse mass along the normal at a back corner at 10 deg, 1/g (docs/validation.md)."""

LOSS = 0.015
"""Damping ratio of the body's modes."""

BEAM = 4.730041
"""First root of cos x cosh x = 1, of a free beam."""

LABELS = (0.22, 0.5, 0.8, 1.0)
"""Labels of the feet."""


class Mode(NamedTuple):
    """Mode of the body as a foot feels it."""

    frequency: float
    """Hz."""
    mobility: float
    """Inverse modal mass at the contact, 1/g."""


class Body(NamedTuple):
    """Box that bends and twists; mm, g, s."""

    length: float
    depth: float
    thickness: float
    modulus: float
    density: float

    @property
    def mass(self) -> float:
        """Mass, which is the modal mass of bending too."""
        return self.density * self.length * self.depth * self.thickness

    @property
    def bending(self) -> float:
        """First frequency of the free beam, Hz."""
        stiff = self.modulus * self.thickness**2 / (12.0 * self.density)
        return (BEAM / self.length) ** 2 * math.sqrt(stiff) / (2.0 * math.pi)

    @property
    def twisting(self) -> float:
        """First frequency of the free shaft, Hz; Poisson's ratio is that of the legs, 0.36."""
        a, b = self.depth, self.thickness
        twist = a * b**3 * (1.0 / 3.0 - 0.21 * b / a * (1.0 - b**4 / (12.0 * a**4)))
        polar = a * b * (a**2 + b**2) / 12.0
        speed = math.sqrt(self.modulus / 2.72 * twist / (self.density * polar))
        return speed / (2.0 * self.length)

    def bent(self, x: float) -> float:
        """Shape of the first bending mode at x from the middle: 2 at the ends."""
        at, end = BEAM * x / self.length, 0.5 * BEAM
        return math.cos(at) / math.cos(end) + math.cosh(at) / math.cosh(end)

    def modes(self, places: list[float], one_corner: bool) -> list[Mode]:
        """Modes as feet at these places along the body feel them, that land together."""
        bent = float(np.mean([self.bent(x) for x in places]))
        modes = [Mode(self.bending, bent**2 / self.mass)]
        if one_corner:  # both corners of a foot do not twist the body
            lift = 0.5 * self.depth * math.sin(math.pi * places[0] / self.length)
            inertia = 0.5 * self.mass * (self.depth**2 + self.thickness**2) / 12.0
            modes.append(Mode(self.twisting, lift**2 / inertia))
        return modes


def keeps(label: float, stiffness: float, mobility: float, corners: int, modes: Sequence[Mode]) -> float:
    """Speed kept by what lands with speed 1 on `corners` feet of a label (stiffness of one)."""
    damper = 2.0 * feet.damping_ratio(label) * math.sqrt(stiffness / CORNER)
    omega = 2.0 * math.pi * np.array([mode.frequency for mode in modes])
    push = np.array([mode.mobility for mode in modes])

    def rates(time: float, state: np.ndarray) -> np.ndarray:
        places, speeds = np.split(state, 2)
        depth, approach = -places.sum(), -speeds.sum()
        force = max(corners * (stiffness * depth + damper * approach), 0.0) if depth > 0.0 else 0.0
        modal = push * force - omega * (omega * places[1:] + 2.0 * LOSS * speeds[1:])
        return np.concatenate([speeds, [mobility * force], modal])

    start = np.zeros(2 * len(modes) + 2)
    start[len(modes) + 1] = -1.0
    step = 0.02 / math.sqrt(stiffness * CORNER)
    found = solve_ivp(rates, (0.0, 1e-3), start, max_step=5.0 * step, rtol=1e-7, atol=1e-12)
    return float(found.y[len(modes) + 1, -1])


def main() -> None:
    design = templates.load("koumakis2016", "walkers", Design).variant(tilt_deg=10.0)
    size, material, leg = design.size, design.material, design.limbs[0]
    modulus = 1e9 * material.youngs_modulus_gpa
    body = Body(size.length, size.depth, size.thickness, modulus, 1e-3 * material.density_g_cm3)
    stiffness, reach = feet.axial_stiffness(leg, modulus), leg.length * math.sin(leg.tilt)
    back, front = reach - 0.5 * design.foot_span, reach + 0.5 * design.foot_span
    whole = 1.0 / float(solids.mass_of(design).total)
    landings = {
        "a back corner": (CORNER, 1, body.modes([back], True)),
        "a front corner": (CORNER, 1, body.modes([front], True)),
        "both feet, level": (whole, 4, body.modes([back, front], False)),
    }
    print(
        f"bending {body.bending:.0f} Hz, twist {body.twisting:.0f} Hz, a corner on its foot "
        f"{math.sqrt(stiffness * CORNER) / (2.0 * math.pi):.0f} Hz\n"
    )
    print(f"| lands | body | at the foot, 1/g | {' | '.join(f'{one:g}' for one in LABELS)} |")
    print("|---|---|---|" + "---|" * len(LABELS))
    for name, (mobility, corners, modes) in landings.items():
        chosen = {"rigid": [], "bends": modes[:1]}
        if modes[1:]:
            chosen |= {"twists": modes[1:], "both": modes}
        for words, some in chosen.items():
            kept = [keeps(label, stiffness, mobility, corners, some) for label in LABELS]
            inverse = sum(mode.mobility for mode in some) if some else mobility
            ratios = " | ".join(f"{ratio:.2f}" for ratio in kept)
            print(f"| {name} | {words} | {inverse:.2f} | {ratios} |")


if __name__ == "__main__":
    main()
