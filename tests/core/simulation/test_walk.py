"""What a plain two-legged walker passes through from TOML to a predicted speed: no part that it lacks."""

import json
import subprocess
import sys

import pytest

MODULES, FILES = 66, 43
"""Most modules of ours that a fresh `predict` imports, and most files below the command line of
which it runs a function; the request, which the command and the function of Python share, is among both."""

ABSENT_MODULES = {
    *(
        "walkergen.core.dish",
        "walkergen.readers.walkers.marks",
        "walkergen.readers.walkers.caps",
        "walkergen.core.walker.pockets",
    ),
    *("walkergen.readers.walkers.leg_attachment", "walkergen.readers.walkers.stance"),
    *("walkergen.core.shapes.joining", "walkergen.core.theory.balance"),
}
"""Modules of parts that it has not."""

MEASURING_SCRIPT = """
import inspect, json, os, sys
import walkergen

root, entered = os.path.dirname(walkergen.__file__), set()
FUNCTION = inspect.CO_NEWLOCALS | inspect.CO_OPTIMIZED

def trace(frame, event, argument):
    code = frame.f_code  # bodies of modules and classes are no functions
    if code.co_filename.startswith(root) and code.co_flags & FUNCTION == FUNCTION:
        entered.add(os.path.relpath(code.co_filename, root))

from walkergen.cli import command_line

sys.settrace(trace)
try:
    command_line(["predict", *sys.argv[1:], "--json"])
except SystemExit:
    pass
sys.settrace(None)
imported = [name for name in sys.modules if name.split(".")[0] == "walkergen"]
print(json.dumps([imported, sorted(entered)]), file=sys.stderr)
"""


def visited_files(*words):
    """Modules that a prediction imports, and files that it enters."""
    run = subprocess.run([sys.executable, "-c", MEASURING_SCRIPT, *words], check=True, capture_output=True, text=True)
    return json.loads(run.stderr.splitlines()[-1])


def test_a_plain_walker_enters_only_the_files_that_it_needs():
    imported, entered = visited_files("koumakis2016", "--tilt", "10")
    assert len(imported) <= MODULES, sorted(imported)
    imported = [name for name in imported if not f"{name}.effects.".startswith("walkergen.core.simulation.effects.")]
    others = ("walkergen.core.printing", "walkergen.core.simulation.", "walkergen.commands.family", "walkergen.guests")
    assert not [name for name in imported if name in ABSENT_MODULES or name.startswith(others)]
    below = [name for name in entered if name.partition("/")[0] not in ("cli", "__init__.py", "__main__.py")]
    assert len(below) <= FILES, below


@pytest.mark.parametrize(
    ("words", "needed"),
    [
        (("coinbot", "--scene", "table-motor", "--model", "theory"), {"core/walker/pockets.py"}),
        (("--set", "marks.kind=digits"), {"readers/walkers/marks.py"}),
        (("--legs", "braced"), {"core/walker/sections/braced.py"}),
    ],
)
def test_a_walker_enters_the_parts_that_it_has(words, needed):
    assert needed <= set(visited_files(*words, "--tilt", "10")[1])
