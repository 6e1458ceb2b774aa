"""Files for printing: binary STL and 3MF.

Equal input gives equal bytes: no clock, no random identifier, no time zone enters a file.
Both formats hold 32-bit floats, which resolve 1e-5 mm on a bed of 250 mm.
"""

import ctypes
import io
import re
import uuid
import zipfile
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any, NamedTuple
from xml.sax.saxutils import quoteattr

import numpy.typing as npt

from walkergen.core.errors import SolidError
from walkergen.core.shapes import stl, threemf
from walkergen.core.shapes.mesh import Mesh

APPLICATION = "walkergen"

PRUSASLICER_NAMESPACE = b'<model xmlns:slic3rpe="http://schemas.slic3r.org/3mf/2017/06" '
PRUSASLICER_VERSION = b'<metadata name="slic3rpe:Version3mf">1</metadata><resources>'

MODEL_FILE, CONTENT_TYPES_FILE = "3D/3dmodel.model", "[Content_Types].xml"
SETTINGS_FILE = "Metadata/model_settings.config"
"""File of Bambu Studio and OrcaSlicer that names objects and plates."""
PRUSA_SETTINGS_FILE = "Metadata/Slic3r_PE_model.config"
"""File of PrusaSlicer with settings of objects."""
ORCA_SUPPORTS = {"enable_support": "1", "support_on_build_plate_only": "1"}
PRUSA_SUPPORTS = {"support_material": "1", "support_material_buildplate_only": "1"}
"""Settings of an object with supports from the bed, which hold whatever the print settings say."""
CONFIG_TYPE = b'<Default Extension="config" ContentType="application/xml" />'

# What XML 1.0 cannot hold, escaped or not; tabs and line ends too, which attributes turn to blanks.
INVALID_XML = re.compile("[^\x20-\x7e\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


class Solid(NamedTuple):
    """Shape in a 3MF file, stored once however many copies are printed."""

    name: str
    mesh: Mesh
    supports: bool = False
    """Whether slicers are told to print it with supports from the bed."""


class Item(NamedTuple):
    """Printed copy of a solid."""

    solid: int
    """Index of the copy's solid in the list of solids."""
    part_number: str
    x: float
    """Left edge of the copy's bounding box, mm."""
    y: float
    """Front edge of the copy's bounding box, mm."""


def stl_bytes(mesh: Mesh, header: str) -> bytes:
    """Return the bytes of a binary STL file of a mesh in mm. They begin with "binary STL, mm: " and `header`."""
    return stl.pack(mesh.vertices[mesh.triangles], header)


def part_3mf(mesh: Mesh, name: str) -> bytes:
    """Return the bytes of a 3MF file of one part, in mm, with the corner of its bounding box at the origin."""
    return threemf_bytes([Solid(name, mesh)], [Item(0, name, 0.0, 0.0)], name)


def threemf_bytes(solids: Sequence[Solid], items: Sequence[Item], title: str, thumbnail: bytes | None = None) -> bytes:
    """Return the bytes of a 3MF file in mm: every solid once, and an item per printed copy, standing on z = 0.

    A copy whose part number is not its solid's name has an object of its own, which refers to the solid and bears the
    copy's name: Bambu Studio and OrcaSlicer list it, and the plate by `title`. Names may hold anything: what XML cannot
    is replaced by "_". UUIDs follow from the title, the names and the order. `thumbnail` is a PNG of the whole. Raises
    SolidError when lib3mf refuses a mesh. Source: 3MF core specification 1.3 and production extension (UUIDs).
    """
    wrapper = _lib3mf_wrapper()
    title = _xml_safe(title)
    model = wrapper.CreateModel()  # must outlive its objects and items: they point into it
    model.SetUnit(threemf.load_library().ModelUnit.MilliMeter)
    part_numbers = [_xml_safe(item.part_number) for item in items]
    model.SetBuildUUID(_make_uuid(title, "build", *part_numbers))
    metadata = model.GetMetaDataGroup()
    for key, value in (("Title", title), ("Application", APPLICATION)):
        metadata.AddMetaData("", key, value, "xs:string", True)
    meshes = [_add_solid(model, solid, title, number) for number, solid in enumerate(solids)]
    named: list[_NamedCopy] = []
    for number, (item, name) in enumerate(zip(items, part_numbers, strict=True)):
        shown_object, solid_name = meshes[item.solid], _xml_safe(solids[item.solid].name)
        if name != solid_name:
            mesh, shown_object = shown_object, _add_copy(model, shown_object, name, title, number)
            ids = shown_object.GetModelResourceID(), mesh.GetModelResourceID()
            named.append(_NamedCopy(name, solid_name, *ids, solids[item.solid]))
        transform = wrapper.GetTranslationTransform(item.x, item.y, 0.0)
        built = model.AddBuildItem(shown_object, transform)
        built.SetPartNumber(name)
        built.SetUUID(_make_uuid(title, "item", number))
    if thumbnail is not None:
        model.CreatePackageThumbnailAttachment().ReadFromBuffer(thumbnail)
    files = _unzip_files(bytes(model.QueryWriter("3mf").WriteToBuffer()))
    if named:
        files[SETTINGS_FILE] = _model_settings(named, title)
        if any(item.shape.supports for item in named):
            files[PRUSA_SETTINGS_FILE] = _prusa_settings(named)
        files[CONTENT_TYPES_FILE] = files[CONTENT_TYPES_FILE].replace(b"</Types>", CONFIG_TYPE + b"</Types>", 1)
    return _zip_files(files)


def declare_prusaslicer(data: bytes) -> bytes:
    """Return the bytes of a 3MF file, `data`, declared to be PrusaSlicer's own, so that it imports copies as copies.

    PrusaSlicer then lists each solid once with its copies, numbered from 0 in the order of the
    items, and slices it once. Of other files it makes an object of every item. It looks for its
    namespace by the prefix, which lib3mf does not let us choose. Measured with PrusaSlicer 2.5.
    """
    files = _unzip_files(data)
    model = files[MODEL_FILE].replace(b"<model ", PRUSASLICER_NAMESPACE, 1)
    files[MODEL_FILE] = model.replace(b"<resources>", PRUSASLICER_VERSION, 1)
    return _zip_files(files)


def _unzip_files(data: bytes) -> dict[str, bytes]:
    """Return the contents of the files in a ZIP archive, by name."""
    archive = zipfile.ZipFile(io.BytesIO(data))
    return {name: archive.read(name) for name in archive.namelist()}


def _zip_files(files: Mapping[str, bytes]) -> bytes:
    """Return a ZIP archive of files, all dated 1980-01-01: lib3mf writes a month 0, which no calendar has."""
    target = io.BytesIO()
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            entry = zipfile.ZipInfo(name)
            entry.create_system = 0  # the default names the operating system
            archive.writestr(entry, content, zipfile.ZIP_DEFLATED)
    return target.getvalue()


class _NamedCopy(NamedTuple):
    """Printed copy that has a name, and so an object, of its own in a 3MF file."""

    name: str
    solid: str
    """Name of its solid."""
    number: int
    """Number of its object in the file."""
    solid_number: int
    """Number of its solid's object in the file."""
    shape: Solid


def _prusa_settings(named: Sequence[_NamedCopy]) -> bytes:
    """Return the file from which PrusaSlicer reads that solids have supports. It lists their triangles as volumes."""
    lines = ['<?xml version="1.0" encoding="UTF-8"?>', "<config>"]
    for item in {item.solid_number: item for item in named if item.shape.supports}.values():
        lines.append(f' <object id="{item.solid_number}" instances_count="1">')
        for key, value in ({"name": item.solid} | PRUSA_SUPPORTS).items():
            lines.append(_metadata_element(key, value, ' type="object"'))
        lines.append(f'<volume firstid="0" lastid="{len(item.shape.mesh.triangles) - 1}">')
        lines += [_metadata_element("name", item.solid, ' type="volume"'), "</volume></object>"]
    return "\n".join([*lines, "</config>", ""]).encode()


def _model_settings(named: Sequence[_NamedCopy], title: str) -> bytes:
    """Return the XML from which Bambu Studio and OrcaSlicer read the names of copies and of their plate, `title`."""
    lines = ['<?xml version="1.0" encoding="UTF-8"?>', "<config>"]
    for item in named:
        supports = ORCA_SUPPORTS if item.shape.supports else {}
        lines += [
            f'  <object id="{item.number}">',
            *(f"    {_metadata_element(*pair)}" for pair in ({"name": item.name} | supports).items()),
            f'    <part id="{item.solid_number}" subtype="normal_part">',
            f"      {_metadata_element('name', item.solid)}",
            "    </part>",
            "  </object>",
        ]
    lines += [
        "  <plate>",
        *(
            f"    {_metadata_element(*pair)}"
            for pair in (("plater_id", "1"), ("plater_name", title), ("locked", "false"))
        ),
    ]
    for item in named:
        pairs = (("object_id", f"{item.number}"), ("instance_id", "0"))
        settings = "".join(_metadata_element(*pair) for pair in pairs)
        lines.append(f"    <model_instance>{settings}</model_instance>")
    return "\n".join([*lines, "  </plate>", "</config>", ""]).encode()


def _metadata_element(key: str, value: str, kind: str = "") -> str:
    return f"<metadata{kind} key={quoteattr(key)} value={quoteattr(value)}/>"


@cache
def _lib3mf_wrapper() -> Any:
    """Return the entry point of lib3mf, loaded once: it takes 10 ms."""
    return threemf.load_library().get_wrapper()


def _add_solid(model: Any, solid: Solid, title: str, number: int) -> Any:
    """Add a solid to a lib3mf model, its corner at the origin, and return the object. Raises SolidError.

    `title` of the file and `number` of the solid, from 0, make its UUID.
    """
    name = _xml_safe(solid.name)
    added = model.AddMeshObject()
    added.SetName(name)
    added.SetUUID(_make_uuid(title, "object", number, name))
    vertices, lib3mf = solid.mesh.vertices - solid.mesh.vertices.min(axis=0), threemf.load_library()
    try:
        added.SetGeometry(
            _to_structures(lib3mf.Position, vertices.astype("<f4")),
            _to_structures(lib3mf.Triangle, solid.mesh.triangles.astype("<u4")),
        )
    except lib3mf.ELib3MFException as error:
        raise SolidError(f"{name}: lib3mf refuses the mesh: {error}") from None
    return added


def _add_copy(model: Any, mesh: Any, name: str, title: str, number: int) -> Any:
    """Add an object to a lib3mf model that shows another object, `mesh`, under its own name, and return it.

    `title` of the file and `number` of the copy, from 0, make its UUIDs.
    """
    added = model.AddComponentsObject()
    added.SetName(name)
    added.SetUUID(_make_uuid(title, "copy", number, name))
    component = added.AddComponent(mesh, _lib3mf_wrapper().GetIdentityTransform())
    component.SetUUID(_make_uuid(title, "component", number, name))
    return added


def _to_structures(structure: type[ctypes.Structure], rows: npt.NDArray[Any]) -> Any:
    """Convert a NumPy array to a C array of structures, one per row, without a Python loop."""
    return (structure * len(rows)).from_buffer_copy(rows.tobytes())


def _make_uuid(*words: str | int) -> str:
    """Return a UUID that depends only on the words."""
    return str(uuid.uuid5(uuid.NAMESPACE_OID, "/".join(map(str, (APPLICATION, *words)))))


def _xml_safe(text: str) -> str:
    """Replace characters that XML cannot hold by "_"."""
    return INVALID_XML.sub("_", text)
