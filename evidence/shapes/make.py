"""Shapes put to the test: each is built, checked for a printer and run for a moment; what fails gets its remedy."""

import tempfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from evidence.shapes import drawings, meshes, texts
from walkergen import inputs
from walkergen.commands.check import make as checks
from walkergen.commands.simulate.report import SimulationReport
from walkergen.commands.simulate.request import SimulateRequest
from walkergen.core.errors import WalkergenError
from walkergen.core.files.output import Folder
from walkergen.core.files.progress import Progress, silent
from walkergen.core.printing import findings
from walkergen.core.printing.printers import Printer
from walkergen.core.walker.design import Design
from walkergen.files import report, templates
from walkergen.files.report import Report

KINDS = ("drawings", "meshes", "names")

SCENE, PRINTER, TILT_DEG, SECONDS, RUNS = "plane-90hz", "prusa-mk3s", 10.0, 0.5, 2
"""What every shape is run and printed with."""

REMEDIES: Mapping[str, Mapping[str, Any]] = {
    "comb.svg": {"body.base": True},
    "ball-4.stl": {"body.base": True},
    "tower.stl": {"body.base": True},
    "pyramid.stl": {"body.base": True},
    "cone.stl": {"body.base": True},
    "block-in-inches.stl": {"body.scale_mm": 25.4},
}
"""Remedies that the messages name for shapes without stable legs."""


class Row(NamedTuple):
    """Shape and what became of it."""

    kind: str
    shape: str
    stands: str
    """yes, or why not."""
    legs: str
    warnings: int | None
    """Warnings of the check before printing."""
    speed_mm_s: float | None
    speed_se_mm_s: float | None
    """Speed forward of the runs, and its standard error."""
    remedy: str
    """Keys set to make the shape stand."""

    @property
    def good(self) -> bool:
        """True for a shape that stands, prints without errors and runs forward."""
        return self.speed_mm_s is not None and self.speed_mm_s > 0.0


def check_shapes(kinds: Sequence[str], folder: Path, progress: Progress) -> Report:
    """Try the shapes of some kinds, and write the table."""
    rows: list[Row] = []
    with tempfile.TemporaryDirectory() as home:
        cases = [(kind, source) for kind in kinds for source in _write_sources(kind, Path(home))]
        for number, (kind, source) in enumerate(cases, start=1):
            rows += _try_shape(kind, source)
            progress(rows[-1].shape, number, len(cases))
    good = sum(row.good for row in rows if not row.remedy)
    columns = [
        report.text_column("kind", "kind"),
        report.text_column("shape", "shape"),
        report.text_column("with", "remedy"),
        report.text_column("stands", "stands"),
        report.text_column("legs", "legs"),
        report.number_column("warnings", "warnings"),
        report.error_column("speed\n(mm/s)", "speed_mm_s", "speed_se_mm_s"),
    ]
    title = f"{good} of {len(cases)} shapes stand, print and run forward unchanged"
    table = report.table_from_rows("shapes", rows, columns, title)
    written = Report(
        name="shapes", title="Shapes that people bring", tables=[table], facts={"good": good}, folder=folder
    )
    with Folder(folder, "") as target:
        written.write(target, pictures=False)
    return written


def _write_sources(kind: str, home: Path) -> Iterator[Path | str]:
    """Files of a kind, written; or texts."""
    if kind == "names":
        yield from texts.NAMES
        return
    for name, data in {"drawings": drawings, "meshes": meshes}[kind].every().items():
        (home / name).write_bytes(data)
        yield home / name


def _try_shape(kind: str, source: Path | str) -> list[Row]:
    """Return the row of an unchanged shape, and one with its remedy where it needs one."""
    name = source if isinstance(source, str) else source.name
    first = _make_row(kind, name, source, {})
    if first.good or name not in REMEDIES:
        return [first]
    return [first, _make_row(kind, name, source, REMEDIES[name])]


def _make_row(kind: str, name: str, source: Path | str, keys: Mapping[str, Any]) -> Row:
    remedy = ", ".join(f"{key} = {str(value).lower()}" for key, value in keys.items())
    try:
        design = _load_design(source, keys).variant(tilt_deg=TILT_DEG)
        checked = checks.check([design], [1], templates.load(PRINTER, "printers", Printer))
        findings.check_printable(checked.findings, strict=False)
        warnings = sum(finding.level == "warning" for finding in checked.findings)
        asked = SimulateRequest.from_values({"design": design, "scene": SCENE, "seconds": SECONDS, "runs": RUNS})
        speed, error = _mean_speed(asked.run(silent))
    except WalkergenError as mistake:
        return Row(kind, name, str(mistake).splitlines()[0].replace(str(source), name), "", None, None, None, remedy)
    return Row(kind, name, "yes", design.notes[-1].partition(": ")[2], warnings, speed, error, remedy)


def _load_design(source: Path | str, keys: Mapping[str, Any]) -> Design:
    """Walker of one word, with keys set as on a command line. Raises InputError."""
    asked = inputs.from_settings(keys, {}, ["design"])
    if isinstance(source, Path) and keys:  # a file that needs a remedy
        own = {"body.mesh" if source.suffix == ".stl" else "body.outline": str(source)}
        return asked._replace(values={**own, **keys}).design("koumakis2016")
    if isinstance(source, str):
        return asked._replace(values={"body.text": source, **keys}).design("koumakis2016")
    return asked.design(source)


def _mean_speed(result: SimulationReport) -> tuple[float | None, float | None]:
    """Speed along the run and its standard error, mm/s."""
    speed = result.summary.speed
    return speed.value, speed.se
