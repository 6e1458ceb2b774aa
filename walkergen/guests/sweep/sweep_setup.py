"""Set-up of a sweep: its points are read from the command line or from a file, and checked."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, get_args

from walkergen.core import Design, InputError, Printer, Scene, Tolerance, parse_count, parse_tolerance
from walkergen.core.files import assignments
from walkergen.files import templates
from walkergen.guests.sweep import axes, nearest, sweep_file, sweep_points
from walkergen.guests.sweep.axes import Axis, Method, Sample, Space, Span
from walkergen.guests.sweep.request import SweepRequest
from walkergen.guests.sweep.sweep_points import SCENE_PREFIX as SCENES
from walkergen.guests.sweep.sweep_points import SweepPoints, check_not_crowd_key
from walkergen.points import model_kinds
from walkergen.points.point import ALONE, PREDICTION
from walkergen.request import PAPER_WALKER, choose_scene

DEFAULT_ERROR = parse_tolerance("5%")
"""Default error of simulated speeds."""


def read_points(request: SweepRequest) -> SweepPoints:
    """Return the points of a sweep, from the options of a request or from the file that it names. Raises InputError."""
    with_speed = request.wish is not None
    if request.file is not None:
        request.check_unset("is set by ‹file›", "design", "set", "scene", "printer", "error", "sample")
        return from_file(request.file, with_speed)
    if isinstance(request.set, Mapping):
        entries = [_parse_entry(key, values) for key, values in request.set.items()]
    else:
        entries = [axes.parse(text) for text in request.set]
    space, constants = make_space(entries, request.sample, request.seed)
    error = None if request.error is None else parse_tolerance(request.error)
    sources = request.design, request.scene, request.printer
    return make_points(sources, Path(), space, constants, request.model, error, request.keep, "‹set›", with_speed)


def _parse_entry(key: str, values: Any) -> Axis | Span:
    """Return the axis or span of a key from text, one value, or several. Raises InputError."""
    if isinstance(values, str):
        return axes.from_text(key, values, f"‹set› {key}={values[:60]!r}")
    if isinstance(values, Mapping):
        raise InputError(f"{key}: its value is a table. Give one value, or a list of values.", key)
    listed = list(values) if isinstance(values, Iterable) else [values]
    return axes.make_axis(key, [value.item() if hasattr(value, "item") else value for value in listed], key)


def make_points(
    sources: tuple[Any, Any, Any],
    near: Path,
    space: Space,
    constants: Mapping[str, Any],
    model: str | None,
    error: Tolerance | None,
    keep: Sequence[str] | None,
    source: str,
    with_speed: bool = False,
    file: Path | None = None,
) -> SweepPoints:
    """Return the points of a sweep, checked.

    Parameters
    ----------
    sources : tuple
        Design, scene and printer: names, paths from the folder `near`, or objects.
    near : Path
        Folder at which paths begin.
    space : Space
        Keys that vary, with their values.
    constants : mapping
        Values by key that all points share.
    model : str or None
        Name of the model; None to choose it by the keys.
    error : Tolerance or None
        Error of simulated speeds. None: DEFAULT_ERROR, unless the number of runs is set.
    keep : sequence of str or None
        Groups of quantities in the table; None for those of the model.
    source : str
        Beginning of messages on constants.
    with_speed : bool
        True if the table must have the speed.
    file : Path, optional
        File with the other keys, named in messages on them.

    Returns
    -------
    SweepPoints
        Points of the sweep.

    Raises
    ------
    InputError
        If a key, a value or a combination of options is invalid.
    """
    model = choose_model(model, (*space.keys, *constants))
    design, scene, printer, data = _read_sources(sources, near, constants, model, source)
    keys = (*space.keys, *constants)
    kind = model_kinds.load_kind(model_kinds.kind_of(model))
    own_runs = any(key in ("scene.run.runs", "scene.run.seconds") for key in keys)
    if error is None and model != PREDICTION and kind.MEETS_ERRORS and not own_runs:
        error = DEFAULT_ERROR
    if kind.RUNS is not None and "scene.run.runs" not in keys:
        scene = scene.variant(**{"run.runs": kind.RUNS})
    kept = tuple(dict.fromkeys(keep or kind.KEPT))
    points = SweepPoints(design, scene, space, model, kept, error, printer, data, file)
    for key in constants:
        if model_kinds.kind_of(model) == ALONE:
            check_not_crowd_key(key, f"{source} {key}")
    points.check()
    if with_speed:
        nearest.check_speed(points.columns)
    return points


def _read_sources(
    sources: tuple[Any, Any, Any], near: Path, constants: Mapping[str, Any], model: str, source: str
) -> tuple[Design, Scene, Printer | None, Mapping[str, Any] | None]:
    """Return design, scene and printer with constants set, and the data of the design's file. See `make_points`."""
    design, scene, printer = sources
    for key in constants:
        sweep_points.check_key(key, f"{source} {key}")
    design_values = {key: value for key, value in constants.items() if not key.startswith(SCENES)}
    scene_values = {key.removeprefix(SCENES): constants[key] for key in constants if key not in design_values}
    if isinstance(design, Design):
        walker, data = assignments.replace_values(design, design_values, source), None
    else:
        walker, data = assignments.read_with_data(
            templates.resolve_path(design or PAPER_WALKER, "walkers", near), Design, design_values, source
        )
    ground = choose_scene(scene, [walker], default_scene(model))
    if isinstance(ground, Scene):
        ground = assignments.replace_values(ground, scene_values, source, SCENES)
    else:
        ground = assignments.read_with_values(
            templates.resolve_path(ground, "scenes", near), Scene, scene_values, source, SCENES
        )
    if not isinstance(printer, Printer | None):
        printer = templates.load(printer, "printers", Printer, near)
    return walker, ground, printer, data


def from_file(path: Path, with_speed: bool = False) -> SweepPoints:
    """Read the points of a sweep from a sweep.toml. `with_speed`: True if they must have a speed. Raises InputError."""
    file = sweep_file.read_sweep(path)
    sources, table = (file.design, file.scene, file.printer), f"{path}: set"
    return make_points(
        sources, file.folder, file.space, file.constants, file.model, file.error, file.keep, table, with_speed, path
    )


def choose_model(model: str | None, keys: Sequence[str]) -> str:
    """Return `model` or, if it is None, the model of the first key that applies to only one. Default: PREDICTION."""
    return model or next(filter(None, map(model_kinds.kind_of_key, keys)), PREDICTION)


def default_scene(model: str) -> str:
    """Return the name of a model's default scene template."""
    return model_kinds.load_kind(model_kinds.kind_of(model)).SCENE


def make_space(entries: Sequence[Axis | Span], sample: str | None, seed: int) -> tuple[Space, dict[str, Any]]:
    """Return the space of the axes with several values and of the spans, and the values of keys that have only one.

    `sample`: sobol:N or latin:N for spans, None without. `seed`: of the samples. Raises InputError.
    """
    axes.check_keys(entries)
    spans = tuple(entry for entry in entries if isinstance(entry, Span))
    lists = [entry for entry in entries if isinstance(entry, Axis)]
    fixed = {axis.key: axis.values[0] for axis in lists if len(axis.values) == 1}
    varied = tuple(axis for axis in lists if len(axis.values) > 1)
    if sample is None:
        for span in spans:
            raise InputError(
                f"‹set› {span.key}={span.low:g}:{span.high:g}: the range has no step. Write FIRST:LAST:STEP, or give "
                "‹sample=›sobol:256 to sample the range."
            )
        return Space(varied), fixed
    samples = parse_sample(sample, spans, seed, f"‹sample=›{sample[:30]!r}")
    if not spans:
        raise InputError(f"‹sample=›{sample}: has no key to sample. Add ‹set› KEY=LOW:HIGH.")
    return Space(varied, samples), fixed


def parse_sample(text: str, spans: tuple[Span, ...], seed: int, source: str) -> Sample:
    """Parse sobol:N or latin:N to N samples of the spans. Raises InputError, which begins with `source`."""
    method, _, count = text.partition(":")
    samples = parse_count(count, axes.MAX_VALUES)
    if method not in get_args(Method) or samples is None:
        raise InputError(f"{source}: write sobol:N or latin:N, N a whole number in 1..{axes.MAX_VALUES}")
    sequence: Method = "sobol" if method == "sobol" else "latin"
    return Sample(spans, samples, sequence, seed)
