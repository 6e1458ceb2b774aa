"""Request of `fit`."""

from typing import TYPE_CHECKING

from walkergen.core.files.progress import Progress
from walkergen.guests.lab.fit.fields import FitFields

if TYPE_CHECKING:
    from walkergen.guests.lab.fit.report import FitReport


class FitRequest(FitFields):
    """Estimate the contact from measured speeds, and predict walkers that were not measured.

    The CSV file has columns tilt_deg, speed_mm_s and optionally speed_se_mm_s, legs (flexible or braced; otherwise the
    design's) and plate_speed_mm_s (otherwise the scene's). A row is one print, and its standard error is that of its
    film. Instead of a speed, a column tracks may name the tracks.csv of a film: a row for each of its walkers, or for
    the one in a column particle. By default the fit gives the contact that predictions use, in seconds. With the model
    space it fits emulators of simulations, with bounds for another print at every tilt. With the model theory it fits
    the paper's eq. 15 by least squares. The results are written to scene.toml and design.toml, for `walkergen family`.

    Notes
    -----
    The report names the parameters that the speeds hardly constrain.

    References
    ----------
    N. Koumakis, A. Gnoli, C. Maggi, A. Puglisi and R. Di Leonardo, "Mechanism of self-propulsion in 3D-printed active
    granular particles", New Journal of Physics 18 (2016) 113046, eq. 15 (the model theory).

    Examples
    --------
    >>> import walkergen as wg
    >>> with open("speeds.csv", "w") as file:
    ...     for row in "tilt_deg,speed_mm_s", "5,60", "10,62", "20,25", "30,8":
    ...         print(row, file=file)
    >>> fitted = wg.fit("speeds.csv", model="theory", fix={"restitution": 0.8}, pictures=False)
    >>> round(fitted.scene.contact.friction, 2)
    0.17
    """

    def run(self, progress: Progress) -> "FitReport":
        """Fit the model to the speeds, write the results, and return the report."""
        from walkergen.core.files import output
        from walkergen.guests.lab.fit import make
        from walkergen.guests.lab.report import Setup

        if self.model == "theory":
            self.check_unset("‹model=›theory does not use it", "predict", "prior", "seed")
        else:
            self.check_unset(f"applies only to ‹model=›theory, not to ‹model=›{self.model}", "mode")
        given = self.inputs()
        setup = Setup(given.design(self.design), given.scene(self.scene))
        return make.fit(self, setup, output.result_folder(self.speeds, self.out, "fit"), progress, self._expect)
