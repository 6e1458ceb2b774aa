"""Files of a page's walker for download, made by the commands that a user would type."""

import hashlib
import io
import json
import zipfile
from pathlib import Path
from typing import Any, NamedTuple

from walkergen.app import document as documents
from walkergen.app import walker_answers
from walkergen.app.document import Document
from walkergen.core.errors import InputError
from walkergen.core.files import file_reading
from walkergen.core.files.config import Section
from walkergen.core.files.output import Folder
from walkergen.core.printing.packing import MAX_PARTS
from walkergen.core.walker.body import BUILTIN_OUTLINES
from walkergen.files import templates

FILE_PATTERNS = {
    "stl": "stl/*.stl",
    "3mf": "3mf/*.3mf",
    "plate": "plates/*",
    "page": "family/report.html",
    "toml": "settings/*",
    "zip": "**/*",
}
"""Patterns of the paths of the files that a page offers for download, by the name of the choice."""

FORMATS = tuple(FILE_PATTERNS)

SWEEP_OPTIONS = {
    "legs.tilt_deg": ("--set", "legs.tilt_deg=2:40:1", "--set", "legs.length_mm=5:10:0.5"),
    "leg_tilt_deg": ("--set", "leg_tilt_deg=4:40:4", "--model", "space", "--error", "10%"),
}
"""Options of a sweep that searches for a speed, by the key of the tilt. Two equal legs are predicted, not simulated."""


class FileChoice(NamedTuple):
    """Choice of the files that a page requests."""

    what: str
    """Name of the choice, one of FORMATS."""
    copies: int
    """Number of copies on a plate."""


def parse_choice(what: Any, copies: Any) -> FileChoice:
    """Validate a page's choice of files and number of copies. Raises InputError."""
    if not isinstance(what, str) or what not in FORMATS:
        raise InputError(f"{documents.SOURCE}: what: must be one of {', '.join(FORMATS)}")
    if isinstance(copies, bool) or not isinstance(copies, int) or not 1 <= copies <= MAX_PARTS:
        raise InputError(f"{documents.SOURCE}: copies: must be a whole number in 1..{MAX_PARTS}")
    return FileChoice(what, copies)


def file_commands(document: Document, choice: FileChoice, folder: Path) -> list[list[str]]:
    """Return the command-line arguments of each command that makes the chosen files, in order. Raises InputError."""
    target = target_folder(document, folder)
    out = ("--out", str(target))
    commands = {
        "stl": documents.arguments(document, "export", "--format", "stl", *out),
        "3mf": documents.arguments(document, "export", "--format", "3mf", *out),
        "plate": documents.arguments(document, "plate", "--copies", str(choice.copies), *out),
        "page": documents.arguments(document, "family", "--page", "--out", str(target / "family")),
    }
    return [words for name, words in commands.items() if choice.what in (name, "zip")]


def target_folder(document: Document, folder: Path) -> Path:
    """Return the folder, below `folder`, of one document's files. Raises InputError for an invalid document."""
    digest = hashlib.sha256(json.dumps(document, sort_keys=True).encode()).hexdigest()[:8]
    return folder / f"{walker_answers.part_name(document)}-{digest}"


def collect_files(document: Document, choice: FileChoice, folder: Path) -> tuple[str, bytes, list[list[str]]]:
    """Return three things: name and bytes of the chosen file or of a zip archive, and the commands that made it.

    Raises InputError if these commands have not run, OutputError for settings that cannot be written.
    """
    commands, target = file_commands(document, choice, folder), target_folder(document, folder)
    if choice.what in ("toml", "zip"):
        _write_settings(document, target)
    paths = sorted(path for path in target.glob(FILE_PATTERNS[choice.what]) if path.is_file())
    paths = [path for path in paths if not path.name.startswith(".")]
    if not paths:
        raise InputError(f"{documents.SOURCE}: these files have not been made yet. Make them first.")
    if len(paths) == 1:
        return paths[0].name, paths[0].read_bytes(), commands
    what = "" if choice.what == "zip" else f"-{choice.what}"
    return f"{target.name}{what}.zip", _zip_files(target, paths), commands


def _zip_files(folder: Path, paths: list[Path]) -> bytes:
    """Return a zip archive of files below `folder`. It contains no dates, so equal files give equal archives."""
    target = io.BytesIO()
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        for path in paths:
            entry = zipfile.ZipInfo(path.relative_to(folder).as_posix())
            archive.writestr(entry, path.read_bytes(), zipfile.ZIP_DEFLATED)
    return target.getvalue()


def _write_settings(document: Document, folder: Path) -> None:
    """Write walker, scene and printer as TOML files into settings/ below `folder`, with the body's drawing or mesh."""
    design = document.load_design().with_explicit_leg_positions()
    alone: dict[str, Any] = {"tilt_deg": [design.tilt_deg]}  # a family of this walker alone
    alone |= {"legs": [design.kind]} if design.has_legs_table else {}
    family = design.family.model_copy(update=alone)
    design = design.model_copy(update={"family": family})
    with Folder(folder, "") as target:
        for key, name in (("mesh", design.body.mesh), ("outline", design.body.outline)):
            if name is not None and name not in BUILTIN_OUTLINES:
                data = file_reading.read_bytes(Path(name))
                target.write(f"settings/{Path(name).name}", data)
                body = design.body.model_copy(update={key: Path(name).name})
                design = design.model_copy(update={"body": body})
        sections: dict[str, Section] = {
            "walker": design,
            "scene": document.load_scene(),
            "printer": document.load_printer(),
        }
        for name, section in sections.items():
            text = templates.to_toml(section, f"The {name} of {design.name}, from its page", every=False)
            target.write(f"settings/{name}.toml", text.encode())


def sweep_arguments(document: Document, speed: Any, folder: Path) -> list[str]:
    """Return command-line arguments of a sweep of tilts that searches for a speed (mm/s).

    Its table begins with the nearest speeds. Its files go to `folder`. Raises InputError if `speed` is no number, and
    for a walker whose legs have no common tilt.
    """
    if isinstance(speed, bool) or not isinstance(speed, (int, float)):
        raise InputError(f"{documents.SOURCE}: speed: must be a number")
    design = document.load_design()
    key = documents.tilt_key(design)
    if key is None:
        raise InputError(f"{documents.SOURCE}: {design.name}: its legs have no common tilt to search")
    words = SWEEP_OPTIONS[key]
    varied = {word.partition("=")[0] for word in words}
    fixed = document._replace(values={name: value for name, value in document.values.items() if name not in varied})
    words += ("--keep", "speed,spread,printability", f"--wish={speed!r}")
    return documents.arguments(fixed, "sweep", *words, "--no-pictures", "--json", "--out", str(folder))
