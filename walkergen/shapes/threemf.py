"""lib3mf, where it is made for the machine, and the reading of 3MF files by it.

Every printed item is read as it is placed, in mm.

trimesh reads 3MF too, but keeps one of several items that share object and part number.
"""

import importlib.util
import io
import platform
import xml.etree.ElementTree as ET
import zipfile
import zlib
from collections.abc import Iterator
from functools import cache
from typing import Any, Literal, NamedTuple
from xml.parsers import expat

import numpy as np
import numpy.typing as npt

from walkergen.errors import InputError

MM = (1e-3, 1.0, 10.0, 25.4, 304.8, 1000.0)
"""Millimetres of micron, millimetre, centimetre, inch, foot and metre: lib3mf's order of units."""

DEEPEST = 16
"""Most levels of components within components."""

MOST_PARTS = 10_000
"""Most meshes that a file may place: components within components multiply."""

MOST_TRIANGLES = 2_000_000
"""Largest number of triangles of a file of meshes: a million took 10 s and 0.7 GB to read and check,
on two busy cores (benchmarks/own_mesh.py)."""

Array = npt.NDArray[np.float64]

Role = Literal["model", "negative", "other"]

ROLES: dict[str, Role] = {
    "ModelPart": "model",
    "normal_part": "model",
    "NegativeVolume": "negative",
    "negative_part": "negative",
}
"""Roles of volumes in the words of PrusaSlicer, and of BambuStudio and OrcaSlicer; modifiers and
supports of all kinds are others, which no printer lays down."""

Volumes = dict[str, list[tuple[int, int, Role]]]
"""Roles of triangles by the number of their object: the first and the last of each volume."""


class Part(NamedTuple):
    """Surface in a file, as sound or unsound as it stands there."""

    name: str
    """Item's part number, or its object's name, or its place in the file."""
    vertices: Array
    """Corners in the file's own axes, shape (n, 3); mm for 3MF, else the file's own unit."""
    triangles: npt.NDArray[np.int64]
    """Corners of the triangles as indices into the vertices, shape (k, 3)."""
    role: Role = "model"
    """Whether it is printed, taken away from what is printed of its item, or neither."""
    item: int = 0
    """Number of the printed item that it belongs to."""


@cache
def available() -> bool:
    """True where lib3mf is installed; nobody makes it for Linux or Windows on ARM."""
    return importlib.util.find_spec("lib3mf") is not None


def library() -> Any:
    """Module lib3mf. Raises InputError where it is not installed."""
    if not available():
        raise InputError(
            "3MF: lib3mf is not installed (it is made for x86-64 and Macs, this is "
            f"{platform.system()} on {platform.machine()}): use STL; plates are STL files too"
        )
    import lib3mf

    return lib3mf


def read(data: bytes, source: str, most_triangles: int = MOST_TRIANGLES) -> list[Part]:
    """Meshes of all items, in the file's order, a part for each role that volumes of an item have.

    Raises InputError, beginning with `source`, for what is no 3MF, and before it is read for a file
    that places more than MOST_PARTS meshes or `most_triangles` triangles, counted as often as placed.
    """
    lib3mf = library()
    _count(data, source, most_triangles)
    volumes = _volumes(data)
    model = lib3mf.get_wrapper().CreateModel()  # must outlive its objects and items
    try:
        model.QueryReader("3mf").ReadFromBuffer(data)
        unit = MM[int(model.GetUnit())]
        items = model.GetBuildItems()
        parts: list[Part] = []
        number = 0
        while items.MoveNext():
            item = items.GetCurrent()
            resource = item.GetObjectResource()
            name = item.GetPartNumber() or resource.GetName() or f"item {number + 1}"
            meshes = _meshes(resource, name, [item], unit, source, volumes)
            parts += [part._replace(item=number) for part in meshes]
            number += 1
    except lib3mf.ELib3MFException as error:
        raise InputError(f"{source}: not a readable 3mf mesh: {str(error)[:120]}") from None
    return parts


class _Objects:
    """Objects of the models in an archive, by path and number, and what the builds place."""

    def __init__(self) -> None:
        self.components: dict[tuple[str, int], list[tuple[str, int]]] = {}
        self.triangles: dict[tuple[str, int], int] = {}
        self.items: list[tuple[str, int]] = []
        self._counts: dict[tuple[str, int], tuple[int, int]] = {}

    def parse(self, path: str, text: bytes) -> None:
        """Take in a model. Raises ExpatError where it is no XML, InputError for ids that are no numbers."""
        own = path, 0

        def begin(name: str, attributes: dict[str, str]) -> None:
            nonlocal own
            tag = name.rpartition(":")[2]
            if tag == "triangle":
                self.triangles[own] = self.triangles.get(own, 0) + 1
            elif tag == "object":
                own = path, _id(attributes.get("id", ""))
                self.components.setdefault(own, [])
            elif tag in ("component", "item"):
                paths = [v for key, v in attributes.items() if key.rpartition(":")[2] == "path"]
                place = (paths[0].lstrip("/") if paths else path, _id(attributes.get("objectid", "")))
                (self.components.setdefault(own, []) if tag == "component" else self.items).append(place)

        parser = expat.ParserCreate()
        parser.StartElementHandler = begin
        parser.Parse(text, True)

    def count(self, place: tuple[str, int], depth: int = 0) -> tuple[int, int]:
        """Number of meshes and of triangles of an object. Raises InputError for one too deep, or none."""
        if depth > DEEPEST:
            raise InputError(f"components lie more than {DEEPEST} deep; join them")
        if place not in self.components:
            raise InputError(f"places an object {place[1]} that it does not hold; export it anew")
        if place not in self._counts:
            inner = [self.count(part, depth + 1) for part in self.components[place]]
            parts = sum(parts for parts, _ in inner) or 1
            self._counts[place] = parts, sum(count for _, count in inner) + self.triangles.get(place, 0)
        return self._counts[place]


def _id(text: str) -> int:
    """Number that an id stands for, as readers of 3MF take it: " 1", "+1" and "01" are 1."""
    try:
        return int(text)
    except ValueError:
        raise InputError(f"has an id {text[:20]!r} that is no number; export it anew") from None


def _count(data: bytes, source: str, most_triangles: int) -> None:
    """Raise InputError for a file that places too much, which lib3mf would go through.

    What is no archive, or no XML, is left to lib3mf to refuse.
    """
    objects = _Objects()
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            models = {name: archive.read(name) for name in archive.namelist() if name.lower().endswith(".model")}
        for path, text in models.items():
            objects.parse(path, text)
        counts = [objects.count(place) for place in objects.items]
    except (zipfile.BadZipFile, zlib.error, OSError, NotImplementedError, RuntimeError, expat.ExpatError):
        return
    except InputError as error:
        raise InputError(f"{source}: {error}") from None
    if len(counts) > MOST_PARTS or sum(parts for parts, _ in counts) > MOST_PARTS:
        raise InputError(f"{source}: places more than {MOST_PARTS} meshes; join them into fewer")
    if (placed := sum(triangles for _, triangles in counts)) > most_triangles:
        raise InputError(f"{source}: places {placed} triangles, at most {most_triangles}; simplify the mesh")


def _volumes(data: bytes) -> Volumes:
    """Roles that slicers noted in the archive, by the number of the object that has the triangles.

    A slicer's notes that cannot be read say nothing: every triangle then is of the model.
    """
    volumes: Volumes = {}
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        for name in ("Metadata/Slic3r_PE_model.config", "Metadata/model_settings.config"):
            if name not in archive.namelist():
                continue
            try:
                root = ET.fromstring(archive.read(name))
            except ET.ParseError:
                continue
            for element in root.iter("object"):
                for volume in element.iter("volume"):
                    kinds = [each.get("value", "") for each in volume if each.get("key") == "volume_type"]
                    first, last = _id(volume.get("firstid", "0")), _id(volume.get("lastid", "-1"))
                    role = ROLES.get(kinds[0], "other") if kinds else "model"
                    volumes.setdefault(str(_id(element.get("id", "0"))), []).append((first, last, role))
                for part in element.iter("part"):
                    role = ROLES.get(part.get("subtype", "normal_part"), "other")
                    volumes[str(_id(part.get("id", "0")))] = [(0, -1, role)]
    return volumes


def _meshes(resource: Any, name: str, chain: list[Any], unit: float, source: str, volumes: Volumes) -> list[Part]:
    """Meshes of an object, or of its components, moved by all the transforms that lead to it."""
    if resource.IsMeshObject():
        # lib3mf gives lists of C structures, which join as the bytes that they are
        vertices = np.frombuffer(b"".join(resource.GetVertices()), "<f4").reshape(-1, 3)
        triangles = np.frombuffer(b"".join(resource.GetTriangleIndices()), "<u4").reshape(-1, 3)
        whole = _placed(name, vertices.astype(np.float64), triangles.astype(np.int64), chain, unit)
        if resource.GetType() != library().ObjectType.Model:
            return [whole._replace(role="other")]
        return list(_by_role(whole, volumes.get(str(resource.GetModelResourceID()), [])))
    if not resource.IsComponentsObject() or len(chain) > DEEPEST:
        raise InputError(f"{source}: {name[:40]!r} is no mesh; give triangles")
    parts = []
    for number in range(resource.GetComponentCount()):
        part = resource.GetComponent(number)
        parts += _meshes(part.GetObjectResource(), name, [*chain, part], unit, source, volumes)
    return parts


def _by_role(whole: Part, volumes: list[tuple[int, int, Role]]) -> Iterator[Part]:
    """Part of each role that triangles have; those that no volume names are of the model."""
    roles = np.full(len(whole.triangles), "model", dtype="<U8")
    for first, last, role in volumes:
        roles[first : last + 1 if last >= 0 else None] = role
    if (roles == "model").all():
        yield whole
        return
    for first, last, role in volumes:
        own = whole.triangles[first : last + 1 if last >= 0 else None]
        if role == "negative" and len(own):
            yield whole._replace(triangles=own, role=role)
    for role in ("model", "other"):
        if (roles == role).any():
            yield whole._replace(triangles=whole.triangles[roles == role], role=role)


def _placed(name: str, vertices: Array, triangles: npt.NDArray[np.int64], chain: list[Any], unit: float) -> Part:
    for step in reversed(chain):
        moved = step.GetObjectTransform() if hasattr(step, "GetObjectTransform") else (step.GetTransform())
        matrix = np.array([list(row) for row in moved.Fields], np.float64)
        vertices = vertices @ matrix[:3] + matrix[3]
        if np.linalg.det(matrix[:3]) < 0.0:  # a mirror image is turned inside out
            triangles = triangles[:, ::-1]
    return Part(name, unit * vertices, triangles)
