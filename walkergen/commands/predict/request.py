"""Request of the command `predict`."""

from typing import TYPE_CHECKING, Annotated, ClassVar

from walkergen import inputs, request
from walkergen.core.files.progress import Progress
from walkergen.request import Flag

if TYPE_CHECKING:
    from walkergen.commands.predict.make import PredictReport


class PredictRequest(request.Request):
    """Predict the speed of walkers, without writing any file.

    The result has the speed as designed, and the speed of your print with bounds. It comes from the surrogate of the
    model in space where its error is small, otherwise from a simulation of seconds, which is cached. To narrow the
    bounds, --uncertain names the input of each walker to measure next.

    Notes
    -----
    The surrogate is used where its error is at most 10 % or 1 mm/s, inside the ranges of its training set
    (docs/physics.md section 4). Bounds contain the contact, the print, the masses and a structural error of the model,
    10 % of the speed by default.

    References
    ----------
    N. Koumakis, A. Gnoli, C. Maggi, A. Puglisi and R. Di Leonardo, "Mechanism of self-propulsion in 3D-printed active
    granular particles", New Journal of Physics 18 (2016) 113046, eq. 15 (the theory's speed).

    Examples
    --------
    >>> import walkergen as wg
    >>> print(wg.predict(tilt=10).speed)
    51 ± 11 mm/s, with 95 % 33.6 to 73.8
    """

    by_position: ClassVar = ("design", "scene", "tilt")

    design: request.Walker = request.PAPER_WALKER
    tilt: request.Tilts = None
    legs: request.Kinds = None
    scene: request.Home = None
    restitution: request.Restitution = None
    friction: request.Friction = None
    gamma: request.Gamma = None
    frequency: request.Frequency = None
    mode: request.Mode = "coulomb"
    text: request.Text = None
    mirror: request.Mirror = None
    set: request.Settings = {}
    weights: request.Weights = None
    uncertain: request.Uncertain = False
    model: request.Predicted = "best"
    why: Annotated[bool, Flag("Explain the sources of the speeds, and why a walker was simulated.")] = False

    def run(self, progress: Progress) -> "PredictReport":
        """Predict the walkers."""
        from dataclasses import replace

        from walkergen.commands.predict import make

        given = self.inputs()
        design = given.design(self.design)
        scene = given.scene(request.choose_scene(self.scene, [design]))
        members = given.members(design, self.tilt, self.legs, whole=False)
        masses, warnings = inputs.read_masses(self.weights, members)
        report = make.predict(
            *(design, members, scene, self.mode, masses, self.uncertain, self.model, self.why, progress),
            expect=self._expect,
        )
        return replace(report, warnings=[*report.warnings, *warnings])
