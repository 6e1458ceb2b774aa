"""Request of a sweep, from a command line or from a file, checked."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, get_args

from walkergen.core import Design, InputError, Printer, Scene, Tolerance, parse_count, parse_tolerance
from walkergen.core.files import assignments
from walkergen.files import templates
from walkergen.guests.sweep import axes, nearest, sweep_file
from walkergen.guests.sweep import point_request as request
from walkergen.guests.sweep.axes import Axis, Method, Sample, Space, Span
from walkergen.guests.sweep.point_request import SCENE_PREFIX as SCENES
from walkergen.guests.sweep.point_request import Request, check_single_key
from walkergen.points import model_kinds
from walkergen.points.point import ALONE, PREDICTION
from walkergen.request import PAPER_WALKER, choose_scene

DEFAULT_ERROR = parse_tolerance("5%")
"""Default error of simulated speeds."""


class Ask(NamedTuple):
    """Requested sweep; None for what is left to defaults."""

    design: Design
    data: Mapping[str, Any] | None
    """Data of the design as in its file; None for a design that comes from none."""
    scene: Scene
    printer: Printer | None
    space: Space
    constants: tuple[str, ...]
    """Keys that design and scene have set for all points."""
    model: str
    error: Tolerance | None
    keep: Sequence[str] | None

    def make_request(self) -> Request:
        """Return the checked request. Raises InputError.

        Simulated speeds meet DEFAULT_ERROR unless another error is given, or the runs are set.
        """
        keys = (*self.space.keys, *self.constants)
        own_runs = any(key in ("scene.run.runs", "scene.run.seconds") for key in keys)
        kind = model_kinds.load_kind(model_kinds.kind_of(self.model))
        default = None if self.model == PREDICTION or not kind.MEETS_ERRORS or own_runs else DEFAULT_ERROR
        scene, keep = self.scene, self.keep or kind.KEPT
        if kind.RUNS is not None and "scene.run.runs" not in keys:
            scene = scene.variant(**{"run.runs": kind.RUNS})
        request = Request(
            self.design,
            scene,
            self.space,
            self.model,
            tuple(dict.fromkeys(keep)),
            default if self.error is None else self.error,
            self.printer,
            self.data,
        )
        for key in self.constants:
            if model_kinds.kind_of(self.model) == ALONE:
                check_single_key(key, f"‹set› {key}")
        request.check()
        return request

    def make_wish_request(self) -> Request:
        """Return the checked request of points that have a speed, predicted ones with bounds unless groups are chosen.

        Raises InputError.
        """
        keep = self.keep or (("speed", "spread") if self.model == PREDICTION else None)
        request = self._replace(keep=keep).make_request()
        nearest.check_speed(request.kind.columns(request.model, request.keep))
        return request

    def title(self) -> str:
        """Title of the pictures: the walker, its scene, and the model."""
        by = model_kinds.load_kind(model_kinds.kind_of(self.model)).title(self.model)
        return f"{self.design.name}, {self.scene.name}, {by}"

    def name(self) -> str:
        """Name of the folder, after the design and the keys that vary."""
        keys = "-".join(key.rpartition(".")[2] for key in self.space.keys) or "point"
        return f"{self.design.name}-{keys}"[:100]


def make_ask(
    sources: tuple[Any, Any, Any],
    near: Path,
    space: Space,
    constants: Mapping[str, Any],
    model: str | None,
    error: Tolerance | None,
    keep: Sequence[str] | None,
    source: str,
) -> Ask:
    """Return the sweep of a design, a scene and a printer, by name or as objects, with keys set for all points.

    Paths are relative to the folder `near`. Raises InputError, for constants with `source`.
    """
    design, scene, printer = sources
    for key in constants:
        request.check_key(key, f"{source} {key}")
    own = {key: value for key, value in constants.items() if not key.startswith(SCENES)}
    scenes = {key.removeprefix(SCENES): constants[key] for key in constants if key not in own}
    model = choose_model(model, (*space.keys, *constants))
    if isinstance(design, Design):
        walker, data = assignments.replace_values(design, own, source), None
    else:
        walker, data = assignments.read_with_data(
            templates.resolve_path(design or PAPER_WALKER, "walkers", near), Design, own, source
        )
    place = choose_scene(scene, [walker], default_scene(model))
    if isinstance(place, Scene):
        place = assignments.replace_values(place, scenes, source, SCENES)
    else:
        place = assignments.read_with_values(
            templates.resolve_path(place, "scenes", near), Scene, scenes, source, SCENES
        )
    if not isinstance(printer, Printer | None):
        printer = templates.load(printer, "printers", Printer, near)
    return Ask(walker, data, place, printer, space, tuple(constants), model, error, keep)


def from_file(path: Path) -> Ask:
    """Read the sweep of a file. Raises InputError."""
    file = sweep_file.read_sweep(path)
    return make_ask(
        (file.design, file.scene, file.printer),
        file.folder,
        file.space,
        file.constants,
        file.model,
        file.error,
        file.keep,
        f"{path}: set",
    )


def choose_model(model: str | None, keys: Sequence[str]) -> str:
    """Choose the model of a sweep without a given one from the kind of its keys."""
    return model or next(filter(None, map(model_kinds.kind_of_key, keys)), PREDICTION)


def default_scene(model: str) -> str:
    """Return the default template of the scene."""
    return model_kinds.load_kind(model_kinds.kind_of(model)).SCENE


def make_space(entries: Sequence[Axis | Span], sample: str | None, seed: int) -> tuple[Space, dict[str, Any]]:
    """Space of axes and spans, and the keys of a single value. Raises InputError."""
    axes.check_keys(entries)
    spans = tuple(entry for entry in entries if isinstance(entry, Span))
    lists = [entry for entry in entries if isinstance(entry, Axis)]
    fixed = {axis.key: axis.values[0] for axis in lists if len(axis.values) == 1}
    varied = tuple(axis for axis in lists if len(axis.values) > 1)
    if sample is None:
        for span in spans:
            raise InputError(
                f"‹set› {span.key}={span.low:g}:{span.high:g}: write FIRST:LAST:STEP, or give "
                "‹sample=›sobol:256 to sample between the two"
            )
        return Space(varied), fixed
    samples = parse_sample(sample, spans, seed, f"‹sample=›{sample[:30]!r}")
    if not spans:
        raise InputError(f"‹sample=›{sample}: no key to sample: ‹set› KEY=LOW:HIGH")
    return Space(varied, samples), fixed


def parse_sample(text: str, spans: tuple[Span, ...], seed: int, source: str) -> Sample:
    """Parse samples of spans from sobol:N or latin:N. Raises InputError."""
    method, _, count = text.partition(":")
    samples = parse_count(count, axes.MAX_VALUES)
    if method not in get_args(Method) or samples is None:
        raise InputError(f"{source}: write sobol:N or latin:N, N a whole number in 1..{axes.MAX_VALUES}")
    sequence: Method = "sobol" if method == "sobol" else "latin"
    return Sample(spans, samples, sequence, seed)
