"""docs/map.md is true of the tree: it names every room, and nothing that is not there."""

import ast
import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
MAP = (ROOT / "docs" / "map.md").read_text(encoding="utf-8")
PATHS = [path.rstrip("/") for path in re.findall(r"`((?:walkergen|templates|tests)/[^`*]*)`", MAP)]


def test_every_path_of_the_map_exists():
    assert len(PATHS) > 30
    assert [path for path in PATHS if not (ROOT / path).exists()] == []


def test_every_folder_is_on_the_map_and_every_line_is_a_folder():
    package = ROOT / "walkergen"
    rooms = {path.parent for path in package.rglob("*.py")} - {package}
    assert {str(room.relative_to(ROOT)) for room in rooms} <= set(PATHS)
    rows = [line for line in MAP.partition("## Where")[0].splitlines() if line.startswith("| `")]
    assert max(len(row.rpartition("` |")[2].split()) for row in rows) <= 45


def test_every_file_begins_with_its_content():
    for path in (ROOT / "walkergen").rglob("*.py"):
        assert path.read_text(encoding="utf-8").startswith('"""'), path


def test_every_equation_that_the_code_cites_is_numbered_once():
    physics = (ROOT / "docs" / "physics.md").read_text(encoding="utf-8")
    numbered = re.findall(r"\((\d\.\d+)[);]", physics)
    code = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "walkergen").rglob("*.py"))
    cited = set(re.findall(r"[Ee]q\. (\d\.\d+)", code))
    assert len(numbered) == len(set(numbered))
    assert len(cited) >= 20
    assert cited <= set(numbered)


ARROWS = set(re.findall(r"^ {4}(\w+)(?:\[.*?\])? --> (\w+)", MAP, re.MULTILINE))


def imports():
    """Pairs of rooms of the flowchart, the first of which imports something of the second."""
    package, drawn = ROOT / "walkergen", {room for arrow in ARROWS for room in arrow}
    for path in package.rglob("*.py"):
        room = path.relative_to(package).parts[0].removesuffix(".py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            module = getattr(node, "module", None) or ""
            if isinstance(node, ast.ImportFrom) and module.split(".")[0] == "walkergen":
                names = module.split(".")[1:2] or [alias.name for alias in node.names]
                yield from ((room, name) for name in names if {room, name} <= drawn)


def below(room):
    """Rooms that arrows lead to from a room."""
    ways = {end for start, end in ARROWS if start == room}
    return ways.union(*map(below, ways))


def test_the_flowchart_draws_the_imports():
    folders = {path.parent.name for path in ROOT.glob("walkergen/*/__init__.py")}
    assert folders <= {room for arrow in ARROWS for room in arrow}
    real = {(start, end) for start, end in imports() if start != end}
    assert set() == ARROWS - real  # each arrow is an import
    assert [pair for pair in sorted(real) if pair[1] not in below(pair[0])] == []
