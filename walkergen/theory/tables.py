"""Table of speeds in space that covers a walker in a scene, and its speeds at values of the inputs.

Shaken plates have one (`discrepancy`), motors another (`motors`). A motor that its own table does
not cover is taken as the plate that moves as far (`shaking`), if the plates' table covers that.
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.scene import Scene
from walkergen.theory import discrepancy, motors, shaking
from walkergen.theory.discrepancy import Found, Place, UnknownError
from walkergen.theory.motors import Ride
from walkergen.theory.uncertain import Drawn
from walkergen.walker.design import Design
from walkergen.walker.mass import MassProperties

Array = npt.NDArray[np.float64]


class Tabled(NamedTuple):
    """Walker in a scene that a table covers."""

    design: Design
    scene: Scene
    place: Place
    ride: Ride | None
    """What the table of motors knows beside; None for the table of plates."""
    swing: float
    """Peak speed (mm/s) over which the table has speeds: of the plate, or of the motor's swing."""
    amplitude: float
    """Amplitude of that swing, mm."""
    error_sd: float
    """Standard error of a plate in place of a motor, on the scale of `Prediction.model_sd`."""
    note: str
    """What such a plate leaves out, in words, and why it stands in."""

    def speeds(self, drawn: Drawn) -> Found:
        """Speeds over the swing's peak speed at values of the inputs."""
        places = self._places(drawn)
        if self.ride is None:
            return discrepancy.speeds(places, self.design.tilt_deg, self.design.braced)
        return motors.speeds(places, self.ride)

    @property
    def sense(self) -> float:
        """Sign that the mirror image has the other way: a walker's own has mirrored errors."""
        if self.ride is None:
            return math.copysign(1.0, self.design.tilt_deg)
        return math.copysign(1.0, float(motors.speeds(self.place, self.ride).centre[0]))

    def _places(self, drawn: Drawn) -> Place:
        pace, moment = of_motor(self.scene, drawn)
        design, scene, place = self.design, self.scene, self.place
        modulus = design.material.youngs_modulus_gpa
        unevenness = drawn.of("feet.unevenness_um", scene.feet.unevenness_um)
        return place.drawn(
            restitution=drawn.of("contact.restitution", float(place.restitution)),
            friction=drawn.of("contact.friction", scene.contact.friction),
            thickness=thickness(design, drawn),
            modulus=drawn.of("material.youngs_modulus_gpa", modulus) / modulus,
            body_mass=drawn.of("body mass", 1.0),
            leg_mass=leg_masses(design, drawn),
            unevenness=1e-3 * unevenness / (self.amplitude * moment),
        ).driven(pace, moment)


def of(scene: Scene, design: Design, mass: MassProperties) -> Tabled:
    """Table that covers a walker. Raises UnknownError, which says why, where none does."""
    reason = ""
    if scene.drive.kind == "motor":
        try:
            own = motors.of(scene, design, mass)
        except UnknownError as error:
            reason = str(error)
        else:
            return Tabled(design, scene, own.place, own.ride, own.swing, own.amplitude, 0.0, "")
    try:
        place = discrepancy.place_of(scene, design, mass)
        discrepancy.check(scene, place, design.braced)
    except UnknownError as error:
        raise UnknownError("; ".join(filter(None, (reason, str(error))))) from None
    shaken = shaking.of(scene, design, mass)
    note = f"{shaken.note} ({reason})" if reason else shaken.note
    return Tabled(design, scene, place, None, shaken.swing, shaken.drive.amplitude, shaken.error_sd, note)


def digests(scene: Scene) -> list[str]:
    """Hashes of the tables that a scene's predictions may rest on."""
    own = [motors.digest()] if scene.drive.kind == "motor" else []
    return [discrepancy.digest(), *own]


def of_motor(scene: Scene, drawn: Drawn) -> tuple[Array, Array]:
    """Ratios of a motor's drawn frequency and moment to its nominal ones."""
    drive = scene.drive
    if drive.kind == "plate":
        return np.ones(drawn.number), np.ones(drawn.number)
    pace = drawn.of(shaking.FREQUENCY, drive.frequency) / drive.frequency
    return pace, drawn.of(shaking.MOMENT, drive.eccentric) / drive.eccentric


def thickness(design: Design, drawn: Drawn) -> Array:
    """Ratios of a leg's drawn thickness to its nominal one."""
    nominal = design.limbs[0].thickness
    return drawn.of("legs.thickness_mm", nominal) / nominal


def leg_masses(design: Design, drawn: Drawn) -> Array:
    """Ratios of a leg's drawn mass to its nominal one, which go with its thickness unless a balance
    told the mass.
    """
    weighed = design.weighed.leg_mass_g is not None
    return drawn.of("leg mass", 1.0) * (1.0 if weighed else thickness(design, drawn))
