"""Request of the command `movie`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from walkergen import request
from walkergen.core import Progress
from walkergen.request import Flag

if TYPE_CHECKING:
    from walkergen.files.report import Report


class MovieRequest(request.Request):
    """Film a walker in slow motion, or several tilts from above (GIF and MP4).

    A walker in a lane is seen in perspective, in slow motion. A walker on a plane, or several, are seen from above.
    Change this with --view.

    Examples
    --------
    >>> import walkergen as wg
    >>> film = wg.movie("koumakis2016", tilt=10, periods=0.2, slow=100, fps=20, out="film.gif")
    >>> film.files[0].name
    'film.gif'
    """

    design: request.Walker = request.PAPER_WALKER
    scene: request.Home = None
    tilt: request.Tilts = None
    legs: request.Kinds = None
    seconds: Annotated[float | None, Flag("Simulated time to show, s.", "S")] = None
    periods: Annotated[float | None, Flag("Time to show, in periods of the drive.", "N")] = None
    slow: Annotated[float | None, Flag("Play N times slower than real time.", "N")] = None
    view: Annotated[Literal["above", "perspective"] | None, Flag("View: above or perspective.", "VIEW")] = None
    fps: Annotated[int, Flag("Frames per second: 10, 20, 25 or 50.", "N")] = 25
    restitution: request.Restitution = None
    friction: request.Friction = None
    gamma: request.Gamma = None
    frequency: request.Frequency = None
    step: request.Step = None
    seed: request.Seed = None
    text: request.Text = None
    mirror: request.Mirror = None
    set: request.Settings = {}
    out: Annotated[
        Path | None, request.Target, Flag("GIF to write. The MP4 is written next to it.", "FILE", takes="Name | None")
    ] = None

    def run(self, progress: Progress) -> "Report":
        """Film the walkers."""
        report: Report = self.do_work(progress, self._expect)
        return report
