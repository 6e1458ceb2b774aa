"""The sweep itself: points evaluated, shared and taken up again; a table, pictures, a manifest."""

import hashlib
import json
import time
from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from walkergen.errors import InputError
from walkergen.exploring import run
from walkergen.exploring.crew import Crew
from walkergen.exploring.point import OK, STATUS, digest
from walkergen.exploring.request import Request
from walkergen.exploring.run import BLOCK, Done
from walkergen.exploring.store import Store
from walkergen.files import output
from walkergen.files.output import Folder, versions
from walkergen.files.progress import Progress
from walkergen.jobs.sweep import budget, table
from walkergen.jobs.sweep.table import Row, Table

if TYPE_CHECKING:
    from walkergen.jobs.sweep.panels import Columns

MOST_DRAWN = 200_000
"""Number of points up to which pictures are drawn; their memory grows with it."""


class Job(NamedTuple):
    """Choices of the sweep command."""

    request: Request
    title: str
    pictures: bool = True
    budget_s: float | None = None
    """Time for more runs where the error bars are worst, s; None for none."""


class Made(NamedTuple):
    """What a sweep made."""

    points: int
    """Number of points in the table."""
    known: int
    """Number of those that an earlier run, or another sweep, had evaluated."""
    bad: dict[str, int]
    """Number of points by what their status says, for all but "ok"."""
    files: tuple[Path, ...]
    told: tuple[str, ...]
    """Messages on an earlier table in the folder."""
    finished: bool = False
    """True when an earlier run had finished the same sweep, so that nothing was to do."""


def make(job: Job, path: Path, store: Store, crew: Crew | None, progress: Progress) -> Made:
    """Evaluate all points of a request into a folder: table.csv, table.parquet, sweep.png and .pdf.

    Points that the store, or a table in the folder, already has are not evaluated again; the table
    grows row by row, and what was finished is kept whatever happens. Raises InputError where
    another sweep writes there or a file there is not ours, OutputError when a file cannot be
    written, WalkergenError when a worker is lost, and KeyboardInterrupt with a whole table.
    """
    started = time.perf_counter()
    job.request.check()
    if job.budget_s is not None:
        budget.check(job.request)
    with Folder(path) as folder:
        folder.claim()
        if earlier := _finished(job, folder):
            return earlier
        told = _taken_up(job, folder, store)
        counts = _Counts()
        asked = job.request.asked()
        if job.budget_s is not None:
            asked = iter(budget.spend(job.request, job.budget_s, store, crew, progress))
        with _table(job, path) as rows:
            points = run.each(asked, store, crew)
            for number, (values, done) in enumerate(zip(_rows(job), points, strict=True), start=1):
                rows.add(values, done.record, done.key)
                counts.add(done)
                progress("points", number, job.request.space.points)
        files = _write_rest(job, folder, counts, time.perf_counter() - started)
    known = counts.known if job.budget_s is None else 0  # just now, by the budget
    return Made(counts.points, known, counts.bad, files, tuple(told))


class _Counts:
    """Numbers of points by how they went."""

    def __init__(self) -> None:
        self.points = self.known = 0
        self.bad: dict[str, int] = {}

    def add(self, done: Done) -> None:
        """Count a point."""
        self.points += 1
        self.known += done.known
        if done.record[STATUS] != OK:
            name = str(done.record[STATUS]).partition(":")[0].partition(" of ")[0]
            name = "error not met" if name.startswith("error ") else name
            self.bad[name] = self.bad.get(name, 0) + 1


def _rows(job: Job) -> Iterator[tuple[Any, ...]]:
    return job.request.space.rows()


def _table(job: Job, path: Path) -> Table:
    return Table(path / table.NAME, job.request.space.keys, _names(job))


def _names(job: Job) -> tuple[str, ...]:
    return table.columns(job.request.model, job.request.keep)


def _finished(job: Job, folder: Folder) -> Made | None:
    """Result of an earlier run of the same request, when all of its files are as it left them."""
    facts = folder.earlier()
    if job.budget_s is not None or facts.get("request") != _hash_of(job.request):
        return None
    if not folder.untouched() or (job.pictures and "sweep.png" not in facts["files"]):
        return None
    files = tuple(folder.path / name for name in facts["files"])
    points = job.request.space.points
    return Made(points, points, facts["bad"], files, (), finished=True)


def _hash_of(request: Request) -> str:
    """Hash of all that a sweep's table depends on."""
    text = json.dumps(_facts(request) | {"sources": digest()}, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()


def _facts(request: Request) -> dict[str, Any]:
    """A request for the manifest: every input resolved."""
    shape = request.design.body.shape
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


def _taken_up(job: Job, folder: Folder, store: Store) -> list[str]:
    """Put the sound rows of an earlier table into the store; tell what is wrong with it.

    A table in which somebody changed rows is kept under another name: its changes are not ours to
    lose, nor to trust. Raises InputError for a file that is no table of a sweep.
    """
    place, told = folder.path / table.NAME, []
    if not place.exists():
        return []
    sources = folder.earlier().get("sources", digest())
    if sources != digest():
        told.append(f"{place}: is of another version of walkergen; its points are evaluated anew")
    names, edited = _names(job), list[int]()
    lines = table.read(place)
    while block := list(islice(lines, BLOCK)):
        edited += [one for one in block if isinstance(one, int)]
        if sources == digest():
            _put_unknown([one for one in block if isinstance(one, Row)], names, store)
    if edited:
        kept = _free(folder.path / "table.edited.csv")
        try:
            place.replace(kept)
        except OSError as error:
            raise output.refused(kept, error) from None
        lines_told = ", ".join(map(str, edited[:5])) + (", ..." if len(edited) > 5 else "")
        told.append(
            f"{place}: changed by hand in line {lines_told}: these are evaluated anew; the changed "
            f"table is kept as {kept.name}"
        )
    return told


def _put_unknown(rows: Sequence[Row], names: Sequence[str], store: Store) -> None:
    known = store.get([row.point for row in rows])
    fresh = ((row.point, table.record_of(row, names)) for row in rows if row.point not in known)
    store.put((key, record) for key, record in fresh if record is not None)


def _free(path: Path) -> Path:
    """Name that is not taken: the path, or the path with a number."""
    number = 1
    found = path
    while found.exists():
        number += 1
        found = path.with_stem(f"{path.stem}-{number}")
    return found


def _write_rest(job: Job, folder: Folder, counts: _Counts, seconds: float) -> tuple[Path, ...]:
    """Write Parquet, pictures and the manifest of a finished table."""
    request, path = job.request, folder.path
    folder.add(table.NAME)
    numeric = {axis.key: all(map(_is_number, axis.values)) for axis in request.space.axes}
    keys = {key: numeric.get(key, True) for key in request.space.keys}
    if (data := table.to_parquet(path / table.NAME, keys, _names(job))) is not None:
        folder.write("table.parquet", data)
    if job.pictures and counts.points <= MOST_DRAWN:
        _draw(job, folder)
    facts = _facts(request) | {
        "request": "" if job.budget_s is not None else _hash_of(request), "sources": digest(),
        "points": counts.points, "known": counts.known, "bad": counts.bad,
        "seconds": round(seconds, 3), "versions": versions(),
    }  # fmt: skip
    folder.finish(facts)
    return tuple(path / name for name in folder.hashes)


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _draw(job: Job, folder: Folder) -> None:
    from walkergen.files.figures import pdf, png
    from walkergen.jobs.sweep import figures  # brings matplotlib

    keys = job.request.space.keys
    drawn = figures.figure(columns_of(folder.path / table.NAME, keys), keys, job.title)
    if drawn is not None:
        folder.write("sweep.png", png(drawn))
        folder.write("sweep.pdf", pdf(drawn))


def columns_of(path: Path, keys: Sequence[str]) -> "Columns":
    """Columns of a table for its pictures. Raises InputError for rows that were changed."""
    import numpy as np

    from walkergen.jobs.sweep.panels import Columns

    values: dict[str, list[Any]] = {key: [] for key in keys}
    numbers: dict[str, list[float]] = {"speed_mm_s": [], "low_95_mm_s": [], "high_95_mm_s": []}
    status = []
    for row in table.read(path):
        if isinstance(row, int):
            raise InputError(f"{path}:{row}: was changed by hand; run the sweep again")
        for key in keys:
            values[key].append(_as_value(row.values[key]))
        for name, found in numbers.items():
            found.append(float(row.values.get(name) or np.nan))
        status.append(row.values[STATUS])
    speed, low, high = (np.array(found) for found in numbers.values())
    return Columns(values, speed, low, high, status)


def _as_value(text: str) -> Any:
    try:
        return float(text)
    except ValueError:
        return text
