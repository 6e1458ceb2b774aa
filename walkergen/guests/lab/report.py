"""Report of the laboratory: results of readings, a simulated test or a fit, and the files written with it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from walkergen.core.files import output
from walkergen.core.files.output import Folder
from walkergen.core.scene import Scene
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.files.report import Report


@dataclass(frozen=True, kw_only=True, repr=False)
class LabReport(Report):
    """Material and contact from a test, with the updated design and scene."""

    design: Design
    scene: Scene
    settings: Mapping[str, float]
    """Keys of design and scene with the values that follow."""
    notes: Sequence[str] = ()
    """Omissions and open questions."""


R = TypeVar("R", bound=LabReport)


def write_report(report: R, job: Any, asked: Mapping[str, Any], comment: str = "", every: bool = False) -> R:
    """Report, once its folder holds it with what was asked, a `job` of design, scene and pictures.

    With a comment, scene and design as they go on are files as well, with `every` key or those set; a design that
    nothing changed is none.
    """
    assert report.folder is not None
    with Folder(report.folder) as target:
        report.write(target, job.pictures)
        if comment:
            target.write("scene.toml", templates.to_toml(report.scene, comment, every=every).encode())
            if report.design != job.design:
                target.write("design.toml", templates.to_toml(report.design, comment, every=every).encode())
        inputs = {"design": job.design.model_dump(mode="json"), "scene": job.scene.model_dump(mode="json")}
        target.finish({**inputs, **asked})
    return report


def name_after(original: str, path: Path, word: str = "") -> str:
    """Name of a design or scene after the file that it was measured by: never that of a shipped one."""
    return f"{original[:30]}-{word}{output.safe_folder_name(path)[:28]}"
