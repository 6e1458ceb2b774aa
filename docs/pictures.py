"""Every picture of docs/, made again by its command; each says inside which code made it.

`make pictures` makes those whose code has moved on, `make pictures ONLY=choice,speed` these in any
case, ONLY=all every one. A killed run goes on where it was: a picture is written when it is made.
"""

import ast
import functools
import hashlib
import io
import json
import os
import shlex
import shutil
import struct
import subprocess
import sys
import tempfile
import time
import tokenize
import tomllib
import zlib
from collections.abc import Callable, Sequence
from itertools import groupby
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT))  # the code beside this file, installed or not

from PIL import Image  # noqa: E402

from walkergen import __version__  # noqa: E402
from walkergen.core.files import output  # noqa: E402
from walkergen.core.numerics import kernels  # noqa: E402

STYLE = ("walkergen/files/figures.py",)
SIMULATION = tuple(f"walkergen/{pattern}" for pattern in kernels.SOURCE_PATTERNS)
MEASURES = ("walkergen/analysis/landings.py", *(f"evidence/{name}.py" for name in ("curves", "landings", "quantities")))
SCENES = ("walkergen/core/scene.py", "templates/scenes/*.toml")
PREDICTION = ("walkergen/core/theory/*.py", "walkergen/core/theory/*.npz", *SCENES)
WALKER = (
    "walkergen/core/shapes/*.py",
    "walkergen/core/walker/*.py",
    "walkergen/readers/*/*.py",
    "templates/walkers/*.toml",
)

PAGE = ("walkergen/files/viewer.py", "walkergen/files/web_page.py", "walkergen/files/assets/pa*", "viewer/*.js")

FAMILY = "walkergen family koumakis2016"
MOVIE = "walkergen movie koumakis2016 --scene lane-90hz --tilt 10 --restitution 0.3 --periods 3 --slow 150"
MAP = "walkergen sweep koumakis2016 --set legs.tilt_deg=0:40:1 --set scene.contact.restitution=0.4:1:0.05"
CHOICE = "walkergen accuracy koumakis2016 --scene lane-90hz --tilt 5"
ACCURACY = "walkergen/commands/accuracy"
SHIPPED = ("answers.py", "cells.py", "cells.csv", "choice.py", "figures.py", "cell_estimates.py", "step_law.py")
SIMULATED = (
    "walkergen family koumakis2016 --scene plane-90hz --simulate --set scene.run.seconds=2 --set scene.run.runs=8"
)
REPRODUCE = "python -m evidence reproduce --seconds 6 --gamma 1.5,1.8"
VALIDATE = "python -m evidence validate"
CROWD = "walkergen crowd koumakis2016 --count 30 --arena disc:170 --seconds 2 --runs 2"
OTHERS = {
    "two-materials": "rough foot behind, smooth ahead",
    "unequal-legs": "short leg near the middle",
    "polar-disc": "rubber skate and hard tip",
    "bristle": "18 short flexible legs",
    "rotator": "left legs lean back, right ones ahead",
    "name": "letters between two rails",
}
"""Templates of other mechanisms than the paper's, each with the words below its picture."""

OWN_SHAPES = ("heart.svg", "duck.stl", "ANNA")
"""Two files and a text, as people bring them."""

WINDOW = (1215, 845)
APP_WINDOW = (1440, 900)
"""Width and height of the browser's window, pixels."""


class Picture(NamedTuple):
    """Picture of docs/: how it is made, and of what."""

    name: str
    command: str
    """Command whose folder has it; "" for one that is drawn here."""
    sources: Sequence[str]
    """Patterns of the files that say what it shows; those of all that is imported would change
    with every commit, and the picture with few of them."""
    seconds: int
    """Time that it took on two cores, s, with the kernels compiled; 0 of one that another's
    command makes too."""
    made: str | Callable[[Path], bytes]
    """Its name in that folder, or the function that makes it there."""
    beside: tuple[str, ...] = ()
    """Other files of that folder that are kept in docs/ with it."""
    program: str = ""
    """Program of others without which it cannot be made."""
    package: str = ""
    """Package of Debian that has the program."""
    shown: str = ""
    """Commands by which people see it, a line each, where `command` is not what they would run."""


def mechanisms(folder: Path) -> bytes:
    """Picture of the templates of other mechanisms, to one scale."""
    from walkergen.commands.family.preview import Part, preview_figure
    from walkergen.core.walker import solids
    from walkergen.core.walker.design import Design
    from walkergen.files import figures, templates

    designs = {name: templates.load(name, "walkers", Design) for name in OTHERS}
    parts = [
        Part(design, solids.build(design).walker, f"{name}\n{OTHERS[name]}", low=True)
        for name, design in designs.items()
    ]
    return figures.png(preview_figure(parts, "Walkers of other mechanisms, as templates"), 150)


def own_shapes(folder: Path) -> bytes:
    """Picture of a drawing, a mesh and a name on legs that placed themselves, with their speeds."""
    from evidence.shapes import drawings, meshes
    from walkergen import inputs
    from walkergen.commands.family.preview import Part, preview_figure
    from walkergen.commands.predict import make as predicting
    from walkergen.core.theory import prediction
    from walkergen.files import figures

    scene = inputs.from_settings({}, {}, ["scene"]).scene("lane-90hz")
    parts = []
    for shape in OWN_SHAPES:
        asked = inputs.from_settings({"body.text": shape} if "." not in shape else {}, {}, ["design"])
        if "." in shape:
            (folder / shape).write_bytes((drawings.every() | meshes.every())[shape])
        design = asked.design(str(folder / shape) if "." in shape else "koumakis2016").variant(tilt_deg=10.0)
        (member,) = predicting.predict(design, [design], scene, "coulomb").members
        parts.append(Part(design, member.mesh, shape, low=True, speed=prediction.describe_briefly(member.row)))
    return figures.png(preview_figure(parts, "A drawing, a mesh, a name: legs place themselves"), 150)


def surrogate(folder: Path) -> bytes:
    """Picture of the surrogate beside direct runs, from their table."""
    from evidence.tables import held_out

    return held_out.picture(held_out.read())


def page(folder: Path) -> bytes:
    """Picture of a family's page in a browser."""
    return browser(folder, (folder / "report.html").as_uri(), *WINDOW)


def app(folder: Path) -> bytes:
    """Picture of the page on which a walker is designed."""
    words = [sys.executable, "-m", "walkergen", "app", "--port", "0", "--no-browser"]
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    with subprocess.Popen(words, cwd=folder, env=environment, stdout=subprocess.PIPE, text=True) as server:
        assert server.stdout is not None
        address = server.stdout.readline().split()[-1]
        try:
            return browser(folder, address, *APP_WINDOW)
        finally:
            server.terminate()


def browser(folder: Path, address: str, width: int, height: int) -> bytes:
    """Picture of a page in a browser."""
    shot = folder / "shot.png"
    command = [
        "chromium",
        "--headless",
        "--no-sandbox",
        "--hide-scrollbars",
        "--use-angle=swiftshader",
        "--enable-unsafe-swiftshader",
        f"--window-size={width},{height}",
        "--virtual-time-budget=8000",
        f"--screenshot={shot}",
        address,
    ]
    subprocess.run(command, check=True, capture_output=True, timeout=120)  # ten seconds measured
    return shot.read_bytes()


PICTURES = (
    Picture("preview.png", FAMILY, (*STYLE, *WALKER, "walkergen/commands/family/preview.py"), 15, "preview.png"),
    Picture("speed.png", FAMILY, (*STYLE, *PREDICTION, "walkergen/commands/family/figures.py"), 0, "speed.png"),
    Picture(
        "page.png",
        f"{FAMILY} --page",
        (*PREDICTION, "walkergen/commands/family/**/*", *PAGE),
        10,
        page,
        program="chromium",
        package="chromium",
    ),
    Picture(
        "app.png",
        "",
        (*PREDICTION, *WALKER, "walkergen/app/**/*", "viewer/*.js"),
        10,
        app,
        program="chromium",
        package="chromium",
        shown="walkergen app",
    ),
    Picture(
        "mechanisms.png",
        "",
        (*STYLE, *WALKER, "walkergen/commands/family/preview.py"),
        2,
        mechanisms,
        shown="\n".join(f"walkergen family {name}" for name in OTHERS),
    ),
    Picture(
        "shapes.png",
        "",
        (*STYLE, *WALKER, *PREDICTION, *SIMULATION, "walkergen/points/*.py", "walkergen/commands/family/preview.py"),
        40,
        own_shapes,
        shown="walkergen family heart.svg\nwalkergen family duck.stl\nwalkergen family --text ANNA",
    ),
    Picture("map.png", MAP, (*STYLE, *PREDICTION, "walkergen/guests/sweep/*.py"), 5, "sweep.png"),
    Picture("movie.gif", MOVIE, (*SIMULATION, *SCENES, "walkergen/guests/movie/*.py"), 30, "movie.gif"),
    Picture("choice.png", CHOICE, (*STYLE, *SCENES, *(f"{ACCURACY}/{name}" for name in SHIPPED)), 5, "accuracy.png"),
    Picture(
        "simulated.png",
        SIMULATED,
        (*STYLE, *PREDICTION, *SIMULATION, "walkergen/commands/family/figures.py"),
        40,
        "speed.png",
    ),
    Picture(
        "reproduced.png",
        REPRODUCE,
        (*STYLE, *PREDICTION, *SIMULATION, *MEASURES, "evidence/reproduce/*.py"),
        190,
        "figure2.png",
    ),
    Picture(
        "figure6.png",
        REPRODUCE,
        (*STYLE, *PREDICTION, *SIMULATION, *MEASURES, "evidence/reproduce/*.py"),
        0,
        "figure6.png",
    ),
    Picture(
        "surrogate.png",
        "",
        (*STYLE, "docs/surrogate.csv", "evidence/tables/held_out.py"),
        2,
        surrogate,
        shown="python -m evidence.tables.held_out",
    ),
    Picture(
        "crowd.png",
        CROWD,
        (*STYLE, *SIMULATION, *SCENES, "walkergen/guests/crowd/*.py", "walkergen/guests/crowd/s*/*.py"),
        40,
        "crowd.png",
    ),
    Picture(
        "validation.png",
        VALIDATE,
        (*STYLE, *PREDICTION, *SIMULATION, *MEASURES, "evidence/reproduce/maximum.py", "evidence/validate/*.py"),
        180,
        "validation.png",
        beside=("validation.csv",),
        program="prusa-slicer",
        package="prusa-slicer",
    ),
)
"""All pictures, those of one command beside one another."""


def digest(sources: Sequence[str]) -> str:
    """Hash of the files of some patterns, 16 hexadecimal digits: of code, not of what is said.

    Comments, docstrings and layout may change without the picture.
    """
    found = hashlib.sha256()
    paths = {path for pattern in sources for path in ROOT.glob(pattern) if path.is_file()}
    for path in sorted(path for path in paths if "__pycache__" not in path.parts):
        found.update(path.relative_to(ROOT).as_posix().encode() + said(path))
    return found.hexdigest()[:16]


@functools.cache
def said(path: Path) -> bytes:
    """Contents of a file that can change a picture."""
    data = path.read_bytes()
    if path.suffix == ".py":
        return bare(data.decode()).encode()
    if path.suffix == ".toml":
        return json.dumps(tomllib.loads(data.decode()), sort_keys=True).encode()
    return b"".join(data.split())  # ends of lines differ between systems


def bare(source: str) -> str:
    """Python code without comments, docstrings and white space, alike on every Python."""
    lines = source.encode().splitlines(keepends=True)
    starts = [0]
    for line in lines:
        starts.append(starts[-1] + len(line))
    cuts = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            assert node.end_lineno is not None
            assert node.end_col_offset is not None
            end = starts[node.end_lineno - 1] + node.end_col_offset
            cuts.append((starts[node.lineno - 1] + node.col_offset, end))
    for token in tokenize.tokenize(io.BytesIO(source.encode()).readline):
        if token.type == tokenize.COMMENT:
            row, column = token.start
            start = starts[row - 1] + len(token.line[:column].encode())
            cuts.append((start, start + len(token.string.encode())))
    data = source.encode()
    for start, end in sorted(cuts, reverse=True):
        data = data[:start] + data[end:]
    return "".join(data.decode().split())


def command_of(picture: Picture) -> str:
    """Command that makes a picture, for people."""
    if not picture.command or callable(picture.made):
        return f"make pictures ONLY={Path(picture.name).stem}"
    return picture.command


def facts(picture: Picture) -> dict[str, str]:
    """Facts that a picture bears: version of walkergen, command, digest of the code."""
    return {"Software": f"walkergen {__version__}", "Command": command_of(picture), "Code": digest(picture.sources)}


def stamped(data: bytes, told: dict[str, str]) -> bytes:
    """PNG with facts as chunks of text, or GIF with them as a comment of a line each."""
    if data.startswith(b"\x89PNG"):
        chunks = b"".join(_chunk(f"{key}\0{value}".encode("latin-1")) for key, value in told.items())
        return data[:33] + chunks + data[33:]  # behind the header
    comment = "\n".join(f"{key}: {value}" for key, value in told.items()).encode()
    colours = 3 * 2 ** ((data[10] & 7) + 1) if data[10] & 0x80 else 0
    start = 13 + colours  # behind the header and the colours of all frames
    blocks = [comment[at : at + 255] for at in range(0, len(comment), 255)]
    block = b"".join(bytes([len(one)]) + one for one in blocks)
    return data[:start] + b"\x21\xfe" + block + b"\0" + data[start:]


def _chunk(text: bytes) -> bytes:
    """Chunk tEXt of a PNG."""
    body = b"tEXt" + text
    return struct.pack(">I", len(text)) + body + struct.pack(">I", zlib.crc32(body))


def stamp(path: Path) -> dict[str, str]:
    """Facts that a picture bears; nothing of one without them."""
    if not path.exists():
        return {}
    with Image.open(path) as image:
        found = dict(image.info)
    comment = found.get("comment", b"")
    if isinstance(comment, bytes):
        lines = (line.partition(": ") for line in comment.decode().splitlines())
        found |= {key: value for key, _, value in lines}
    return {key: str(found[key]) for key in ("Software", "Command", "Code") if key in found}


def stale(picture: Picture) -> bool:
    """Whether a picture is of another command, or of code that has moved on."""
    known, today = stamp(ROOT / "docs" / picture.name), facts(picture)
    return any(known.get(key) != today[key] for key in ("Command", "Code"))


def walkergen(command: str, *more: str) -> None:
    """Run a command of walkergen from the code beside this file."""
    words = [sys.executable, "-m", *shlex.split(command.removeprefix("python -m ")), *more]
    subprocess.run(words, check=True, cwd=ROOT, stdout=subprocess.DEVNULL)


def make(pictures: Sequence[Picture]) -> None:
    """Make pictures, those of one command together; those that lack a program are skipped."""
    began = time.perf_counter()
    for command, group in groupby(pictures, key=lambda one: one.command):
        wanted = []
        for picture in group:
            if picture.program and shutil.which(picture.program) is None:
                print(f"{picture.name}: skipped: no {picture.program} here; apt-get install {picture.package}")
            else:
                wanted.append(picture)
        if wanted:
            _make(command, wanted)
    print(f"{time.perf_counter() - began:.0f} s in all")


def _make(command: str, pictures: Sequence[Picture]) -> None:
    """Run a command in a folder of its own, and take its pictures from there."""
    began = time.perf_counter()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if command:
            out = folder / "movie.gif" if command == MOVIE else folder
            walkergen(command, "--quiet", "--out", str(out))
        for picture in pictures:
            made = picture.made
            data = made(folder) if callable(made) else (folder / made).read_bytes()
            for other in picture.beside:
                output.write(ROOT / "docs" / other, (folder / other).read_bytes())
            output.write(ROOT / "docs" / picture.name, stamped(data, facts(picture)))
            took = time.perf_counter() - began
            print(f"{picture.name}: {took:.0f} s, by {command_of(picture)}", flush=True)


def chosen(words: Sequence[str]) -> list[Picture]:
    """Pictures of some names, "all", or without any those that are stale."""
    names = [name for word in words for name in word.split(",") if name]
    if not names:
        return [picture for picture in PICTURES if stale(picture)]
    known = {Path(picture.name).stem: picture for picture in PICTURES}
    wrong = [name for name in names if name not in known and name != "all"]
    if wrong:
        sys.exit(f"ONLY={wrong[0]}: must be of {', '.join(known)}, all")
    return [one for name, one in known.items() if name in names or "all" in names]


if __name__ == "__main__":
    pictures = chosen(sys.argv[1:])
    expected = sum(picture.seconds for picture in pictures)
    print(f"{len(pictures)} of {len(PICTURES)} pictures, some {expected} s on two cores")
    make(pictures)
