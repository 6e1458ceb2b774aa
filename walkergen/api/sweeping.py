"""Maps of speed over any keys, as the command `sweep` makes them."""

import numbers
import os
from collections.abc import Iterable, Mapping, Sequence
from contextlib import closing, nullcontext
from pathlib import Path
from typing import Any

import numpy as np

from walkergen.api.loading import Ground, Machine, Walker, printer_of, scene_of, walker_of
from walkergen.errors import InputError
from walkergen.files.progress import Progress, silent
from walkergen.jobs.run.sweep import ask, make
from walkergen.jobs.run.sweep.ask import Ask
from walkergen.jobs.run.sweep.report import SweepReport
from walkergen.points import axes, tolerance, worker_pool
from walkergen.points.axes import Sample, Space, Span
from walkergen.points.store import Store


def sweep(
    design: Walker,
    scene: Ground | None = None,
    values: Mapping[str, Any] | None = None,
    *,
    between: Mapping[str, tuple[float, float]] | None = None,
    sample: str | None = None,
    seed: int = 1,
    model: str | None = None,
    error: str | None = None,
    keep: Sequence[str] | None = None,
    printer: Machine | None = None,
    workers: int | None = None,
    folder: str | os.PathLike[str] | None = None,
    progress: Progress | None = None,
) -> SweepReport:
    """Map speeds over all combinations of the `values` of any keys, the last key fastest.

    Keys are dotted, those of the scene begin with "scene.": {"legs.tilt_deg": [5, 10],
    "scene.drive.gamma": np.arange(1.5, 2.5, 0.1)}. Keys `between` two bounds, {"legs.tilt_deg":
    (2, 40)}, are sampled: `sample` is "sobol:256" or "latin:99", with a `seed`; every combination
    of the values has every sample. `model` is "prediction", the default, or one to simulate, within
    `error`, "5%" by default; where a key begins with "scene.crowd." it is "crowd", and `keep` names
    statistics of crowds. The scene is "lane-90hz" by default, of crowds "plane-90hz". Points that
    were evaluated before are not evaluated again. With `workers` that many processes share the
    points (a script then needs `if __name__ == "__main__":`), by default they are evaluated here.
    With a `folder` table, pictures and manifest are written there. Raises InputError.
    """
    listed = tuple(_axis(key, value) for key, value in (values or {}).items())
    space = Space(listed, _sample(between or {}, sample, seed))
    for key in between or ():
        if key in (values or {}):
            raise InputError(f"between: {key}: is in values too: leave one of them out")
    tolerated = None if error is None else tolerance.parse(error)
    machine = None if printer is None else printer_of(printer)
    model = ask.model_of(model, space.keys)
    ground = scene_of(ask.scene_for(model) if scene is None else scene)
    asked = Ask(walker_of(design), None, ground, machine, space, (), model, tolerated, keep)
    request, tell = asked.request(), progress or silent
    hired = nullcontext() if workers is None else worker_pool.local(workers)
    job = make.Job(request, asked.title(), kept=True)
    with closing(Store()) as store, hired as hands:
        if folder is None:
            return make.find(job, store, hands, tell)
        return make.make(job, Path(folder), store, hands, tell)


def _sample(between: Mapping[str, Any], sample: str | None, seed: int) -> Sample | None:
    """Samples between bounds; None without any. Raises InputError."""
    if sample is None:
        for key in between:
            raise InputError(f"between={key!r}: give sample='sobol:256' or 'latin:99' with it")
        return None
    if not between:
        raise InputError(f"sample={sample!r}: no key to sample: between={{KEY: (LOW, HIGH)}}")
    if not isinstance(seed, numbers.Integral) or isinstance(seed, bool) or seed < 0:
        raise InputError(f"seed={seed!r}: must be a whole number >= 0")
    spans = tuple(_span(key, bounds) for key, bounds in between.items())
    return ask.sample_of(str(sample), spans, int(seed), f"sample={sample!r}")


def _span(key: str, bounds: Any) -> Span:
    """Bounds between which a key is sampled. Raises InputError."""
    try:
        low, high = (float(bound) for bound in bounds)
    except (TypeError, ValueError):
        raise InputError(f"between: {key}: {bounds!r}: must be two numbers, (LOW, HIGH)") from None
    return axes.span(key, low, high, f"between: {key}")


def _axis(key: str, values: Any) -> axes.Axis:
    """Axis of a key's values: a list, an array, a range, or one value. Raises InputError."""
    plain = values.tolist() if isinstance(values, (np.ndarray, np.generic)) else values
    listed = list(plain) if isinstance(plain, Iterable) and not isinstance(plain, str) else [plain]
    if isinstance(plain, Mapping):
        raise InputError(f"{key}: a table seen: give a list of values")
    listed = [value.item() if isinstance(value, np.generic) else value for value in listed]
    return axes.axis(key, listed, key)
