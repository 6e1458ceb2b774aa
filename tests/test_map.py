"""docs/map.md is true of the tree: it names every room, and nothing that is not there."""

import re
from pathlib import Path

ROOT = Path(__file__).parent.parent
MAP = (ROOT / "docs" / "map.md").read_text(encoding="utf-8")
PATHS = [path.rstrip("/") for path in re.findall(r"`((?:walkergen|templates|tests)/[^`*]*)`", MAP)]


def test_every_path_of_the_map_exists():
    assert len(PATHS) > 30
    assert [path for path in PATHS if not (ROOT / path).exists()] == []


def test_every_room_and_every_file_outside_jobs_and_commands_is_on_the_map():
    package = ROOT / "walkergen"
    rooms = {path.parent for path in package.rglob("*.py")} - {package}
    assert {str(room.relative_to(ROOT)) for room in rooms} <= set(PATHS)
    named = set(re.findall(r"`(\w+)`", MAP)) | {Path(path).stem for path in PATHS}
    shared = [room for room in rooms if room.name in ("files", "numerics", "walker", "theory")]
    files = {path.stem for room in shared for path in room.glob("[!_]*.py")}
    files |= {path.stem for path in (package / "simulation").glob("[!_]*.py")}
    assert files <= named
