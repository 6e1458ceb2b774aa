"""The sweep itself: points evaluated, shared and taken up again; a table, pictures, a manifest."""

import hashlib
import json
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from walkergen.core import Folder, Progress, versions
from walkergen.core.files import output
from walkergen.core.files.formatting import is_number
from walkergen.guests.sweep import evaluation as run
from walkergen.guests.sweep import report, table
from walkergen.guests.sweep.evaluation import Done
from walkergen.guests.sweep.point_request import Request
from walkergen.guests.sweep.report import Points, SweepReport
from walkergen.guests.sweep.table import Table
from walkergen.points.point import STATUS_KEY, digest
from walkergen.points.store import Store
from walkergen.points.worker_pool import WorkerPool

MAX_DRAWN_POINTS = 200_000
"""Largest number of points that are drawn; memory grows with it."""


class Job(NamedTuple):
    """Choices of the sweep command."""

    request: Request
    title: str
    pictures: bool = True
    kept: bool = False
    """True for a report that holds every row."""
    wish: float | None = None
    """Wished speed for sorting the report's rows, mm/s; None for rows in their order."""

    @property
    def drawn(self) -> bool:
        """True when pictures are drawn."""
        return self.pictures and self.request.space.points <= MAX_DRAWN_POINTS


def make_sweep(job: Job, path: Path, store: Store, pool: WorkerPool | None, progress: Progress) -> SweepReport:
    """Evaluate all points of a request into a folder: table.csv, table.parquet, and pictures.

    Pictures are sweep.png and .pdf, of crowds one of each statistic. Points that the store already has are not
    evaluated again. The table grows row by row, and finished rows are always kept. Raises InputError if another sweep
    writes there or a file there is not ours, OutputError when a file cannot be written, WalkergenError when a worker is
    lost, and KeyboardInterrupt with a complete table.
    """
    started = time.perf_counter()
    job.request.check()
    with Folder(path) as folder:
        folder.claim()
        if earlier := _load_finished(job, folder):
            return earlier
        warnings = _set_aside(folder)
        points = Points(_column_names(job), job.kept or job.drawn or job.wish is not None)
        folder.start_growing_file(table.TABLE_FILE)
        with Table(path / table.TABLE_FILE, job.request.space.keys, points.names) as rows:
            for values, done in _evaluate_points(job, store, pool, progress):
                rows.add(values, done.record, done.key)
                points.add(values, done)
        result = report.make_report(job.request, job.title, points, warnings, job.wish)
        _write_rest(job, folder, result, time.perf_counter() - started)
    return report.add_files(result, path, list(folder.hashes))


def evaluate_all(job: Job, store: Store, pool: WorkerPool | None, progress: Progress) -> SweepReport:
    """Evaluate all points of a request, without a folder. Raises as `make_sweep` does."""
    points = Points(_column_names(job), kept=True)
    for values, done in _evaluate_points(job, store, pool, progress):
        points.add(values, done)
    return report.make_report(job.request, job.title, points, wish=job.wish)


def _evaluate_points(
    job: Job, store: Store, pool: WorkerPool | None, progress: Progress
) -> Iterator[tuple[tuple[Any, ...], Done]]:
    """Values of the keys at each point, and the evaluated point."""
    space = job.request.space
    points = zip(space.rows(), run.evaluate_points(job.request.points(), store, pool), strict=True)
    for number, (values, done) in enumerate(points, start=1):
        yield values, done
        progress("points", number, space.points)


def _column_names(job: Job) -> tuple[str, ...]:
    request = job.request
    return (*request.kind.columns(request.model, request.keep), STATUS_KEY)


def _load_finished(job: Job, folder: Folder) -> SweepReport | None:
    """Return the report of an earlier run of the same request if all of its files are unchanged.

    None if the rows are wanted: the manifest does not contain them.
    """
    facts, again = folder.earlier_manifest(), job.kept or job.wish is not None
    if again or facts.get("request") != _request_hash(job.request):
        return None
    if not folder.is_unchanged() or (job.pictures and not any(name.endswith(".png") for name in facts["files"])):
        return None
    count = job.request.space.points
    points = Points(_column_names(job), False, count, count, facts["bad"])
    result = report.make_report(job.request, job.title, points)
    return report.add_files(result, folder.path, list(facts["files"]))


def _request_hash(request: Request) -> str:
    """Compute the hash of all inputs of a sweep's table."""
    text = json.dumps(_request_facts(request) | {"sources": digest()}, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()


def _request_facts(request: Request) -> dict[str, Any]:
    """Return every resolved input of a request, for the manifest."""
    shape = request.design.shape
    sample = request.space.sample
    return {
        "design": request.design.model_dump(mode="json"),
        "scene": request.scene.model_dump(mode="json"),
        "printer": request.printer and request.printer.model_dump(mode="json"),
        "body_sha256": shape.sha256,
        "axes": {axis.key: list(axis.values) for axis in request.space.axes},
        "sample": None if sample is None else sample._asdict(),
        "model": request.model,
        "keep": request.keep,
        "error": None if request.wanted is None else str(request.wanted),
    }


def _set_aside(folder: Folder) -> list[str]:
    """Keep an earlier table with a user's changes under another name, and report it.

    A user's changes are kept but not trusted. Raises InputError for a file that is no table of a sweep.
    """
    place = folder.path / table.TABLE_FILE
    if not place.exists():
        return []
    lines = table.find_changed_lines(place)
    if not lines and folder.is_file_unchanged(table.TABLE_FILE):
        return []
    kept = _free_path(folder.path / "table.edited.csv")
    try:
        place.replace(kept)
    except OSError as error:
        raise output.write_error(kept, error) from None
    where = ", ".join(map(str, lines[:5])) + (", ..." if len(lines) > 5 else "")
    which = f" in line {where}" if lines else ""
    return [f"{place}: changed by hand{which}: evaluated anew; the changed table is kept as {kept.name}"]


def _free_path(path: Path) -> Path:
    """Name that is not taken: the path, or the path with a number."""
    number = 1
    free = path
    while free.exists():
        number += 1
        free = path.with_stem(f"{path.stem}-{number}")
    return free


def _write_rest(job: Job, folder: Folder, result: SweepReport, seconds: float) -> None:
    """Write Parquet, pictures and the manifest of a finished table."""
    request = job.request
    folder.add_grown_file(table.TABLE_FILE)
    numeric = {axis.key: all(map(is_number, axis.values)) for axis in request.space.axes}
    keys = {key: numeric.get(key, True) for key in request.space.keys}
    if (data := table.to_parquet(folder.path / table.TABLE_FILE, keys, _column_names(job))) is not None:
        folder.write("table.parquet", data)
    if job.drawn:
        result.write_figures(folder)
    facts = {
        **_request_facts(request),
        "request": _request_hash(request),
        "sources": digest(),
        **{name: result.facts[name] for name in ("points", "known", "bad")},
        "seconds": round(seconds, 3),
        "versions": versions(),
    }
    folder.finish(facts)
