"""Motion of a single walker: forces and noise that reproduce its card's numbers.

m dv/dt = -(m/tau)(v - V e(theta)) + noise, I dw/dt = -(I/tau_r)(w - w0) + noise: the underdamped Langevin model of
Scholz et al., Nature Communications 9, 5156 (2018). Here the velocity across the heading has its own relaxation time.
Noise spreads by D_T, the mean of both axes, and D_R. The velocity lags behind the heading by about that time; a card's
own delay is not used.
"""

import math
from typing import NamedTuple

from scipy.integrate import quad

from walkergen.core import InputError
from walkergen.guests.crowd.cards.card import Card

MAX_TURN_RAD = 50.0
"""Turn within the velocity's relaxation time, rad: above it an average has no correct digit left."""


class Motion(NamedTuple):
    """Forces and noise on a single walker, in mm, g and s."""

    mass: float
    inertia: float
    push: float
    """Force along the heading, g mm/s^2."""
    turn: float
    """Mean torque, g mm^2/s^2."""
    relaxation: float
    """Relaxation time tau of the velocity, s."""
    sideways_relaxation: float
    """Relaxation time of the velocity across the heading, s."""
    turning_relaxation: float
    """Relaxation time tau_r of the turning rate, s."""
    heat: float
    """Energy k T of the noise on the velocity, which has one size along and across, g mm^2/s^2."""
    spin_heat: float
    """Energy k T of the noise on the turning rate, D_R I/tau_r, g mm^2/s^2."""
    turning: float
    """Mean turning rate w0, rad/s."""

    @property
    def typical_speed_and_turning(self) -> tuple[float, float]:
        """Typical speed of the centre of mass (mm/s) and turning rate (rad/s): mean plus one standard deviation."""
        drive = abs(self.push) * self.relaxation / self.mass
        return (drive + math.sqrt(self.heat / self.mass), abs(self.turning) + math.sqrt(self.spin_heat / self.inertia))


def from_card(card: Card) -> Motion:
    """Compute the forces and noise that reproduce a card's numbers.

    Raises
    ------
    InputError
        If a relaxation time is zero, or if the walker turns too fast for a mean speed.
    """
    tau = _check_relaxation_time(card, "velocity_relaxation_s", card.velocity_relaxation_s.number)
    turn_time, side_time = card.turning_relaxation_s, card.sideways_relaxation_s
    tau_r = tau if turn_time is None else _check_relaxation_time(card, "turning_relaxation_s", turn_time.number)
    tau_s = tau if side_time is None else _check_relaxation_time(card, "sideways_relaxation_s", side_time.number)
    rotation, turning = card.rotational_diffusion_rad2_s.number, card.turning_rad_s.number
    # Of a steady turn the share along the heading is 1/(1 + w0^2 tau tau_s)
    drive = card.speed_mm_s.number / speed_ratio(tau, tau_r, rotation, turning * math.sqrt(tau_s / tau))
    diffusion = card.translational_diffusion_mm2_s.number / (0.5 + 0.5 * (tau_s / tau) ** 2)
    return Motion(
        mass=card.mass_g,
        inertia=card.inertia_g_mm2,
        push=card.mass_g * drive / tau,
        turn=card.inertia_g_mm2 * turning / tau_r,
        relaxation=tau,
        sideways_relaxation=tau_s,
        turning_relaxation=tau_r,
        heat=diffusion * card.mass_g / tau,
        spin_heat=rotation * card.inertia_g_mm2 / tau_r,
        turning=turning,
    )


def speed_ratio(tau: float, tau_r: float, rotation: float, turning: float) -> float:
    """Compute the mean speed along the heading over the speed V that the push alone would give.

    The velocity averages the headings of all times t ago, weighted by exp(-t/tau)/tau. The share of such a heading that
    is left is cos(w0 t) exp(-D_R (t - tau_r (1 - exp(-t/tau_r)))).

    Parameters
    ----------
    tau, tau_r : float
        Relaxation times of the velocity and of the turning rate, s.
    rotation : float
        Rotational diffusion D_R, rad^2/s.
    turning : float
        Mean turning rate w0, rad/s.

    Raises
    ------
    InputError
        If the walker turns too fast for that average.
    """

    def integrand(age_over_tau: float) -> float:
        """Return the weight of a past heading times the share of it that is left."""
        age = age_over_tau * tau
        loss = rotation * (age + tau_r * math.expm1(-age / tau_r))
        return math.exp(-age_over_tau - loss) * math.cos(turning * age)

    # Beyond 40 tau less than 1e-17 is remembered
    value, error, *_ = quad(integrand, 0.0, 40.0, limit=500, full_output=1)
    if abs(turning) * tau > MAX_TURN_RAD or not error < 1e-6:
        raise InputError(
            f"turning_rad_s = {turning:g}, rotational_diffusion_rad2_s = {rotation:g}: the walker turns too fast for a "
            f"mean speed, because its velocity lasts {tau:g} s. Use smaller values."
        )
    return float(value)


def _check_relaxation_time(card: Card, key: str, value: float) -> float:
    """Return a relaxation time. Raises InputError, naming the card and its key, if it is not > 0."""
    if value > 0.0:
        return value
    raise InputError(f"card {card.name!r}: {key}.value = {value:g}: must be > 0, because bodies have inertia.")
