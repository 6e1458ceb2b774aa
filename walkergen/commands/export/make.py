"""Export of walkers as single files: meshes, drawings of walkers that are prisms, and models for MuJoCo."""

from collections.abc import Callable, Sequence
from pathlib import Path

from walkergen.commands.export import profile
from walkergen.core.errors import InputError
from walkergen.core.files import output
from walkergen.core.files.output import Folder
from walkergen.core.files.progress import Progress
from walkergen.core.printing import export
from walkergen.core.scene import Scene
from walkergen.core.shapes.mesh import Mesh
from walkergen.core.walker import names, solids
from walkergen.core.walker.design import Design
from walkergen.files.report import Report
from walkergen.readers.drawings.outlines import Polygon
from walkergen.readers.walkers import caps as tiles
from walkergen.sheets import cap_files

SOLID_FORMATS: dict[str, Callable[[Mesh, str], bytes]] = {"stl": export.stl_bytes, "3mf": export.part_3mf}
"""Functions that pack a mesh and a name, by format. Meshes are oriented as they are printed."""

FORMATS = (*SOLID_FORMATS, *profile.FORMATS)

MJCF = "mjcf"
"""MuJoCo's format of a walker in a scene, which consists of several files."""

MJCF_SUFFIX = ".xml"
"""Suffix of the main file of a model for MuJoCo, which refers to the mesh files."""


def make(
    members: Sequence[Design], formats: Sequence[str], folder: Path, progress: Progress, scene: Scene | None = None
) -> Report:
    """Write every member in every format as folder/FORMAT/NAME.FORMAT. Return the report of the files.

    MJCF of walkers in a scene is folder/mjcf/NAME.xml, with STL files in the same folder. Caps are separate parts:
    folder/FORMAT/NAME_cap07.FORMAT in the formats of meshes, and a sheet in folder/caps. Raises InputError, before
    anything is written, for a walker that has no drawing, and for a scene that MJCF cannot represent.
    """
    capped = cap_files.number_caps(members, [names.part_name(design) for design in members])
    of_caps = list(cap_files.files(capped, [])) if capped else []
    models = [_mjcf_files(design, scene) if MJCF in formats else [] for design in members]
    drawings = [
        profile.drawing_outlines(design) if any(form in profile.FORMATS for form in formats) else []
        for design in members
    ]
    written = []
    with Folder(folder, "") as target:
        for number, design in enumerate(members):
            name = names.part_name(design)
            mesh = solids.orient_for_print(design, solids.build(design).walker)
            drawn, model = drawings[number], models[number]
            for form in formats:
                for file, data in model if form == MJCF else [pack_walker(form, name, mesh, drawn)]:
                    target.write(f"{form}/{file}", data)
                    written.append(folder / form / file)
            progress(name, number + 1, len(members))
        for entry in capped:
            name = f"{entry.item}_cap{entry.cap.number:02d}"
            for form in sorted(SOLID_FORMATS.keys() & set(formats)) if entry.cap.kind != "paper" else ():
                file = f"{form}/{name}.{form}"
                target.write(file, SOLID_FORMATS[form](tiles.build_tile(entry.cap), name))
                written.append(folder / file)
        for file, data in of_caps:
            target.write(f"caps/{file}", data)
            written.append(folder / "caps" / file)
    return _report(written, cap_files.advice(capped) if capped else [])


def _report(files: Sequence[Path], lines: Sequence[str]) -> Report:
    """Make the report of the written files."""
    facts = {"files": [str(path) for path in files]}
    return Report(name="export", title="Exported walkers", tables=[], facts=facts, files=files, lines=lines)


def pack_walker(form: str, name: str, mesh: Mesh, drawing: Sequence[Polygon]) -> tuple[str, bytes]:
    """Return the name and the bytes of a walker's file: its mesh or its drawing in the format `form`."""
    data = SOLID_FORMATS[form](mesh, name) if form in SOLID_FORMATS else profile.FORMATS[form](drawing)
    return f"{name}.{form}", data


def _mjcf_files(design: Design, scene: Scene | None) -> list[tuple[str, bytes]]:
    """Return names and bytes of the files of a MuJoCo model of a walker in a scene. Raises InputError."""
    from walkergen.commands.export import mjcf

    assert scene is not None
    return list(mjcf.files(design, scene))


def write_one(design: Design, path: Path, scene: Scene | None = None) -> Report:
    """Write one walker to the file `path` with a suffix of FORMATS, or .xml for MuJoCo.

    The file is the same as that of `make`. `scene` applies only to MuJoCo, whose STL files are written to the same
    folder. Raises InputError for other suffixes, for a walker that has no drawing, and for a scene that MJCF cannot
    represent.
    """
    form = path.suffix.removeprefix(".").lower()
    if form in SOLID_FORMATS:
        mesh = solids.orient_for_print(design, solids.build(design).walker)
        output.write(path, SOLID_FORMATS[form](mesh, names.part_name(design)))
    elif form in profile.FORMATS:
        output.write(path, profile.FORMATS[form](profile.drawing_outlines(design)))
    elif path.suffix.lower() == MJCF_SUFFIX:
        (_, model), *meshes = _mjcf_files(design, scene)
        for name, data in meshes:
            output.write(path.with_name(name), data)
        output.write(path, model)  # last: it names the others
    else:
        endings = (*(f".{ending}" for ending in FORMATS), MJCF_SUFFIX)
        raise InputError(f"{str(path)!r}: {output.describe_wrong_ending(path, endings)}")
    return _report([path], [])
