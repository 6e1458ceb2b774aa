"""Reading of 3MF files, and loading of lib3mf, which writes them, if it is available for the machine.

Every printed item is read at its position, in mm. The reader counts everything before it places anything:
lib3mf places components within components while it opens a file of 1 kB, for minutes, and trimesh keeps one of
several items that share object and part number.
"""

import importlib.util
import io
import platform
import zipfile
import zlib
from array import array
from collections.abc import Callable, Iterator
from functools import cache
from typing import Any, Literal, NamedTuple
from xml.parsers import expat

import numpy as np

from walkergen.core.errors import InputError
from walkergen.core.numerics import Array, Whole

UNITS_MM = {"micron": 1e-3, "millimeter": 1.0, "centimeter": 10.0, "inch": 25.4, "foot": 304.8, "meter": 1000.0}
"""Millimetres of the units that a model may have."""

CORE_NAMESPACE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02 "
"""Begins the names of the elements that are read; those of extensions are left out."""

MAX_DEPTH = 16
"""Most levels of components within components."""

MAX_PARTS = 10_000
"""Most meshes that a file may place, most components and most objects: components within components multiply."""

MAX_TRIANGLES = 2_000_000
"""Largest number of triangles of a file of meshes: a million took 10 s and 0.7 GB to read and check,
on two busy cores (benchmarks/own_mesh.py)."""

MAX_ELEMENTS_PER_TRIANGLE = 8
"""Most elements of XML for every triangle that is allowed: corners, colours, textures."""

Attributes = dict[str, str]
ObjectKey = tuple[str, int]
"""Path of a model in an archive, in small letters, and the number of an object in it."""

Role = Literal["model", "negative", "other"]

ROLES: dict[str, Role] = {
    "ModelPart": "model",
    "normal_part": "model",
    "NegativeVolume": "negative",
    "negative_part": "negative",
}
"""Roles of volumes in the words of PrusaSlicer, and of BambuStudio and OrcaSlicer; modifiers and
supports of all kinds are others, which no printer lays down."""

UNPRINTED_SETTINGS = ("anti_overhang_mesh", "cutting_mesh", "infill_mesh", "support_mesh")
"""Settings of Cura that make an object change how others print; it is not printed itself."""

KNOWN_EXTENSIONS = ("material/2015/02", "production/2015/06", "slice/2015/07", "trianglesets/2021/07")
"""Ends of the addresses of extensions that a file may require: colours, paths, slices that are refused, and names."""

SLICER_NOTE_FILES = ("metadata/slic3r_pe_model.config", "metadata/model_settings.config")
"""Files where slicers note the roles."""

Volumes = dict[int, list[tuple[int, int, Role]]]
"""Roles of triangles by the number of their object: the first and the last of each volume."""

READ_ERRORS = (
    *(zipfile.BadZipFile, zlib.error, expat.ExpatError, OSError),
    *(EOFError, KeyError, NotImplementedError, RuntimeError, ValueError),
)
"""Errors of reading: no archive, no XML, a missing attribute, or text instead of a number."""


class Part(NamedTuple):
    """Triangle mesh as a file contains it, which may be faulty."""

    name: str
    """Item's part number, or its object's name, or its place in the file."""
    vertices: Array
    """Corners in the file's own axes, shape (n, 3); mm for 3MF, else the file's own unit."""
    triangles: Whole
    """Corners of the triangles as indices into the vertices, shape (k, 3)."""
    role: Role = "model"
    """Whether the mesh is printed ("model"), cut out of the printed meshes of its item ("negative"), or neither."""
    item: int = 0
    """Number of the printed item that it belongs to."""


@cache
def is_available() -> bool:
    """Return whether lib3mf is installed. It does not exist for Linux or Windows on ARM."""
    return importlib.util.find_spec("lib3mf") is not None


def load_library() -> Any:
    """Import lib3mf. Raises InputError if it is not installed."""
    if not is_available():
        raise InputError(
            "3MF: lib3mf is not installed (it is made for x86-64 and Macs, this is "
            f"{platform.system()} on {platform.machine()}): use STL; plates are STL files too"
        )
    import lib3mf

    return lib3mf


def read_parts(data: bytes, source: str, most_triangles: int = MAX_TRIANGLES) -> list[Part]:
    """Read the meshes of all items, in the file's order. An item has a part for each role of its volumes.

    Raises InputError, whose message begins with `source`, for what is no 3MF, and for a file that places more than
    MAX_PARTS meshes or `most_triangles` triangles, counted as often as placed.
    """
    package = _Package(most_triangles)
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            package.read_archive(archive)
        package.check_limits()
        return list(package.parts())
    except InputError as error:
        raise InputError(f"{source}: {error}") from None
    except READ_ERRORS as error:
        raise InputError(f"{source}: not a readable 3mf mesh: {str(error)[:120]}") from None


class _Placement(NamedTuple):
    """Reference of an item or a component to an object, with the position where it puts the object."""

    object: ObjectKey
    name: str
    transform: Array
    """Matrix (3 rows) above the shift (1 row), shape (4, 3): a corner, as a row, becomes corner @ matrix + shift."""
    printed: bool
    """False for an item that a user has switched off."""


class _Object(NamedTuple):
    """Object of a model: a mesh, or components, which refer to other objects."""

    name: str
    printed: bool
    sliced: bool
    """Whether slices give its shape, so that its mesh may be a stand-in."""
    corners: "array[float]"
    triangles: "array[int]"
    components: list[_Placement]


class _Package:
    """Contents of a 3MF archive: the `objects` of its models, the printed `items`, and the roles of `volumes`."""

    def __init__(self, most_triangles: int) -> None:
        self.most_triangles = most_triangles
        self.objects: dict[ObjectKey, _Object] = {}
        self.items: list[_Placement] = []
        self.volumes: Volumes = {}
        self.unit = "millimeter"
        self._prefixes: dict[str | None, str] = {}
        self._elements = 0
        self._counts: dict[ObjectKey, tuple[int, int]] = {}

    def read_archive(self, archive: zipfile.ZipFile) -> None:
        """Read from an archive its main model, the models to which it refers, and the slicers' roles of volumes."""
        names = {name.lstrip("/").lower(): name for name in archive.namelist()}
        targets = ["3d/3dmodel.model"]

        def read_relationship(tag: str, attributes: Attributes) -> None:
            """Set the path of the main model if the element names it."""
            if tag.endswith("Relationship") and attributes.get("Type", "").endswith("/3dmodel"):
                targets[0] = attributes.get("Target", "").lstrip("/").lower()

        if "_rels/.rels" in names:
            self._parse_xml(archive, names["_rels/.rels"], read_relationship)
        root = targets[0]
        for path in targets:  # grows while it is read
            if path not in names:
                raise InputError(f"refers to {path[:60]!r}, which it does not hold. Export the file again")
            self._parse_xml(archive, names[path], *self._model_handlers(path, path == root))
            objects_of_model = [key for key in self.objects if key[0] == path]
            placed = [part for key in objects_of_model for part in self.objects[key].components]
            used_paths = {part.object[0] for part in [*placed, *(self.items if path == root else [])]}
            targets += sorted(used_paths - {*targets})
        for path in SLICER_NOTE_FILES:
            if path in names:
                try:
                    self._parse_xml(archive, names[path], self._note_handler())
                except expat.ExpatError:  # notes that cannot be read say nothing
                    self.volumes.clear()

    def _parse_xml(
        self,
        archive: zipfile.ZipFile,
        name: str,
        begin: Callable[[str, Attributes], None],
        text: Callable[[str], None] | None = None,
    ) -> None:
        """Parse a file, calling `begin` with the tag and attributes of each element, and `text` with each text.

        Raises ExpatError, and InputError for too many elements.
        """
        max_elements = MAX_ELEMENTS_PER_TRIANGLE * self.most_triangles + MAX_PARTS

        def begin_counted(tag: str, attributes: Attributes) -> None:
            """Count an element and pass it on. Raises InputError for too many."""
            self._elements += 1
            if self._elements > max_elements:
                raise InputError(f"has more than {max_elements} elements; simplify the mesh")
            begin(tag, attributes)

        def refuse_document_type(*_: object) -> None:
            raise InputError("has a document type, which no 3MF may have. Export the file again")

        parser = expat.ParserCreate(namespace_separator=" ")
        parser.StartElementHandler = begin_counted
        parser.StartDoctypeDeclHandler = refuse_document_type
        parser.StartNamespaceDeclHandler = self._prefixes.__setitem__
        parser.CharacterDataHandler = text
        parser.ParseFile(archive.open(name))

    def _model_handlers(self, path: str, root: bool) -> tuple[Callable[[str, Attributes], None], Callable[[str], None]]:
        """Return functions that parse elements and texts of the model at `path`. `root`: whether it is the main one."""
        vertex, triangle = CORE_NAMESPACE + "vertex", CORE_NAMESPACE + "triangle"
        current, setting, object_key = _new_object({}), "", (path, 0)

        def begin(tag: str, attributes: Attributes) -> None:
            """Store a vertex, triangle, object, component or item. Raises InputError for what cannot be read."""
            nonlocal current, setting, object_key
            setting = ""
            if tag == triangle:
                current.triangles.extend([int(attributes[key]) for key in ("v1", "v2", "v3")])
                if len(current.triangles) > 3 * self.most_triangles:
                    raise InputError(f"holds more than {self.most_triangles} triangles; simplify the mesh")
            elif tag == vertex:
                current.corners.extend([float(attributes[key]) for key in "xyz"])
            elif tag == CORE_NAMESPACE + "object":
                current, object_key = _new_object(attributes), (path, int(attributes["id"]))
                if object_key in self.objects or len(self.objects) >= MAX_PARTS:
                    raise InputError(
                        f"holds two objects {object_key[1]}. Export the file again"
                        if object_key in self.objects
                        else f"holds more than {MAX_PARTS} objects; join them into fewer"
                    )
                self.objects[object_key] = current
            elif tag == CORE_NAMESPACE + "component":
                current.components.append(_parse_placement(attributes, path))
            elif tag == CORE_NAMESPACE + "item" and root:
                self.items.append(_parse_placement(attributes, path))
            elif tag == CORE_NAMESPACE + "model":
                self._read_model_settings(attributes, path, root)
            elif tag.endswith((" metadata", " setting")):
                setting = attributes.get("name", attributes.get("key", "")).rpartition(":")[2]
            elif tag.endswith(" beam"):
                raise InputError("holds a lattice of beams, which is no mesh. Export it as triangles")

        def text(words: str) -> None:
            """Mark the current object as not printed if the text switches on a setting of UNPRINTED_SETTINGS."""
            if setting in UNPRINTED_SETTINGS and words.strip().lower() == "true" and object_key in self.objects:
                self.objects[object_key] = self.objects[object_key]._replace(printed=False)

        return begin, text

    def _read_model_settings(self, attributes: Attributes, path: str, root: bool) -> None:
        """Read the unit in a model's attributes. Raises InputError for another unit, and for unsupported extensions."""
        unit = attributes.get("unit", "millimeter" if root else self.unit)
        if root:
            self.unit = unit
        elif unit != self.unit:
            raise InputError(f"{path[:60]!r} is in {unit[:20]}, the model that places it in {self.unit[:20]}")
        for prefix in attributes.get("requiredextensions", "").split():
            space = self._prefixes.get(prefix, prefix)
            if not space.endswith(tuple(f"/3dmanufacturing/{name}" for name in KNOWN_EXTENSIONS)):
                raise InputError(f"requires {space[:90]!r}, which walkergen does not read. Export plain meshes")

    def _note_handler(self) -> Callable[[str, Attributes], None]:
        """Return a function that stores the roles of triangles in `volumes`, from each element of a slicer's notes."""
        number = 0

        def begin(tag: str, attributes: Attributes) -> None:
            """Store the role of the triangles that an element describes."""
            nonlocal number
            volumes = self.volumes.setdefault(number, [])
            if tag == "object":
                number = int(attributes.get("id", 0))
            elif tag == "volume":
                volumes.append((int(attributes.get("firstid", 0)), int(attributes.get("lastid", -1)), "model"))
            elif tag == "metadata" and attributes.get("key") == "volume_type" and volumes:
                volumes[-1] = (*volumes[-1][:2], ROLES.get(attributes.get("value", ""), "other"))
            elif (
                tag == "metadata" and attributes.get("key") == "modifier" and attributes.get("value") == "1" and volumes
            ):
                volumes[-1] = (*volumes[-1][:2], "other")  # as older slicers write it
            elif tag == "part":
                role = ROLES.get(attributes.get("subtype", "normal_part"), "other")
                self.volumes[int(attributes.get("id", 0))] = [(0, -1, role)]

        return begin

    def check_limits(self) -> None:
        """Raise InputError if the package places too many meshes or triangles, or an object that it does not hold."""
        if self.unit not in UNITS_MM:
            raise InputError(f"has the unit {self.unit[:20]!r}: must be one of {', '.join(UNITS_MM)}")
        counts = [self._count_meshes(item.object, 0) for item in self.items]
        if sum(parts for parts, _ in counts) > MAX_PARTS:
            raise InputError(f"places more than {MAX_PARTS} meshes; join them into fewer")
        if (triangles := sum(triangles for _, triangles in counts)) > self.most_triangles:
            raise InputError(f"places {triangles} triangles, at most {self.most_triangles}; simplify the mesh")

    def _count_meshes(self, object_key: ObjectKey, depth: int) -> tuple[int, int]:
        """Return the numbers of meshes and of triangles in an object, which is `depth` components below an item."""
        if depth > MAX_DEPTH:
            raise InputError(f"components lie more than {MAX_DEPTH} deep; join them")
        if object_key not in self.objects:
            raise InputError(f"places an object {object_key[1]} that it does not hold. Export the file again")
        if object_key not in self._counts:
            counted = self.objects[object_key]
            inner = [self._count_meshes(part.object, depth + 1) for part in counted.components]
            if counted.sliced or not (inner or len(counted.triangles)):
                what = "is given by slices, its mesh may be a stand-in" if counted.sliced else "is no mesh"
                raise InputError(f"object {object_key[1]} {counted.name[:40]!r} {what}. Give triangles")
            parts = sum(parts for parts, _ in inner) or 1
            self._counts[object_key] = parts, sum(count for _, count in inner) + len(counted.triangles) // 3
        return self._counts[object_key]

    def parts(self) -> Iterator[Part]:
        """Yield the meshes of all items, in their order, mm. A mesh is split if its triangles have several roles."""
        for number, item in enumerate(self.items):
            name = item.name or self.objects[item.object].name or f"item {number + 1}"
            for part, volumes in self._place_meshes(item.object, [item.transform]):
                # BambuStudio marks an object as not printed if one of its volumes is negative
                has_negative = any(volume_role == "negative" for *_, volume_role in volumes)
                printed_role: Role = "model" if has_negative else part.role
                role = printed_role if item.printed else "other"
                placed = part._replace(name=name, role=role, item=number, vertices=UNITS_MM[self.unit] * part.vertices)
                yield from _split_by_role(placed, volumes) if role == "model" else [placed]

    def _place_meshes(
        self, object_key: ObjectKey, transforms: list[Array]
    ) -> Iterator[tuple[Part, list[tuple[int, int, Role]]]]:
        """Yield an object's meshes, moved by all transforms, and the first and last triangle and role of each volume.

        `transforms`, shape (4, 3) each, are in the order from the item to the object. The last one applies first.
        """
        placed = self.objects[object_key]
        for part in placed.components:
            yield from self._place_meshes(part.object, [*transforms, part.transform])
        if not len(placed.triangles):
            return
        vertices = np.array(placed.corners).reshape(-1, 3)
        triangles = np.array(placed.triangles, np.int64).reshape(-1, 3)
        for transform in reversed(transforms):
            vertices = vertices @ transform[:3] + transform[3]
            if np.linalg.det(transform[:3]) < 0.0:  # a mirror image is turned inside out
                triangles = triangles[:, ::-1]
        yield Part("", vertices, triangles, "model" if placed.printed else "other"), self.volumes.get(object_key[1], [])


def _new_object(attributes: Attributes) -> _Object:
    """Return an empty object with the name and type in an element's attributes."""
    printed = attributes.get("type", "model") == "model"
    extras = {name.rpartition(" ")[2]: value for name, value in attributes.items()}
    sliced = "slicestackid" in extras and extras.get("meshresolution") != "fullres"  # a stand-in, in official samples
    return _Object(attributes.get("name", ""), printed, sliced, array("d"), array("q"), [])


def _parse_placement(attributes: Attributes, path: str) -> _Placement:
    """Parse the reference of an item or a component to an object: in the model at `path`, or at the path it states."""
    paths = [value for name, value in attributes.items() if name.endswith(" path")]
    object_key = (paths[0].lstrip("/").lower() if paths else path), int(attributes["objectid"])
    numbers = [float(word) for word in attributes.get("transform", "1 0 0 0 1 0 0 0 1 0 0 0").split()]
    printed = attributes.get("printable", "1").strip() not in ("0", "false")
    return _Placement(object_key, attributes.get("partnumber", ""), np.array(numbers).reshape(4, 3), printed)


def _split_by_role(part: Part, volumes: list[tuple[int, int, Role]]) -> Iterator[Part]:
    """Yield a mesh in pieces, one for each role of its triangles. Triangles outside all volumes belong to the model.

    `volumes` has the first and last triangle and the role of each. Raises InputError if they share triangles.
    """
    spans = [(slice(first, last + 1 if last >= 0 else None), role) for first, last, role in volumes]
    count = len(part.triangles)
    if sum(len(range(count)[span]) for span, _ in spans) > count:
        raise InputError(f"{part.name[:40]!r}: its volumes share triangles. Export the file again")
    roles = np.full(count, "model", dtype="<U8")
    for span, role in spans:
        roles[span] = role
    if (roles == "model").all():
        yield part
        return
    for span, role in spans:
        if role == "negative" and len(part.triangles[span]):
            yield part._replace(triangles=part.triangles[span], role=role)
    for role in ("model", "other"):
        if (roles == role).any():
            yield part._replace(triangles=part.triangles[roles == role], role=role)
