"""Tracks in files that are no tables: TrackMate's XML, of spots or of tracks, and MTrackJ's own file."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from walkergen.analysis import track_columns
from walkergen.analysis.track_columns import Named, Source
from walkergen.errors import InputError
from walkergen.files import columns, plain, reading
from walkergen.files.columns import Columns

LARGEST_XML = 200_000_000
"""Largest XML file that is read, bytes."""


def mtrackj(path: Path) -> Source:
    """Rows of MTrackJ's own file: lines Track ID, and Point ID x y z t channel below each."""
    rows: list[tuple[float, ...]] = []
    lines, bad, track = [], {}, -1.0
    for at, line in enumerate(reading.lines(path, columns.FORMAT), 1):
        word, *cells = line.split() or [""]
        if word == "Track":
            track += 1.0
        elif word == "Point":
            try:
                _, x, y, _, t, *_ = map(float, cells)
            except ValueError:
                bad[at] = "is no point of five numbers or more"
            else:
                rows.append((t, track, x, y))
                lines.append(at)
    return _of_rows(path, rows, lines, bad, "MTrackJ", track_columns.PIXEL)


def _of_rows(
    path: Path,
    rows: Sequence[tuple[float, ...]],
    lines: Sequence[int],
    bad: dict[int, str],
    program: str,
    unit: str,
    second: float | None = None,
) -> Source:
    """Rows of frame, particle, x and y; `second` is the time between frames, s, where that is known."""
    if not rows:
        raise InputError(f"{path}: no track in it")
    frame, particle, x, y = np.array(rows, dtype=float).T
    values = {"frame": frame, "particle": particle, "x": x, "y": y}
    named = {"frame": Named("frame", ""), "x": Named("x", unit), "y": Named("y", unit)}
    if second:
        values["time"], named["time"] = second * frame, Named("t", "s")
    return Source(Columns(values, np.array(lines, np.int64), bad), named, program, True)


def trackmate(path: Path) -> Source:
    """Rows of TrackMate's XML: of its tracks alone, or of all that it keeps."""
    text = reading.content(path, LARGEST_XML, "an XML file of TrackMate")
    if b"<!DOCTYPE" in text or b"<!ENTITY" in text:
        raise InputError(f"{path}: declares entities, which TrackMate's files do not")
    try:
        root = ElementTree.fromstring(text)
        if root.tag == "Tracks":
            rows: list[tuple[float, ...]] = [
                (float(spot.attrib["t"]), float(number), float(spot.attrib["x"]), float(spot.attrib["y"]))
                for number, track in enumerate(root.iter("particle"))
                for spot in track.iter("detection")
            ]
            space, time, interval = (root.get(key, "") for key in ("spaceUnits", "timeUnits", "frameInterval"))
        elif root.tag == "TrackMate":
            rows = list(_of_model(root))
            model, image = root.find("Model"), root.find("Settings/ImageData")
            assert model is not None
            space, time = model.get("spatialunits", ""), model.get("timeunits", "")
            interval = "" if image is None else image.get("timeinterval", "")
        else:
            raise InputError(f"{path}: <{plain.line(root.tag)[:30]}> seen: must be TrackMate's <Tracks> or <TrackMate>")
    except (ElementTree.ParseError, KeyError, ValueError, AssertionError) as error:
        raise InputError(f"{path}: is no sound XML of TrackMate: {plain.line(str(error))[:80]}") from None
    seconds = track_columns.TIMES.get(track_columns.unit_of(time))
    second = seconds * float(interval or 0.0) if seconds else None
    return _of_rows(path, rows, range(1, len(rows) + 1), {}, "TrackMate", track_columns.unit_of(space), second)


def _of_model(root: ElementTree.Element) -> Iterator[tuple[float, ...]]:
    """Rows of the spots of TrackMate's tracks, those that its filters keep."""
    spots = {
        spot.attrib["ID"]: tuple(float(spot.attrib[f"{key}"]) for key in ("FRAME", "POSITION_X", "POSITION_Y"))
        for spot in root.iter("Spot")
    }
    kept = {track.attrib["TRACK_ID"] for track in root.iter("TrackID")}
    for track in root.iter("Track"):
        number = track.attrib["TRACK_ID"]
        if kept and number not in kept:
            continue
        ends = (edge.attrib[key] for edge in track.iter("Edge") for key in ("SPOT_SOURCE_ID", "SPOT_TARGET_ID"))
        for spot in dict.fromkeys(ends):
            frame, x, y = spots[spot]
            yield frame, float(number), x, y
