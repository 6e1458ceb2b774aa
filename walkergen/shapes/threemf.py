"""lib3mf, where it is made for the machine, and the reading of 3MF files by it.

Every printed item is read as it is placed, in mm.

trimesh reads 3MF too, but keeps one of several items that share object and part number.
"""

import importlib.util
import io
import platform
import zipfile
import zlib
from functools import cache
from typing import Any, NamedTuple
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

Array = npt.NDArray[np.float64]


class Part(NamedTuple):
    """Surface in a file, as sound or unsound as it stands there."""

    name: str
    """Item's part number, or its object's name, or its place in the file."""
    vertices: Array
    """Corners in the file's own axes, shape (n, 3); mm for 3MF, else the file's own unit."""
    triangles: npt.NDArray[np.int64]
    """Corners of the triangles as indices into the vertices, shape (k, 3)."""


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


def read(data: bytes, source: str) -> list[Part]:
    """Meshes of all items, in the file's order. Raises InputError, beginning with `source`."""
    lib3mf = library()
    _count(data, source)
    model = lib3mf.get_wrapper().CreateModel()  # must outlive its objects and items
    try:
        model.QueryReader("3mf").ReadFromBuffer(data)
        unit = MM[int(model.GetUnit())]
        items = model.GetBuildItems()
        parts: list[Part] = []
        while items.MoveNext():
            item = items.GetCurrent()
            resource = item.GetObjectResource()
            name = item.GetPartNumber() or resource.GetName() or f"item {len(parts) + 1}"
            parts += _meshes(resource, name, [item], unit, source)
    except lib3mf.ELib3MFException as error:
        raise InputError(f"{source}: not a readable 3mf mesh: {str(error)[:120]}") from None
    return parts


class _Objects:
    """Objects of the models in an archive, by path and number, and what the builds place."""

    def __init__(self) -> None:
        self.components: dict[tuple[str, str], list[tuple[str, str]]] = {}
        self.items: list[tuple[str, str]] = []
        self._counts: dict[tuple[str, str], int] = {}

    def parse(self, path: str, text: bytes) -> None:
        """Take in a model. Raises ExpatError where it is no XML."""
        own: list[tuple[str, str]] = []

        def begin(name: str, attributes: dict[str, str]) -> None:
            nonlocal own
            tag = name.rpartition(":")[2]
            if tag == "object":
                own = self.components.setdefault((path, attributes.get("id", "")), [])
            elif tag in ("component", "item"):
                paths = [v for key, v in attributes.items() if key.rpartition(":")[2] == "path"]
                place = (paths[0].lstrip("/") if paths else path, attributes.get("objectid", ""))
                (own if tag == "component" else self.items).append(place)

        parser = expat.ParserCreate()
        parser.StartElementHandler = begin
        parser.Parse(text, True)

    def count(self, place: tuple[str, str], depth: int = 0) -> int:
        """Number of meshes that an object stands for. Raises InputError for one too deep."""
        if depth > DEEPEST:
            raise InputError(f"components lie more than {DEEPEST} deep; join them")
        if place not in self._counts:
            inner = (self.count(part, depth + 1) for part in self.components.get(place, ()))
            self._counts[place] = sum(inner) or 1
        return self._counts[place]


def _count(data: bytes, source: str) -> None:
    """Raise InputError for a file that places too many meshes, which lib3mf would go through.

    What is no archive, or no XML, is left to lib3mf to refuse.
    """
    objects = _Objects()
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            models = {name: archive.read(name) for name in archive.namelist() if name.lower().endswith(".model")}
        if not any(b"component" in text or b"\x00" in text for text in models.values()):
            return
        for path, text in models.items():
            objects.parse(path, text)
    except (zipfile.BadZipFile, zlib.error, OSError, NotImplementedError, RuntimeError, expat.ExpatError):
        return
    try:
        placed = sum(map(objects.count, objects.items))
    except InputError as error:
        raise InputError(f"{source}: {error}") from None
    if placed > MOST_PARTS:
        raise InputError(
            f"{source}: places more than {MOST_PARTS} meshes by components within components; join them into fewer"
        )


def _meshes(resource: Any, name: str, chain: list[Any], unit: float, source: str) -> list[Part]:
    """Meshes of an object, or of its components, moved by all the transforms that lead to it."""
    if resource.IsMeshObject():
        # lib3mf gives lists of C structures, which join as the bytes that they are
        vertices = np.frombuffer(b"".join(resource.GetVertices()), "<f4").reshape(-1, 3)
        triangles = np.frombuffer(b"".join(resource.GetTriangleIndices()), "<u4").reshape(-1, 3)
        return [_placed(name, vertices.astype(np.float64), triangles.astype(np.int64), chain, unit)]
    if not resource.IsComponentsObject() or len(chain) > DEEPEST:
        raise InputError(f"{source}: {name[:40]!r} is no mesh; give triangles")
    parts = []
    for number in range(resource.GetComponentCount()):
        part = resource.GetComponent(number)
        parts += _meshes(part.GetObjectResource(), name, [*chain, part], unit, source)
    return parts


def _placed(name: str, vertices: Array, triangles: npt.NDArray[np.int64], chain: list[Any], unit: float) -> Part:
    for step in reversed(chain):
        moved = step.GetObjectTransform() if hasattr(step, "GetObjectTransform") else (step.GetTransform())
        matrix = np.array([list(row) for row in moved.Fields], np.float64)
        vertices = vertices @ matrix[:3] + matrix[3]
        if np.linalg.det(matrix[:3]) < 0.0:  # a mirror image is turned inside out
            triangles = triangles[:, ::-1]
    return Part(name, unit * vertices, triangles)
