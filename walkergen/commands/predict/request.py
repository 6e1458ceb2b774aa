"""Request of the command `predict`."""

from typing import TYPE_CHECKING, Annotated, ClassVar

from walkergen import inputs, request
from walkergen.core.files.progress import Progress
from walkergen.request import Flag

if TYPE_CHECKING:
    from walkergen.commands.predict.make import PredictReport


class PredictRequest(request.Request):
    """Predict the speed of walkers, without writing any file.

    The table has the speed as designed, and the median and bounds for your print. Speeds come from a surrogate of the
    simulation. Outside its tested range they come from a simulation of a few seconds, which is cached. With
    --uncertain the report shows which input to measure next to narrow the bounds.
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
        report = make.predict(design, members, scene, self.mode, masses, self.uncertain, self.model, self.why, progress)
        return replace(report, warnings=[*report.warnings, *warnings])
