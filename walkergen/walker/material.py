"""What a walker is printed of, and what a balance says of it."""

from typing import Annotated

from pydantic import Field

from walkergen.files.config import Section

MassGram = Annotated[float, Field(ge=1e-15, le=1e12)]


class Material(Section):
    """Material that a walker is printed of, with solid infill.

    Its temperatures are PLA's, and only go into the settings of who has no profile of the filament:
    Prusament PLA's maker states 210 +- 10 C and a bed of 40 to 60 C.
    """

    density_g_cm3: Annotated[float, Field(ge=1e-3, le=100)] = 1.24
    youngs_modulus_gpa: Annotated[float, Field(ge=1e-6, le=1e4)] = 3.0
    youngs_modulus_sd_gpa: Annotated[float, Field(ge=0, le=1e4)] = 0.35
    poisson_ratio: Annotated[float, Field(ge=0, le=0.5)] = 0.36
    """Poisson's ratio; PLA's."""
    nozzle_deg_c: Annotated[int, Field(ge=100, le=500)] = 210
    bed_deg_c: Annotated[int, Field(ge=0, le=200)] = 60
    """Temperature of the bed; 0: it is not heated."""

    @property
    def youngs_modulus(self) -> float:
        """Young's modulus, Pa = g/(mm s^2)."""
        return 1e9 * self.youngs_modulus_gpa


class Weighed(Section):
    """Masses from a balance, which override the mesh's, and the spread of masses."""

    body_mass_g: MassGram | None = None
    leg_mass_g: MassGram | None = None
    mass_sd_percent: Annotated[float, Field(ge=0, le=50)] = 2.0

    @property
    def states(self) -> bool:
        """Whether it has masses that come before those that are drawn."""
        return self.body_mass_g is not None or self.leg_mass_g is not None
