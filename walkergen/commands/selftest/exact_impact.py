"""Impact law in exact rational arithmetic, as an independent check of the compiled law.

Velocities follow along the normal impulse from event to event (stop of the slip, end of
compression, end of the impact), as in docs/physics.md section 3, without rounding.
"""

from fractions import Fraction

Tensor = tuple[float, float, float]


def resolve_impact(
    H: Tensor, velocity: tuple[float, float], restitution: float, friction: float
) -> tuple[Fraction, Fraction, Fraction, Fraction]:
    """Return impulse (F_x, F_y) and velocity (v_x, v_y) after an impact by Poisson's law.

    `H`: inverse mass (xx, xy, yy). `velocity`: (v_x, v_y) before the impact.
    """
    xx, xy, yy = (Fraction(entry) for entry in H)
    v_x, v_y = (Fraction(component) for component in velocity)
    e, mu = Fraction(restitution), Fraction(friction)
    p = F_x = Fraction(0)
    p_end: Fraction | None = None
    while True:
        ratio = _impulse_ratio(xx, xy, v_x, mu)
        s_x, s_y = xy + ratio * xx, yy + ratio * xy
        steps = []
        if v_x != 0 and s_x * v_x < 0:
            steps.append((-v_x / s_x, "stop"))
        if v_y < 0 and s_y > 0:
            steps.append((-v_y / s_y, "compressed"))
        if v_y >= 0:
            assert p_end is not None
            steps.append((p_end - p, "end"))
        dp, event = min(steps)
        p, F_x, v_y = p + dp, F_x + ratio * dp, v_y + s_y * dp
        v_x = Fraction(0) if event == "stop" else v_x + s_x * dp
        if event == "compressed":
            p_end = (1 + e) * p
        if event == "end":
            return F_x, p, v_x, v_y


def _impulse_ratio(xx: Fraction, xy: Fraction, v_x: Fraction, mu: Fraction) -> Fraction:
    """Return F_x / F_y from inverse masses and slip. Friction opposes slip; at rest it is as large as necessary."""
    if v_x != 0:
        return -mu if v_x > 0 else mu
    if abs(xy) <= mu * xx:
        return -xy / xx
    return -mu if xy > 0 else mu
