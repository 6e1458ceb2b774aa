"""What lib3mf reads in a 3MF file, as plain data: its own items die with their model."""

from typing import NamedTuple

import lib3mf


class Item(NamedTuple):
    """A build item of a 3MF file as lib3mf reads it."""

    part_number: str
    moved: tuple[float, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]


class File(NamedTuple):
    """A 3MF file."""

    unit: lib3mf.ModelUnit
    metadata: dict[str, str]
    names: list[str]
    sound: bool
    items: list[Item]
    identifiers: list[str]


def read_3mf(data: bytes) -> File:
    """Read in strict mode; a warning fails."""
    model = lib3mf.get_wrapper().CreateModel()
    reader = model.QueryReader("3mf")
    reader.SetStrictModeActive(True)
    reader.ReadFromBuffer(data)
    assert reader.GetWarningCount() == 0
    group, objects, items = model.GetMetaDataGroup(), model.GetMeshObjects(), model.GetBuildItems()
    pairs = [group.GetMetaData(index) for index in range(group.GetMetaDataCount())]
    metadata = {pair.GetName(): pair.GetValue() for pair in pairs}
    found = File(model.GetUnit(), metadata, [], True, [], [model.GetBuildUUID()[1]])
    while objects.MoveNext():
        one = objects.GetCurrentMeshObject()
        found.names.append(one.GetName())
        found.identifiers.append(one.GetUUID()[1])
        found = found._replace(sound=found.sound and one.IsManifoldAndOriented())
    while items.MoveNext():
        one = items.GetCurrent()
        box, moved = one.GetOutbox(), tuple(one.GetObjectTransform().Fields[3])
        low, high = tuple(box.MinCoordinate), tuple(box.MaxCoordinate)
        found.items.append(Item(one.GetPartNumber(), moved, low, high))
        found.identifiers.append(one.GetUUID()[1])
    return found
