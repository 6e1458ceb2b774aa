"""Run of a sweep: it evaluates the points that are not stored, and writes a table, pictures and a manifest."""

import hashlib
import json
import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

from walkergen.core import Expect, Expected, Folder, InputError, Progress, core_count, versions
from walkergen.core.files import output
from walkergen.core.files.formatting import is_number
from walkergen.guests.sweep import cost, evaluation, report, sweep_setup, table
from walkergen.guests.sweep.evaluation import Done
from walkergen.guests.sweep.report import Points, SweepReport
from walkergen.guests.sweep.request import SweepRequest
from walkergen.guests.sweep.sweep_points import SweepPoints
from walkergen.guests.sweep.table import Table
from walkergen.inputs import open_pool
from walkergen.points.point import PREDICTION, digest
from walkergen.points.store import Store
from walkergen.points.worker_pool import WorkerPool

MAX_DRAWN_POINTS = 200_000
"""Largest number of points that are drawn; memory grows with it."""


MAX_LOCAL_POINTS = 512
"""Number of predicted points up to which this process evaluates them: starting others would take longer."""


def run(request: SweepRequest, progress: Progress, expect: Expect) -> SweepReport:
    """Evaluate all points of a request and return the report. `expect` gets a function that estimates the time."""
    sweep = sweep_setup.read_points(request)
    folder = request.output_folder(Path("out") / "sweeps" / sweep.folder_name)
    in_process = not request.from_shell or (sweep.model == PREDICTION and sweep.space.point_count <= MAX_LOCAL_POINTS)
    with closing(Store()) as store, open_pool(in_process, request.workers, request.dask) as pool:
        # In this process a point takes one core, but a short simulation takes all of them.
        workers = pool.workers if pool is not None else 1 if sweep.model != PREDICTION else core_count()

        def estimate() -> cost.Cost | None:
            """Estimate the cost of this sweep; None if it is small."""
            return cost.estimate(sweep, store, workers)

        if not request.yes and sweep.space.point_count > cost.MAX_UNCONFIRMED_POINTS:
            raise InputError(
                f"{cost.format_cost(estimate(), sweep.space.point_count)}. Give ‹yes› to start, or use fewer points.",
                "yes",
            )
        expect(lambda: None if (found := estimate()) is None else Expected(found.seconds, found.note))
        if folder is None:
            return evaluate_all(request, sweep, store, pool, progress)
        return make_sweep(request, sweep, folder, store, pool, progress)


def make_sweep(
    request: SweepRequest, sweep: SweepPoints, path: Path, store: Store, pool: WorkerPool | None, progress: Progress
) -> SweepReport:
    """Evaluate all points of a sweep, write table.csv, table.parquet and pictures to a folder. Return the report.

    Stored points are not evaluated again. The table grows row by row, and finished rows are always kept. Raises
    InputError if another sweep writes to the folder or it has a foreign file of that name, OutputError when a file
    cannot be written, WalkergenError when a worker is lost, and KeyboardInterrupt with a complete table.
    """
    started = time.perf_counter()
    sweep.check()
    pictures = request.pictures and sweep.space.point_count <= MAX_DRAWN_POINTS
    with Folder(path) as folder:
        folder.claim()
        if earlier := _load_finished(request, sweep, folder):
            return earlier
        warnings = _rename_changed_table(folder)
        points = Points(sweep.space.keys, sweep.columns, sweep.main_number, request.keeps_rows or pictures)
        folder.start_growing_file(table.TABLE_FILE)
        with Table(path / table.TABLE_FILE, sweep.space.keys, points.names) as rows:
            for values, done in _evaluate_points(sweep, store, pool, progress):
                rows.add(values, done.record, done.key)
                points.add(values, done)
        result = report.make_report(sweep, points, warnings, request.wish)
        _write_other_files(sweep, folder, result, pictures, time.perf_counter() - started)
    return report.add_files(result, path, list(folder.hashes))


def evaluate_all(
    request: SweepRequest, sweep: SweepPoints, store: Store, pool: WorkerPool | None, progress: Progress
) -> SweepReport:
    """Evaluate all points of a sweep and return the report, without files. Raises as `make_sweep` does."""
    points = Points(sweep.space.keys, sweep.columns, sweep.main_number, keeps_rows=True)
    for values, done in _evaluate_points(sweep, store, pool, progress):
        points.add(values, done)
    return report.make_report(sweep, points, wish=request.wish)


def _evaluate_points(
    sweep: SweepPoints, store: Store, pool: WorkerPool | None, progress: Progress
) -> Iterator[tuple[tuple[Any, ...], Done]]:
    """Yield each point's values of the varied keys, and the evaluated point."""
    points = zip(sweep.space.rows(), evaluation.evaluate_points(sweep.points(), store, pool), strict=True)
    for number, (values, done) in enumerate(points, start=1):
        yield values, done
        progress("points", number, sweep.space.point_count)


def _load_finished(request: SweepRequest, sweep: SweepPoints, folder: Folder) -> SweepReport | None:
    """Return the report of an earlier run of the same sweep in the folder, or None if there is no complete one.

    It is incomplete if a file has changed, if pictures are missing, or if the request needs rows in its report.
    """
    facts = folder.earlier_manifest()
    unchanged = facts.get("request") == _sweep_hash(sweep) and "missing" in facts and folder.is_unchanged()
    if request.keeps_rows or not unchanged:
        return None
    if request.pictures and not any(name.endswith(".png") for name in facts["files"]):
        return None
    points = Points(sweep.space.keys, sweep.columns, sweep.main_number, keeps_rows=False)
    points.count = points.stored = sweep.space.point_count
    points.bad, points.missing, points.best = (facts[name] for name in ("bad", "missing", "best"))
    return report.add_files(report.make_report(sweep, points), folder.path, list(facts["files"]))


def _sweep_hash(sweep: SweepPoints) -> str:
    """Return the hash of all inputs of a sweep's table, as 64 hexadecimal digits."""
    text = json.dumps(_sweep_facts(sweep) | {"sources": digest()}, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()


def _sweep_facts(sweep: SweepPoints) -> dict[str, Any]:
    """Return every resolved input of a sweep, for the manifest."""
    shape = sweep.design.shape
    sample = sweep.space.sample
    return {
        "design": sweep.design.model_dump(mode="json"),
        "scene": sweep.scene.model_dump(mode="json"),
        "printer": sweep.printer and sweep.printer.model_dump(mode="json"),
        "body_sha256": shape.sha256,
        "axes": {axis.key: list(axis.values) for axis in sweep.space.axes},
        "sample": None if sample is None else sample._asdict(),
        "model": sweep.model,
        "keep": sweep.keep,
        "error": None if sweep.wanted is None else str(sweep.wanted),
    }


def _rename_changed_table(folder: Folder) -> list[str]:
    """Rename an earlier table in the folder if a user has changed it. Return a list with the warning, or an empty one.

    Raises InputError for a file that is no table of a sweep.
    """
    path = folder.path / table.TABLE_FILE
    if not path.exists():
        return []
    lines = table.find_changed_lines(path)
    if not lines and folder.is_file_unchanged(table.TABLE_FILE):
        return []
    kept = _free_path(folder.path / "table.edited.csv")
    try:
        path.replace(kept)
    except OSError as error:
        raise output.write_error(kept, error) from None
    where = ", ".join(map(str, lines[:5])) + (", ..." if len(lines) > 5 else "")
    which = f" in line {where}" if lines else ""
    return [f"{path}: was changed by hand{which}. All points were evaluated again. Your table is now {kept.name}"]


def _free_path(path: Path) -> Path:
    """Return the path or, if it exists, the path with the lowest free number added to its name."""
    number = 1
    free = path
    while free.exists():
        number += 1
        free = path.with_stem(f"{path.stem}-{number}")
    return free


def _write_other_files(sweep: SweepPoints, folder: Folder, result: SweepReport, pictures: bool, seconds: float) -> None:
    """Write Parquet, pictures (if requested) and the manifest of a finished table. `seconds`: time that it took."""
    folder.add_grown_file(table.TABLE_FILE)
    numeric = {axis.key: all(map(is_number, axis.values)) for axis in sweep.space.axes}
    keys = {key: numeric.get(key, True) for key in sweep.space.keys}
    if (data := table.to_parquet(folder.path / table.TABLE_FILE, keys, sweep.columns)) is not None:
        folder.write("table.parquet", data)
    if pictures:
        result.write_figures(folder)
    facts = {
        **_sweep_facts(sweep),
        "request": _sweep_hash(sweep),
        "sources": digest(),
        **{name: result.facts[name] for name in ("points", "known", "bad", "missing", "best")},
        "seconds": round(seconds, 3),
        "versions": versions(),
    }
    folder.finish(facts)
