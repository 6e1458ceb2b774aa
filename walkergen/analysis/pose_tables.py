"""Pose tables of DeepLabCut and SLEAP: parts of bodies, converted to positions and headings of walkers."""

import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import chain, islice
from pathlib import Path
from typing import NamedTuple

import numpy as np

from walkergen.analysis import track_columns
from walkergen.analysis.track_columns import PIXEL, NamedColumn, Source
from walkergen.core.errors import InputError
from walkergen.core.files import columns, safe_text
from walkergen.core.files.columns import Columns
from walkergen.core.numerics import Array

MIN_LIKELIHOOD = 0.6
"""Minimum likelihood of a part that counts: DeepLabCut draws parts from this value on."""

MIDDLE_NAMES = ("centroid", "center", "centre", "middle", "body", "thorax")
FRONT_NAMES = ("front", "head", "nose", "snout")
BACK_NAMES = ("back", "rear", "tail", "tail_base", "tailbase", "abdomen")
"""Names of parts of a body: its middle, and the ends between which it heads."""

PICTURE_PATTERN = re.compile(r".*?(\d+)\.(?:png|jpe?g|bmp|tiff?),", re.IGNORECASE)
"""Name of a picture, with its folders, which DeepLabCut has in place of a frame; it ends in the frame's number."""

PIXEL_COLUMNS = {
    name: NamedColumn(name, unit) for name, unit in (("frame", ""), ("x", PIXEL), ("y", PIXEL), ("theta", "rad"))
}
"""Columns of poses, with their units."""


class Part(NamedTuple):
    """Part of a body, pixels; NaN if it is not seen."""

    x: Array
    y: Array


def read_deeplabcut(path: Path) -> Source:
    """Read the rows of DeepLabCut's table. Its header has three lines, or four with individuals.

    A row is a frame, or a picture whose name contains the frame.
    """
    top = islice(track_columns.read_text(path), 5)
    head = [columns.split_cells(line, str(path), at) for at, line in enumerate(top, 1)]
    titles = ("scorer", "individuals", "bodyparts", "coords")
    rows = {row[0].lower(): [cell.strip() for cell in row] for row in head if row and row[0].lower() in titles}
    if not {"bodyparts", "coords"} <= set(rows):
        raise InputError(f"{path}: a table of DeepLabCut needs the lines bodyparts and coords. Export it again.")
    first = next((at for at, cell in enumerate(rows["coords"]) if at and cell), 1)  # after a picture's folders
    parts, coords = rows["bodyparts"][first:], rows["coords"][first:]
    individuals = rows["individuals"][first:] if "individuals" in rows else [""] * len(parts)
    if not len(parts) == len(coords) == len(individuals):
        counts = (len(names) + first for names in (parts, coords, individuals))
        raise InputError("{}: its header lines have {}, {} and {} cells. Make them equal.".format(path, *counts))
    keys = [f"{person}/{part}/{coord}" for person, part, coord in zip(individuals, parts, coords, strict=True)]
    header = ",".join([*[""] * (first - 1), "frame", *(f'"{key}"' for key in keys)]) + "\n"
    below = ["\n"] * (len(rows) - 1)  # for the other lines of the header, so that line numbers stay
    body: Iterator[str] = islice(track_columns.read_text(path), len(rows), None)
    pictures = len(head) > len(rows) and bool(PICTURE_PATTERN.match(",".join(head[len(rows)][:first]) + ","))
    if pictures:
        body = (PICTURE_PATTERN.sub("," * (first - 1) + r"\1,", line, count=1) for line in body)
    table = columns.read_numbers(path, ["frame"], keys, lines=chain([header], below, body))
    owned: dict[str, dict[str, Part]] = {}
    for person, part in dict.fromkeys(zip(individuals, parts, strict=True)):
        x, y, likelihood = (table.values.get(f"{person}/{part}/{coord}") for coord in ("x", "y", "likelihood"))
        if x is None or y is None:
            raise InputError(f"{path}: part {safe_text.shorten_line(part)[:30]} has no columns x and y. Export both.")
        unsure = False if likelihood is None else likelihood < MIN_LIKELIHOOD
        owned.setdefault(person, {})[part] = Part(np.where(unsure, np.nan, x), np.where(unsure, np.nan, y))
    if len(owned) > 1:
        owned.pop("single", None)  # parts of no individual, as corners of a box
    notes = ("frames are numbered by the names of pictures",) if pictures else ()
    return from_bodies(table, "frame", table.values["frame"], owned, PIXEL_COLUMNS, "DeepLabCut", notes)


def from_bodies(
    table: Columns,
    clock: str,
    times: Array,
    bodies: Mapping[str, Mapping[str, Part]],
    named: Mapping[str, NamedColumn],
    program: str,
    notes: tuple[str, ...] = (),
) -> Source:
    """Return one row for each body in each frame. `bodies`: parts by name, by the name of the body ("" without one).

    `clock` is the column (frame or time) of `times`; `named` has names and units of columns.
    """
    poses = [_body_pose(parts) for parts in bodies.values()]
    all_have_headings = all(len(pose) == len(poses[0][0]) for pose, _ in poses)
    walkers = [pose if all_have_headings else pose[:2] for pose, _ in poses]
    long = track_columns.to_long_table(table, clock, times, walkers, range(len(walkers)))
    all_notes = (poses[0][1], *notes, *track_columns.format_labels([person for person in bodies if person]))
    return Source(long, named, program, y_down=True, notes=all_notes)


def read_sleap(path: Path, names: list[str]) -> Source:
    """Read SLEAP's analysis table: a row for a walker in a frame, with x, y and score of each part."""
    part_names = (name.removesuffix(".x") for name in names if name.endswith(".x"))
    parts = [part for part in part_names if f"{part}.y" in names]
    if not parts:
        raise InputError(f"{path}: no part has both columns .x and .y. Export both.")
    labels = columns.distinct_texts(track_columns.read_text(path), str(path), "track") if "track" in names else []
    wanted = [f"{part}.{coord}" for part in parts for coord in ("x", "y")]
    words = {"track": labels} if labels else {}
    table = columns.read_numbers(path, ["frame_idx"], wanted, words, track_columns.read_text(path))
    parts_by_name = {part: Part(table.values[f"{part}.x"], table.values[f"{part}.y"]) for part in parts}
    (x, y, *theta), note = _body_pose(parts_by_name)
    values = {"frame": table.values["frame_idx"], "x": x, "y": y}
    values |= {"particle": table.values["track"]} if labels else {}
    values |= {"theta": theta[0]} if theta else {}
    seen = np.isfinite(x)
    table = Columns({name: column[seen] for name, column in values.items()}, table.lines[seen], table.bad)
    return Source(table, PIXEL_COLUMNS, "SLEAP", y_down=True, notes=(note, *track_columns.format_labels(labels)))


def check_table_kind(path: Path, headers: Sequence[str]) -> None:
    """Raise InputError for tables of sleap-io that are not the analysis table: rows of parts, or of whole frames."""
    if "node" in headers or any(name.startswith("inst0.") for name in headers):
        what = "a part of a walker" if "node" in headers else "all walkers of a frame"
        raise InputError(f"{path}: has a row for {what}. Give SLEAP's analysis CSV, with a row for each walker.")


def _body_pose(parts: Mapping[str, Part]) -> tuple[tuple[Array, ...], str]:
    """Return a body's pose (x, y and, if its head and tail are known, heading in rad) and a note on the parts used."""
    matches = ([part for part in parts if part.lower() in names] for names in (MIDDLE_NAMES, FRONT_NAMES, BACK_NAMES))
    middle, front, back = (found[0] if found else "" for found in matches)
    if middle or len(parts) == 1:
        middle = middle or next(iter(parts))
        position, note = parts[middle], f"places are those of the part {safe_text.shorten_line(middle)[:30]}"
    else:
        position = Part(*(np.mean([getattr(part, axis) for part in parts.values()], axis=0) for axis in "xy"))
        note = f"places are the mean of all {len(parts)} parts, in frames that show all of them"
    if not (front and back):
        return position, f"{note}; no headings, because no two parts are called head and tail"
    ahead, behind = parts[front], parts[back]
    theta = np.arctan2(ahead.y - behind.y, ahead.x - behind.x)
    ends = (safe_text.shorten_line(back)[:30], safe_text.shorten_line(front)[:30])
    return (*position, theta), f"{note}, headings from {' to '.join(ends)}"
