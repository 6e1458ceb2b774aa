"""Points of a sweep: a design in a scene, with keys that vary."""

import copy
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from walkergen.core import Design, GeometryError, InputError, Printer, Scene, Tolerance, WalkergenError
from walkergen.core.files import assignments
from walkergen.guests.sweep.axes import Space
from walkergen.guests.sweep.evaluation import PointOrRefusal
from walkergen.points import model_kinds
from walkergen.points.model_kinds import Kind, Picture
from walkergen.points.point import ALONE, PREDICTION, REASON_KEY, STATUS_KEY, Point, refused_record

MAX_CHECKED_POINTS = 1000
"""Largest number of points of a sweep that is refused at the start if all its points are invalid."""

SCENE_PREFIX = "scene."
"""Prefix of the keys of a scene. All other keys belong to a design."""


class SweepPoints(NamedTuple):
    """Points to evaluate: a design and a scene, with the keys that vary."""

    design: Design
    scene: Scene
    space: Space
    model: str = PREDICTION
    """Name of the model that evaluates the points: prediction, space or crowd."""
    keep: tuple[str, ...] = ("speed",)
    """Groups of quantities in the table."""
    wanted: Tolerance | None = None
    """Requested error of simulated speeds."""
    printer: Printer | None = None
    data: Mapping[str, Any] | None = None
    """Contents of the design's file, if known. Keys are set in them, not in the validated design."""
    file: Path | None = None
    """File with the keys that vary, named in messages; None if the command line has them."""

    @property
    def kind(self) -> Kind:
        """Functions that evaluate, name and draw the points of this model."""
        return model_kinds.load_kind(model_kinds.kind_of(self.model))

    @property
    def main_number(self) -> Picture | None:
        """Main quantity of the sweep: the one in the first picture; None without pictures."""
        return next(iter(self.kind.pictures(self.keep)), None)

    @property
    def title(self) -> str:
        """Title of the pictures: the walker, the model, and tilt and drive as far as they do not vary."""
        drive, keys = self.scene.drive, " ".join(self.space.keys)
        fixed = ["" if "tilt_deg" in keys else f"{self.design.tilt_deg:g} deg tilt"]
        if f"{SCENE_PREFIX}drive." not in keys:
            fixed.append(self.scene.name)
        elif drive.kind == "plate":
            fixed.append("" if "frequency_hz" in keys else f"{drive.frequency:g} Hz")
            changed = any(name in keys for name in ("gamma", "peak_speed", "amplitude"))
            fixed.append("" if changed else f"{drive.peak_gamma:.3g} g")
        parts = [part for part in (*fixed, self.kind.title(self.model)) if part]
        return f"{self.design.name} ({', '.join(parts)})"

    @property
    def folder_name(self) -> str:
        """Name of the folder, after the design and the keys that vary."""
        keys = "-".join(key.rpartition(".")[2] for key in self.space.keys) or "point"
        return f"{self.design.name}-{keys}"[:100]

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the table's columns for quantities and status, without those of the keys."""
        return (*self.kind.columns(self.model, self.keep), STATUS_KEY)

    def check(self) -> None:
        """Raise InputError for an unknown key, value or group, or if all points of a small sweep are invalid."""
        model_kinds.check(self.keep, self.model, self.printer)
        if self.wanted is not None and self.model == PREDICTION:
            raise InputError(f"‹error=›{self.wanted}: applies only to simulations. Remove it, or give ‹model=›space.")
        if self.wanted is not None and not self.kind.MEETS_ERRORS:
            raise InputError(f"‹error=›{self.wanted}: does not apply to crowds. Set scene.run.runs instead.")
        for key in self.space.keys:
            check_key(key, f"‹set› {key}")
            if model_kinds.kind_of(self.model) == ALONE:
                check_not_crowd_key(key, f"‹set› {key}" if self.file is None else f"{self.file}: {key}")
        for axis in self.space.axes:
            for value in axis.values:
                if isinstance(value, (str, bool, list, dict)):
                    self._check_form(axis.key, value)
        if self.space.point_count > MAX_CHECKED_POINTS:
            return
        reasons = []
        for point in self.points():
            if isinstance(point, Point):
                return
            reasons.append(point[REASON_KEY])
        raise InputError(f"all {len(reasons)} points are invalid: {reasons[0]}", *self.space.keys[:1])

    def _check_form(self, key: str, value: Any) -> None:
        """Raise InputError for a text, list or table that the key never accepts. Numbers are checked at each point."""
        source = "‹set›" if self.file is None else f"{self.file}: grid"
        try:
            change_keys(self.design, self.scene, {key: value}, source, self.data)
        except GeometryError:  # parts that cannot be built now, but perhaps with other values of other keys
            return
        except InputError as error:
            # For each key at fault: the letter that follows `key` in it, "" if they are equal
            faults = [fault.removeprefix(key)[:1] for fault in error.keys if fault.startswith(key)]
            if model_kinds.kind_of_key(key) or {"", ".", "["} & {*faults}:
                if self.file is None:
                    raise
                is_number = " number >" in error.text and isinstance(value, (list, dict))
                advice = '. Or write a list of numbers, or a range such as "0:45:5"' if is_number else ""
                raise InputError(error.text.replace(f"{source}: ", f"{source}.") + advice, *error.keys) from None

    def try_point(self, values: Mapping[str, Any]) -> PointOrRefusal:
        """Return the point with these values of the keys or, if it is invalid, a record with the reason."""
        try:
            return self.point(values)
        except WalkergenError as error:
            return refused_record(error)

    def point(self, values: Mapping[str, Any]) -> Point:
        """Return the point with these values of the keys. Raises WalkergenError if it is invalid."""
        design, scene = change_keys(self.design, self.scene, values, data=self.data)
        if (kind := model_kinds.kind_of(self.model)) != ALONE:
            return Point(design, scene, simulated=True, keep=(), kind=kind)
        return Point(design, scene, self.model != PREDICTION, self.keep, self.wanted, self.printer)

    def points(self) -> Iterator[PointOrRefusal]:
        """Yield all points, or records of invalid points, in the order of `space.rows`."""
        keys = self.space.keys
        for row in self.space.rows():
            yield self.try_point(dict(zip(keys, row, strict=True)))


def check_key(key: str, source: str) -> None:
    """Raise InputError, which begins with `source`, for a key that neither design nor scene has."""
    bare_key = key.removeprefix(SCENE_PREFIX)
    if bare_key == key:
        assignments.check_key(bare_key, Design, source)
    else:
        assignments.check_key(bare_key, Scene, source, SCENE_PREFIX)


def check_not_crowd_key(key: str, source: str) -> None:
    """Raise InputError, which begins with `source`, for a key that applies only to crowds."""
    if model_kinds.kind_of_key(key) == "crowd":
        raise InputError(f"{source}: applies only to crowds. Leave ‹model› out, or give ‹model=›crowd.")


def change_keys(
    design: Design,
    scene: Scene,
    values: Mapping[str, Any],
    source: str = "‹set›",
    data: Mapping[str, Any] | None = None,
) -> tuple[Design, Scene]:
    """Return a design and a scene with these `values`, by dotted key. Keys of the scene begin with "scene.".

    `data`: contents of the design's file, if known. The values are then set in them. Raises InputError or
    GeometryError with a line for every mistake. Each line begins with `source`.
    """
    design_values = {key: value for key, value in values.items() if not key.startswith(SCENE_PREFIX)}
    scene_values = {
        key.removeprefix(SCENE_PREFIX): value for key, value in values.items() if key.startswith(SCENE_PREFIX)
    }
    if data is None or not design_values:
        varied = assignments.replace_values(design, design_values, source)
    else:
        varied = assignments.assign_values(design, copy.deepcopy(dict(data)), design_values, source)
    return varied, assignments.replace_values(scene, scene_values, source, SCENE_PREFIX)
