"""Request of the command `export`."""

import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from walkergen import inputs, print_fields, request
from walkergen.core.errors import InputError
from walkergen.core.files.progress import Progress
from walkergen.request import Flag

if TYPE_CHECKING:
    from walkergen.files.report import Report

FORMAT_HELP = (
    "File formats, such as stl,3mf. Solids: stl, 3mf. Drawings in mm: dxf, svg (side view of prisms, outline of bodies "
    "in plan view). MuJoCo: mjcf, the walker on its plate."
)

SUFFIX_PATTERN = re.compile(r"\.(?!\d+$)[A-Za-z0-9]{1,4}")
"""Suffix that distinguishes a file from a folder."""

Format = Literal["stl", "3mf", "dxf", "svg", "mjcf"]


class ExportRequest(request.Request):
    """Write walkers as STL, 3MF, DXF or SVG files, one file per walker, or for MuJoCo.

    Examples
    --------
    >>> import walkergen as wg
    >>> wg.export("koumakis2016", "walker.stl", tilt=10).files[0].name
    'walker.stl'
    """

    by_position: ClassVar = ("design", "out")

    design: request.Walker = request.PAPER_WALKER
    tilt: request.Tilts = None
    legs: request.Kinds = None
    format: Annotated[list[Format], request.Words, Flag(FORMAT_HELP, "FORMAT", takes="str | Iterable[str]")] = ["stl"]
    caps: print_fields.Caps = None
    scene: Annotated[
        Any,
        request.file_flag(
            "scenes",
            f"Scene of mjcf: a template or a TOML file. Default: {request.LANE_SCENE}, or {request.TABLE_SCENE} "
            "with a motor.",
            optional=True,
        ),
    ] = None
    text: request.Text = None
    mirror: request.Mirror = None
    set: request.Settings = {}
    sweep: Annotated[
        Path | None,
        request.File,
        Flag("Export the walker of every point of this sweep file.", "FILE", takes="Name | None"),
    ] = None
    out: Annotated[
        Path | None,
        request.Target,
        Flag(
            "Folder to write to, or a file whose suffix is the format; out/NAME by default.",
            "FOLDER",
            takes="Name | None",
        ),
    ] = None

    def run(self, progress: Progress) -> "Report":
        """Write the walkers."""
        from walkergen.commands.export import make

        single = self.out is not None and SUFFIX_PATTERN.fullmatch(self.out.suffix) is not None
        moving = self.out.suffix.lower() == make.MJCF_SUFFIX if self.out and single else make.MJCF in self.format
        if self.scene is not None and not moving:
            raise InputError(f"‹scene=›{str(self.scene)[:60]}: needs ‹format=›{make.MJCF}. Remove it.", "scene")
        if self.sweep is not None:
            from walkergen.commands.export import sweep_export

            self.check_unset("cannot be combined with ‹sweep›", "design", "tilt", "legs", "caps", "set")
            if single or moving:
                raise InputError("‹sweep›: writes only meshes and drawings. Give ‹format=›stl and a folder.", "sweep")
            return sweep_export.write(self.sweep, self.format, self.out, progress)
        given = self.inputs()
        if not moving:
            given.check_unset(given.keys_of("scene"), f"only ‹format=›{make.MJCF} uses a scene")
        design = given.design(self.design)
        scene = given.scene(request.choose_scene(self.scene, [design])) if moving else None
        members = inputs.add_caps(given.members(design, self.tilt, self.legs, whole=False), self.caps)
        if self.out is not None and single:
            self.check_unset(f"set by the suffix of {self.out}", "format", "caps")
            if len(members) > 1:
                raise InputError(
                    f"‹out=›{self.out}: is one file, but there are {len(members)} walkers. Give a folder.", "out"
                )
            return make.write_one(members[0], self.out, scene)
        return make.make(members, self.format, self.out or Path("out") / design.name, progress, scene)
