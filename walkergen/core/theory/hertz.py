"""Hertzian contact of a foot's tip with the plate: its effective modulus, its stiffness, how deep a landing presses it.

A tip of effective radius R has the force K depth^1.5, K = 4/3 E* sqrt(R), 1/E* = (1 - nu^2)/E of foot and plate added
(Johnson, Contact Mechanics, 1985, equation 4.23).
"""

import math

from walkergen.core.scene import Scene
from walkergen.core.walker.spec import Material


def contact_modulus(scene: Scene, material: Material) -> float:
    """Return the effective modulus E* of foot and plate, Pa = g/(mm s^2)."""
    plate = scene.plate.elastic
    foot_compliance = (1.0 - material.poisson_ratio**2) / material.youngs_modulus
    return 1.0 / (foot_compliance + (1.0 - plate.poisson_ratio**2) / (1e9 * plate.youngs_modulus_gpa))


def tip_stiffness(scene: Scene, material: Material) -> float:
    """Return the Hertz stiffness K of a tip on the plate, g/(mm^0.5 s^2); infinite for rigid tips."""
    if scene.feet.rigid_tips:
        return math.inf
    return 4.0 / 3.0 * contact_modulus(scene, material) * math.sqrt(1e-3 * scene.feet.tip_radius_um)


def landing_depth(tip: float, mass: float, speed: float, load: float) -> float:
    """Compute how deep (mm) a tip is pressed by a landing mass or by a load at rest, whichever presses deeper.

    `tip` is its Hertz stiffness K. The mass (g) lands at a speed (mm/s), and the load is in g mm/s^2.
    """
    return float(max((1.25 * mass * speed * speed / tip) ** 0.4, (load / tip) ** (2.0 / 3.0)))
