"""Hard cases of the cascade that a landing on relaxed legs is."""

import math
from collections.abc import Iterator

import numpy as np

from walkergen.jobs.trust.selftest.case import Case, Check, exactly
from walkergen.jobs.trust.selftest.scenes import design_of, masses
from walkergen.numerics.kernels import kernel
from walkergen.simulation.relaxed.cascade import Landing, cascade, stopping_impulse
from walkergen.simulation.relaxed.state import Tensor
from walkergen.simulation.world import Contact
from walkergen.theory.impact import Law, impact
from walkergen.theory.tensors import feet, rigid


def _tensors(tilt_deg: float, leg_mass: float) -> list[tuple[Tensor, Tensor]]:
    """Tensors (flexible, rigid) of the back and of the front foot."""
    mass = masses(design_of("relaxed", tilt_deg), leg_mass)
    pairs = []
    for own, leg in zip(feet(mass), mass.legs, strict=True):
        H = rigid(mass.M, mass.J, leg.foot)
        pairs.append((Tensor(*(float(v) for v in own)), Tensor(*(float(v) for v in H))))
    return pairs


def _landed(own: Tensor, H: Tensor, v_x: float, contact: Contact) -> tuple[Landing, int]:
    counts = np.zeros(9, np.int64)
    landing: Landing = cascade(own, H, v_x, -1.0, contact, counts)
    return landing, int(counts[0])


@kernel
def _one_by_one(own: Tensor, H: Tensor, v_x: float, contact: Contact) -> tuple[float, float]:
    """Impulse of a landing summed over its impacts, until the approach is below 1e-14."""
    e, mu, law = contact
    v_y, F_x, F_y = -1.0, 0.0, 0.0
    for _ in range(3_000_000):
        hit = impact(own.xx, own.xy, own.yy, v_x, v_y, e, mu, law)
        F_x, F_y = F_x + hit.F_x, F_y + hit.F_y
        v_x += H.xx * hit.F_x + H.xy * hit.F_y
        v_y += H.xy * hit.F_x + H.yy * hit.F_y
        if v_y >= -1e-14:
            return F_x, F_y
    return math.nan, math.nan


def _sum_of_impacts(model: str) -> Iterator[Check]:
    for law in Law:
        rng, worst = np.random.default_rng(int(law)), 0.0
        for _ in range(1500):
            own, H = _tensors(rng.uniform(-60, 60), 10 ** rng.uniform(-3, 0))[rng.integers(2)]
            mu = float(rng.choice([0.0, 10 ** rng.uniform(-2, 3)]))
            contact = Contact(float(rng.choice([0.0, 1.0, rng.uniform()])), mu, int(law))
            v_x = float(rng.choice([0.0, rng.normal() * 10 ** rng.uniform(-2, 2)]))
            landing, _ = _landed(own, H, v_x, contact)
            F_x, F_y = _one_by_one(own, H, v_x, contact)
            gap = math.hypot(landing.F_x - F_x, landing.F_y - F_y) / math.hypot(F_x, F_y)
            worst = math.nan if math.isnan(gap) else max(worst, gap)
        yield Check(
            f"{law.name.lower()}: impulse of 1500 landings, impact by impact",
            worst,
            1e-9,
            "the sum is cut at an approach of 1e-14; 1e5 roundings",
        )


def _finite_work(model: str) -> Iterator[Check]:
    rng = np.random.default_rng(7)
    most, cone, finished, mirror = 0, 0.0, True, 0.0
    for _ in range(6000):
        own, H = _tensors(rng.uniform(-65, 65), 10 ** rng.uniform(-10, 3))[rng.integers(2)]
        mu = float(rng.choice([0.0, 5.0, 1e3, rng.uniform(0, 1)]))
        contact = Contact(float(rng.choice([0.0, 1.0, 0.8])), mu, 0)
        v_x = float(rng.choice([0.0, rng.normal() * 10 ** rng.uniform(-3, 3)]))
        landing, impacts = _landed(own, H, v_x, contact)
        finished = finished and bool(landing.finished) and landing.v_y >= 0.0
        most = max(most, impacts)
        cone = max(cone, abs(landing.F_x) - mu * landing.F_y * (1 + 1e-9))
        image, _ = _landed(own._replace(xy=-own.xy), H._replace(xy=-H.xy), -v_x, contact)
        mirror = max(mirror, abs(image.F_x + landing.F_x), abs(image.F_y - landing.F_y))
    yield exactly("every landing ends without approach", finished)
    yield Check(
        "impacts computed in one landing",
        most,
        10_000,
        "legs of 1e-10 g make 1e10 impacts; runs of one type are raised to powers",
    )
    yield Check("impulse outside the friction cone", cone, 0.0, "1e-9: rounding of H^-1")
    yield Check("impulse of the mirror image", mirror, 0.0, "exact: only signs differ")


def _closed_form(model: str) -> Iterator[Check]:
    """Check sliding throughout: a plastic rigid impact, without e and the flexible tensor."""
    worst = held = 0.0
    tails, mu = 0, 0.1
    for tilt in (3.0, 10.0, 20.0, 35.0):
        for e in (0.0, 0.5, 0.9):
            for own, H in _tensors(tilt, 0.02976):
                normal = 1.0 / (H.yy - mu * H.xy)
                if (1 + e) / normal < own.yy - mu * own.xy:  # else the first impact separates
                    landing, _ = _landed(own, H, 1e3, Contact(e, mu, 0))
                    off = math.hypot(landing.F_x + mu * normal, landing.F_y - normal)
                    worst, tails = max(worst, off / normal), tails + 1
                stop = stopping_impulse(H, 0.1, -1.0)
                landing, _ = _landed(own, H, 0.1, Contact(0.0, 1e3, 0))
                if landing.v_x == 0.0 and landing.v_y == 0.0:
                    held = max(held, math.hypot(landing.F_x - stop[0], landing.F_y - stop[1]))
    yield exactly("most landings at 3 to 35 deg have such a tail", tails >= 15)
    yield Check("fast slip: (w / k_r) (-mu, 1)", worst, 1e-12, "rounding of some ten operations")
    yield Check("held by friction: -H^-1 v, g mm/s", held, 1e-9, "an approach cut at 1e-13")


CASES = [
    Case("chatter: sum of the impacts", "6.10", "the impacts one by one", ("relaxed",), _sum_of_impacts),
    Case("chatter: finite work", "6.10", "finite work of a geometric series", ("relaxed",), _finite_work),
    Case("chatter: closed form of the tail", "6.10", "geometric series", ("relaxed",), _closed_form),
]
