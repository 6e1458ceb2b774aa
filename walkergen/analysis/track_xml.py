"""Tracks in files that are no tables: TrackMate's XML, projects of Tracker, and MTrackJ's own file."""

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from walkergen.analysis import track_columns
from walkergen.analysis.track_columns import NamedColumn, Source
from walkergen.core.errors import InputError
from walkergen.core.files import columns, file_reading, safe_text
from walkergen.core.files.columns import Columns

MAX_XML_BYTES = 200_000_000
"""Largest XML file that is read, bytes."""


def read_mtrackj(path: Path) -> Source:
    """Read MTrackJ's own file: lines Track ID, and Point ID x y z t channel below each."""
    rows: list[tuple[float, ...]] = []
    lines, bad, track = [], {}, -1.0
    for at, line in enumerate(track_columns.read_text(path), 1):
        first_word, *cells = line.split() or [""]
        if first_word == "Track":
            track += 1.0
        elif first_word == "Point":
            try:
                _, x, y, _, t, *_ = map(float, cells)
            except ValueError:
                bad[at] = "is no point of five numbers or more"
            else:
                rows.append((t, track, x, y))
                lines.append(at)
    return _from_rows(path, rows, lines, bad, "MTrackJ", track_columns.PIXEL)


def _from_rows(
    path: Path,
    rows: Sequence[tuple[float, ...]],
    lines: Sequence[int],
    bad: dict[int, str],
    program: str,
    unit: str,
    frame_s: float | None = None,
) -> Source:
    """Return a source from rows of frame, particle, x and y. `lines`: line numbers of the rows in the file.

    `bad`: reasons by line; `unit` of x and y; `frame_s`: time between frames, s, if known.
    """
    if not rows:
        raise InputError(f"{path}: contains no track. Export it with at least one track.")
    frame, particle, x, y = np.array(rows, dtype=float).T
    values = {"frame": frame, "particle": particle, "x": x, "y": y}
    named = {"frame": NamedColumn("frame", ""), "x": NamedColumn("x", unit), "y": NamedColumn("y", unit)}
    if frame_s:
        values["time"], named["time"] = frame_s * frame, NamedColumn("t", "s")
    table = Columns(values, np.array(lines, np.int64), bad)
    beyond = ~(np.abs(np.array(rows)) <= columns.MAX_MAGNITUDE).all(axis=1)
    return Source(
        table.reject_rows(beyond, f"has no numbers within ±{columns.MAX_MAGNITUDE:g}"), named, program, y_down=True
    )


def read_xml(path: Path) -> Source:
    """Read an XML file: TrackMate's tracks alone or with everything that it stores, or a project of Tracker."""
    text = file_reading.read_bytes(path, MAX_XML_BYTES, "an XML file of tracks")
    if b"<!DOCTYPE" in text or b"<!ENTITY" in text:
        raise InputError(f"{path}: it defines XML entities, which files of tracks never do. Export it again.")
    try:
        root = ElementTree.fromstring(text)
        if root.tag in ("Tracks", "TrackMate"):
            return _from_trackmate(path, root)
        if root.get("class", "").endswith(".TrackerPanel"):
            return _from_tracker(path, root)
    except (ElementTree.ParseError, LookupError, ValueError) as error:
        reason = file_reading.describe_error(error)
        raise InputError(f"{path}: is not valid XML of tracks ({reason}). Export it again.") from None
    seen = safe_text.shorten_line(root.tag)[:30]
    raise InputError(
        f"{path}: begins with <{seen}>. Give <Tracks> or <TrackMate> of TrackMate, or a project of Tracker."
    )


def _from_trackmate(path: Path, root: ElementTree.Element) -> Source:
    """Return the rows of TrackMate's XML: tracks alone, or with everything that it stores."""
    if root.tag == "Tracks":
        rows: list[tuple[float, ...]] = [
            (float(spot.attrib["t"]), float(number), float(spot.attrib["x"]), float(spot.attrib["y"]))
            for number, track in enumerate(root.iter("particle"))
            for spot in track.iter("detection")
        ]
        space, time, interval = (root.get(key, "") for key in ("spaceUnits", "timeUnits", "frameInterval"))
    else:
        rows = list(_model_rows(root))
        model, image = root.find("Model"), root.find("Settings/ImageData")
        if model is None:
            raise ValueError("it has no Model")
        space, time = model.get("spatialunits", ""), model.get("timeunits", "")
        interval = "" if image is None else image.get("timeinterval", "")
    unit_s = track_columns.TIME_UNITS_S.get(track_columns.canonical_unit(time))
    frame_s = unit_s * float(interval or 0.0) if unit_s else None
    return _from_rows(
        path, rows, range(1, len(rows) + 1), {}, "TrackMate", track_columns.canonical_unit(space), frame_s
    )


def _from_tracker(path: Path, root: ElementTree.Element) -> Source:
    """Return the point masses of Tracker's project as rows, in the axes and the scale of the project."""
    axes = root.findall("property[@name='coords']/object/property[@name='framedata']/property/object")
    if len(axes) != 1:
        raise InputError(f"{path}: its axes or scale change from frame to frame: export the table (File, Export, Data)")
    origin = _read_number(axes[0], "xorigin") + 1j * _read_number(axes[0], "yorigin")
    turn = np.exp(1j * math.radians(_read_number(axes[0], "angle")))
    second = 1e-3 * _read_number(root.find("property[@name='clipcontrol']/object"), "delta_t")
    masses = [
        track
        for track in root.findall("property[@name='tracks']/property/object")
        if track.get("class", "").endswith(".PointMass")
    ]
    rows: list[tuple[float, ...]] = []
    for number, track in enumerate(masses):
        for mark in track.findall("property[@name='framedata']/property"):
            away = _read_number(mark.find("object"), "x") + 1j * _read_number(mark.find("object"), "y") - origin
            position = away.conjugate() / turn  # a picture counts rows downward
            x, y = position.real / _read_number(axes[0], "xscale"), position.imag / _read_number(axes[0], "yscale")
            rows.append((float(mark.attrib["name"].strip("[]")), float(number), x, y))
    source = _from_rows(path, rows, range(1, len(rows) + 1), {}, "Tracker", "", second)
    notes = track_columns.format_labels([track.findtext("property[@name='name']", "") for track in masses])
    return source._replace(y_down=False, notes=notes if len(masses) > 1 else ())


def _read_number(element: ElementTree.Element | None, name: str) -> float:
    """Read a number that Tracker saved under a name. Raises ValueError if it is missing or not finite."""
    text = None if element is None else element.findtext(f"property[@name='{name}']")
    number = math.nan if text is None else float(text)
    if not math.isfinite(number) or (name.endswith("scale") and number == 0.0):
        raise ValueError(f"{name} is {safe_text.shorten_line(text or 'missing')[:30]}")
    return number


def _model_rows(root: ElementTree.Element) -> Iterator[tuple[float, ...]]:
    """Yield frame, particle, x and y of the spots of TrackMate's tracks that pass its filters."""
    spots = {
        spot.attrib["ID"]: tuple(float(spot.attrib[f"{key}"]) for key in ("FRAME", "POSITION_X", "POSITION_Y"))
        for spot in root.iter("Spot")
    }
    filtered_tracks = {track.attrib["TRACK_ID"] for track in root.iter("TrackID")}
    for track in root.iter("Track"):
        number = track.attrib["TRACK_ID"]
        if filtered_tracks and number not in filtered_tracks:
            continue
        spot_ids = (edge.attrib[key] for edge in track.iter("Edge") for key in ("SPOT_SOURCE_ID", "SPOT_TARGET_ID"))
        for spot in dict.fromkeys(spot_ids):
            frame, x, y = spots[spot]
            yield frame, float(number), x, y
