"""Request of the command `app`."""

from pathlib import Path
from typing import Annotated, ClassVar

from pydantic import Field

from walkergen import request
from walkergen.core.files.progress import Progress
from walkergen.request import Flag

FOLDER = Path("out") / "app"
"""Folder of all files that pages write."""


class AppRequest(request.Request):
    """Design a walker on a page in the browser: change its tilt, see how it runs, download its files.

    The page is served by this machine, only for this machine, and works without a network. Ctrl-C stops it.
    """

    reports: ClassVar = False

    design: request.Walker = request.PAPER_WALKER
    scene: request.Home = None
    printer: request.Machine = request.DEFAULT_PRINTER
    text: request.Text = None
    mirror: request.Mirror = None
    set: request.Settings = {}
    port: Annotated[int, Field(ge=0, le=65535), Flag("Port; 0 chooses a free one.", "N")] = 8765
    host: Annotated[str, Flag("Address of this machine, for access from other devices.", "ADDRESS")] = "127.0.0.1"
    browser: Annotated[bool, Flag("Open the page in a browser.")] = True

    def run(self, progress: Progress) -> None:
        """Serve pages until Ctrl-C."""
        from walkergen.app import server_process
        from walkergen.app.document import Document

        given = self.inputs()
        scene = request.choose_scene(self.scene, [given.design(self.design)])
        given.scene(scene), given.printer(self.printer)
        document = Document(self.design, scene, self.printer, given.values)
        changed = document != Document(request.PAPER_WALKER, request.LANE_SCENE, request.DEFAULT_PRINTER, {})
        server_process.serve(document, changed, FOLDER, self.host, self.port, self.browser)
