"""The table of a scene's keys is made from its fields: `python tests/core/test_scene_keys.py` writes it again."""

import ast
import inspect
import textwrap
from itertools import pairwise
from pathlib import Path
from typing import Literal, get_args, get_origin

from walkergen.core.files import config
from walkergen.core.scene import Scene

PAGE = Path(__file__).parents[2] / "docs" / "scenes.md"
MAX_KEYS = 60
"""Keys of a scene, which may only become fewer."""

HEAD = """# The keys of a scene

A scene describes everything outside the walker: the plate and its motion, the contact of foot and plate, walls, and the
simulated runs. It is a text file (TOML) with a table for each heading below. Every key has a default, so a file holds
only keys that differ. To start, run `walkergen templates copy lane-90hz my.toml`. To set a key for one command, add for
example `--set scene.drive.gamma=2.2`. Standard deviations (`_sd`) widen the bounds of predictions and change nothing
else. The axis x is the direction of heading 0. "The paper" is [Koumakis et al. (2016)](physics.md).

*`python tests/core/test_scene_keys.py` writes this page from `walkergen/core/scene.py` and `walkergen/core/drive.py`.*
"""


def notes(table):
    """Return the docstrings below the fields of a table, by key."""
    (node,) = ast.parse(textwrap.dedent(inspect.getsource(table))).body
    return {
        key.target.id: " ".join(note.value.value.replace("None: ", "Default: ").split())
        for key, note in pairwise(node.body)
        if isinstance(key, ast.AnnAssign) and isinstance(note, ast.Expr)
    }


def rows(name, table):
    """Return a row of the page for each key of a table."""
    meanings, before = notes(table), ""
    for key, field in table.model_fields.items():
        default = getattr(getattr(Scene(), name), key) if name != "drive" else field.default
        allowed = config.describe_allowed_values((name, key), Scene).removeprefix("must be ").removeprefix("a number ")
        allowed = allowed.removeprefix("a whole number ").removeprefix("one of ").replace("'", "").replace("|", "or")
        types = {get_origin(kind) for kind in get_args(field.annotation)}
        allowed += ", or numbers" if Literal in types and types & {list, tuple} else ""
        allowed = allowed[3:].replace(" and <= ", " to ") if allowed.startswith(">= ") else allowed
        shown = "" if default is None else f"`{list(default) if isinstance(default, tuple) else default}`"
        allowed, before = ("as above" if len(allowed) > 80 and allowed == before else allowed), allowed
        yield f"| `{key}` | {meanings[key]} | {shown} | {allowed} |"


def page():
    """Return the whole page."""
    parts = [HEAD]
    for name, field in Scene.model_fields.items():
        table = field.annotation
        if name in ("name", "description"):
            continue
        parts.append(f"## [{name}]\n\n{' '.join(inspect.getdoc(table).split(chr(10) * 2)[0].split())}\n")
        parts.append(
            "\n".join(["| key | meaning | default | allowed |", "|---|---|---|---|", *rows(name, table)]) + "\n"
        )
    return "\n".join(parts)


def test_the_page_of_keys_matches_the_fields():
    assert PAGE.read_text(encoding="utf-8") == page(), "run python tests/core/test_scene_keys.py"


def test_a_scene_has_few_keys():
    tables = [field.annotation for field in Scene.model_fields.values()]
    assert sum(len(getattr(table, "model_fields", "1")) for table in tables) <= MAX_KEYS


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
