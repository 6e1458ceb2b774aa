"""Request of the command `explain`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from walkergen import request
from walkergen.core.files.progress import Progress
from walkergen.request import Flag

if TYPE_CHECKING:
    from walkergen.files.report import Report


class ExplainRequest(request.Request):
    """List the effects that a scene requires, with their size, influence and cost.

    With --measure each effect is turned off, or on at its usual size, for ten seconds. The two largest are also
    changed together. The result has the change of the speed and of the CPU time, a picture, and the effects that can
    be left out.

    Examples
    --------
    >>> import walkergen as wg
    >>> effects = wg.explain("koumakis2016", "plane-noisy", cost=False).table
    >>> [row["effect"] for row in effects if row["on"]][:3]
    ['flexible foot tensor', 'leg compliance', 'sticking in impacts']
    """

    design: request.Walker = request.PAPER_WALKER
    scene: request.Home = None
    tilt: request.Tilt = None
    legs: request.Legs = None
    friction: request.Friction = None
    gamma: request.Gamma = None
    frequency: request.Frequency = None
    text: request.Text = None
    mirror: request.Mirror = None
    set: request.Settings = {}
    measure: Annotated[bool, Flag("Measure for 10 s what each effect changes, and draw it.")] = False
    cost: Annotated[bool, Flag("Measure the cost of each active effect.")] = True
    all: Annotated[bool, Flag("Print all effects with reasons.")] = False
    out: request.Out = None

    def run(self, progress: Progress) -> "Report":
        """Return the report of the scene's effects."""
        from walkergen.commands.explain import make
        from walkergen.core.walker import names

        given = self.inputs()
        design = given.single_member(self.design, self.tilt, self.legs)
        scene = given.scene(request.choose_scene(self.scene, [design]))
        default_folder = Path("out") / "explain" / f"{design.name}_{names.tilt_name(design)}_{design.kind}_{scene.name}"
        folder = self.output_folder(default_folder) if self.measure else self.out
        return make.explain(scene, design, progress, self.cost, self.measure, self.all, folder)
