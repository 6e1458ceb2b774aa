"""Reports of calibrations and fits, and the files written with them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from walkergen.core import Design, Scene
from walkergen.core.files import output
from walkergen.core.files.output import Folder
from walkergen.files import templates
from walkergen.files.report import Report


class Setup(NamedTuple):
    """Walker and scene that a request names, as read from their files."""

    design: Design
    scene: Scene


@dataclass(frozen=True, kw_only=True, repr=False)
class LabReport(Report):
    """Material and contact from measurements, with the updated design and scene."""

    design: Design
    scene: Scene
    settings: Mapping[str, float]
    """Keys of design and scene, with their measured values."""
    notes: Sequence[str] = ()
    """Omissions and open questions."""


R = TypeVar("R", bound=LabReport)


def write_report(
    report: R, setup: Setup, choices: Mapping[str, Any], pictures: bool, comment: str = "", all_keys: bool = False
) -> R:
    """Write a report with the choices behind it into its folder, and return it.

    `setup` is the design and scene before the update, `choices` the other settings for the manifest. Unless `comment`
    is empty, it heads two more files: the updated scene and, if it changed, the design. `all_keys`: write also the keys
    that have their default values.
    """
    assert report.folder is not None
    with Folder(report.folder) as target:
        report.write(target, pictures)
        if comment:
            target.write("scene.toml", templates.to_toml(report.scene, comment, every=all_keys).encode())
            if report.design != setup.design:
                target.write("design.toml", templates.to_toml(report.design, comment, every=all_keys).encode())
        inputs = {"design": setup.design.model_dump(mode="json"), "scene": setup.scene.model_dump(mode="json")}
        target.finish({**inputs, **choices})
    return report


def name_after(original: str, path: Path, prefix: str = "") -> str:
    """Name a changed design or scene: its original name, "-", the prefix, and the name of the measurements' file."""
    return f"{original[:30]}-{prefix}{output.safe_folder_name(path)[:28]}"
