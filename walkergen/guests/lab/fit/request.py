"""Request of `fit`."""

from typing import TYPE_CHECKING

from walkergen.core.files.progress import Progress
from walkergen.guests.lab.fit.fields import FitFields

if TYPE_CHECKING:
    from walkergen.guests.lab.fit.report import FitReport


class FitRequest(FitFields):
    """Estimate the contact from measured speeds, and predict walkers that were not measured.

    The CSV file has columns tilt_deg, speed_mm_s and, if known, speed_se_mm_s, legs (flexible or braced; otherwise the
    design's) and plate_speed_mm_s (otherwise the scene's). A row is one print, its standard error that of its film. In
    place of a speed, a column tracks may name the tracks.csv of a film: a row for each of its walkers, or for the one
    in a column particle. By default the fit takes seconds and uses the model of `predict`. A simulated model is fitted
    with emulators. Both give bands for one more print at every tilt. The theory, the paper's eq. 15, is fitted by least
    squares. All write scene.toml and design.toml for `walkergen family`.
    """

    def run(self, progress: Progress) -> "FitReport":
        """Fit, and write the results."""
        from walkergen.core.files import output
        from walkergen.guests.lab.fit import make
        from walkergen.guests.lab.report import Setup

        if self.model == "theory":
            self.check_unset("‹model=›theory has none", "predict", "prior", "seed")
        else:
            self.check_unset(f"a mode of the theory; ‹model=›{self.model} has none", "mode")
        given = self.inputs()
        setup = Setup(given.design(self.design), given.scene(self.scene))
        return make.fit(self, setup, output.result_folder(self.speeds, self.out, "fit"), progress, self._expect)
