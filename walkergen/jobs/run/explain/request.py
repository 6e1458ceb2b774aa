"""What `explain` is asked for."""

from typing import TYPE_CHECKING, Annotated

from walkergen import request
from walkergen.files.progress import Progress
from walkergen.request import Flag

if TYPE_CHECKING:
    from walkergen.files.report import Report


class ExplainRequest(request.Request):
    """Say which effects a scene calls for, why, how large they are and what they cost."""

    design: request.Walker = request.PAPER
    scene: request.Ground = request.LANE
    tilt: request.Tilt = None
    legs: request.Legs = None
    model: request.Model = None
    friction: request.Friction = None
    gamma: request.Gamma = None
    frequency: request.Frequency = None
    text: request.Text = None
    mirror: request.Mirror = None
    set: request.Settings = {}
    cost: Annotated[bool, Flag("Measure the CPU time that each effect costs.")] = True

    def run(self, progress: Progress) -> "Report":
        """Explain the scene's effects."""
        from walkergen.jobs.run.explain import make

        given = self.inputs()
        scene, design = given.scene(self.scene), given.one(self.design, self.tilt, self.legs)
        return make.explain(scene, design, self.cost, progress)
