"""Make the pictures of docs/ with their commands. Each picture contains the digest of its code.

`make pictures` makes those whose code has changed. `make pictures ONLY=choice,speed` makes these two,
ONLY=all makes every one. A picture is written when it is ready, so an interrupted run can continue.
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
sys.path.insert(0, str(ROOT))  # the code of this checkout, installed or not

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
GALLERY = {
    "koumakis2016": "thin tilted legs (Koumakis et al., 2016)",
    "maker-large": "twice as large, for thick nozzles",
    "bristle": "18 short flexible legs",
    "rotator": "left legs lean back, right ones ahead: it turns",
    "name": "letters between two rails",
    "heart.svg": "a drawing on automatic legs",
    "coinbot": "coin motor and cell: it needs no shaker",
    "bristlebot": "coin motor on bristles",
    "spinner": "disc with a coin motor",
    "two-materials": "rough foot behind, smooth ahead",
    "unequal-legs": "short leg near the middle",
    "polar-disc": "disc on a rubber skate and a hard tip",
}
"""Walkers of the gallery, templates and a drawing, with what is special about each."""

GALLERY_PAGE = """# Gallery

![Twelve walkers and their predicted speeds](gallery.png)

The speed is the median of prints ± one standard deviation. The *scene* is what the walker runs on: `lane-90hz` is a
lane shaken at 90 Hz, `table-motor` a still table. The last column makes the files: `family` writes an STL and a 3MF of
each tilt, a picture and a table of speeds. `heart.svg` is a drawing of yours.
`walkergen templates copy NAME my.toml` copies a template to edit.

| walker | what it is | predicted speed | scene | command |
|---|---|---|---|---|
"""
"""First lines of docs/gallery.md."""

OWN_SHAPES = ("heart.svg", "duck.stl", "ANNA")
"""Two files and a text, as a user has them."""

SHEET_STYLE = """
@page { size: A4 landscape; margin: 12mm }
body { font: 11px/1.4 sans-serif; margin: 12px; max-width: 1040px }
h1 { font-size: 20px; margin: 0 } table { border-collapse: collapse; width: 100% }
td, th { border-bottom: 1px solid #bbb; padding: 5px 8px; text-align: left; vertical-align: top }
td:first-child, code { white-space: nowrap } code { background: #eee; padding: 0 2px }
"""
"""Style of the cheat sheet on paper."""

SHEET_WINDOW = (1070, 490)
WINDOW = (1215, 845)
APP_WINDOW = (1440, 900)
"""Width and height of the browser's window, pixels."""


class Picture(NamedTuple):
    """Picture of docs/, its command and its sources."""

    name: str
    command: str
    """Command that writes it; empty if a function here draws it."""
    sources: Sequence[str]
    """Patterns of the files that decide what it shows. Not all imported files: most of their changes do not
    change the picture."""
    seconds: int
    """Time on two cores with compiled kernels, s. It is 0 if the command of another picture makes it
    too."""
    made: str | Callable[[Path], bytes]
    """Its name in the folder of the command, or the function that makes it there."""
    companions: tuple[str, ...] = ()
    """Other files of that folder that are stored in docs/."""
    program: str = ""
    """Other program that it requires."""
    package: str = ""
    """Debian package of that program."""
    shown: str = ""
    """Commands that show it, one per line, if a user would not run `command`."""


def draw_gallery(folder: Path) -> bytes:
    """Draw the walkers of the gallery with their predicted speeds, and write the page that lists them."""
    from evidence import example_shapes
    from walkergen import inputs, request
    from walkergen.commands.family.preview import Part, preview_figure
    from walkergen.commands.predict import make as predicting
    from walkergen.core.theory import prediction
    from walkergen.files import figures

    (folder / "heart.svg").write_bytes(example_shapes.HEART)
    parts, rows = [], []
    for name, words in GALLERY.items():
        given = inputs.from_settings({}, {}, ["design", "scene"])
        design = given.design(str(folder / name) if "." in name else name)
        scene = request.choose_scene(None, [design])
        (member,) = predicting.predict(design, [design], given.scene(scene), "coulomb").members
        speed = "does not travel" if prediction.is_standing(member.row) else prediction.describe_briefly(member.row)
        parts.append(Part(design, member.mesh, name, low=True, speed=speed))
        rows.append(f"| `{name}` | {words} | {speed} | `{scene}` | `walkergen family {name}` |")
    (folder / "gallery.md").write_text(GALLERY_PAGE + "\n".join(rows) + "\n", encoding="utf-8")
    return figures.png(preview_figure(parts, "Twelve walkers and their predicted speeds"), 150)


def draw_own_shapes(folder: Path) -> bytes:
    """Draw a drawing, a mesh and a name on automatic legs, with their speeds."""
    from evidence import example_shapes
    from walkergen import inputs
    from walkergen.commands.family.preview import Part, preview_figure
    from walkergen.commands.predict import make as predicting
    from walkergen.core.theory import prediction
    from walkergen.files import figures

    scene = inputs.from_settings({}, {}, ["scene"]).scene("lane-90hz")
    files = {"heart.svg": example_shapes.HEART, "duck.stl": example_shapes.duck_stl()}
    parts = []
    for shape in OWN_SHAPES:
        asked = inputs.from_settings({"body.text": shape} if "." not in shape else {}, {}, ["design"])
        if "." in shape:
            (folder / shape).write_bytes(files[shape])
        design = asked.design(str(folder / shape) if "." in shape else "koumakis2016").variant(tilt_deg=10.0)
        (member,) = predicting.predict(design, [design], scene, "coulomb").members
        parts.append(Part(design, member.mesh, shape, low=True, speed=prediction.describe_briefly(member.row)))
    return figures.png(preview_figure(parts, "A drawing, a mesh, a name: legs place themselves"), 150)


def draw_surrogate(folder: Path) -> bytes:
    """Draw the surrogate compared with direct runs, from their table."""
    from evidence.tables import held_out

    return held_out.draw_picture(held_out.read_rows())


def draw_work_precision(folder: Path) -> bytes:
    """Draw the true error of walkergen, MuJoCo and Drake against time, from their table."""
    from evidence.work_precision import figures as engines
    from evidence.work_precision.measure import read_rows
    from walkergen.files import figures

    return figures.png(engines.draw_work_precision(read_rows()))


def take_page(folder: Path) -> bytes:
    """Take a screenshot of a family's page."""
    return take_screenshot(folder, (folder / "report.html").as_uri(), *WINDOW)


def take_app(folder: Path) -> bytes:
    """Take a screenshot of the design page."""
    words = [sys.executable, "-m", "walkergen", "app", "--port", "0", "--no-browser"]
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    with subprocess.Popen(words, cwd=folder, env=environment, stdout=subprocess.PIPE, text=True) as server:
        assert server.stdout is not None
        address = server.stdout.readline().split()[-1]
        try:
            return take_screenshot(folder, address, *APP_WINDOW)
        finally:
            server.terminate()


def print_cheat_sheet(folder: Path) -> bytes:
    """Print the cheat sheet as PDF on one page, and take a picture of it."""
    import markdown

    text = (ROOT / "docs" / "cheat-sheet.md").read_text(encoding="utf-8")
    text = text.replace(" [Print this page](cheat-sheet.pdf).", "")
    page = folder / "sheet.html"
    body = markdown.markdown(text, extensions=["tables"])
    page.write_text(f"<!doctype html><meta charset=utf-8><style>{SHEET_STYLE}</style>{body}", encoding="utf-8")
    run_chromium(page.as_uri(), "--no-pdf-header-footer", f"--print-to-pdf={folder / 'cheat-sheet.pdf'}")
    return take_screenshot(folder, page.as_uri(), *SHEET_WINDOW)


def take_screenshot(folder: Path, address: str, width: int, height: int) -> bytes:
    """Take a screenshot of a page in a browser."""
    shot = folder / "shot.png"
    window = f"--window-size={width},{height}"
    run_chromium(address, "--hide-scrollbars", window, "--virtual-time-budget=8000", f"--screenshot={shot}")
    return shot.read_bytes()


def run_chromium(address: str, *options: str) -> None:
    """Load a page in Chromium without a window."""
    command = ["chromium", "--headless", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
    subprocess.run([*command, *options, address], check=True, capture_output=True, timeout=120)  # 10 s measured


PICTURES = (
    Picture("preview.png", FAMILY, (*STYLE, *WALKER, "walkergen/commands/family/preview.py"), 15, "preview.png"),
    Picture("speed.png", FAMILY, (*STYLE, *PREDICTION, "walkergen/commands/family/figures.py"), 0, "speed.png"),
    Picture(
        "page.png",
        f"{FAMILY} --page",
        (*PREDICTION, "walkergen/commands/family/**/*", *PAGE),
        10,
        take_page,
        program="chromium",
        package="chromium",
    ),
    Picture(
        "app.png",
        "",
        (*PREDICTION, *WALKER, "walkergen/app/**/*", "viewer/*.js"),
        10,
        take_app,
        program="chromium",
        package="chromium",
        shown="walkergen app",
    ),
    Picture(
        "gallery.png",
        "",
        (*STYLE, *WALKER, *PREDICTION, *SIMULATION, "walkergen/points/*.py", "walkergen/commands/family/preview.py"),
        90,
        draw_gallery,
        companions=("gallery.md",),
        shown="\n".join(f"walkergen family {name}" for name in GALLERY),
    ),
    Picture(
        "shapes.png",
        "",
        (*STYLE, *WALKER, *PREDICTION, *SIMULATION, "walkergen/points/*.py", "walkergen/commands/family/preview.py"),
        40,
        draw_own_shapes,
        shown="walkergen family heart.svg\nwalkergen family duck.stl\nwalkergen family --text ANNA",
    ),
    Picture(
        "cheat-sheet.png",
        "",
        ("docs/cheat-sheet.md",),
        5,
        print_cheat_sheet,
        companions=("cheat-sheet.pdf",),
        program="chromium",
        package="chromium",
        shown="walkergen --help",
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
        draw_surrogate,
        shown="python -m evidence.tables.held_out",
    ),
    Picture(
        "work-precision.png",
        "",
        (*STYLE, "evidence/work_precision/points.csv", "evidence/work_precision/figures.py"),
        2,
        draw_work_precision,
        shown="python -m evidence.work_precision.measure",
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
        companions=("validation.csv",),
        program="prusa-slicer",
        package="prusa-slicer",
    ),
)
"""All pictures. Those of one command are adjacent."""


def digest(sources: Sequence[str]) -> str:
    """Return the hash of the code in the files of some patterns, 16 hexadecimal digits.

    Comments, docstrings and layout do not change it.
    """
    found = hashlib.sha256()
    paths = {path for pattern in sources for path in ROOT.glob(pattern) if path.is_file()}
    for path in sorted(path for path in paths if "__pycache__" not in path.parts):
        found.update(path.relative_to(ROOT).as_posix().encode() + read_code(path))
    return found.hexdigest()[:16]


@functools.cache
def read_code(path: Path) -> bytes:
    """Return the contents of a file that can change a picture."""
    data = path.read_bytes()
    if path.suffix == ".py":
        return strip_comments(data.decode()).encode()
    if path.suffix == ".toml":
        return json.dumps(tomllib.loads(data.decode()), sort_keys=True).encode()
    return b"".join(data.split())  # ends of lines differ between systems


def strip_comments(source: str) -> str:
    """Return Python code without comments, docstrings and white space, the same on every Python."""
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


def command_for(picture: Picture) -> str:
    """Return the command that makes a picture."""
    if not picture.command or callable(picture.made):
        return f"make pictures ONLY={Path(picture.name).stem}"
    return picture.command


def current_facts(picture: Picture) -> dict[str, str]:
    """Return the version of walkergen, the command and the digest of the code of a picture."""
    return {"Software": f"walkergen {__version__}", "Command": command_for(picture), "Code": digest(picture.sources)}


def add_facts(data: bytes, facts: dict[str, str]) -> bytes:
    """Return a PNG with facts as chunks of text, or a GIF with facts as lines of a comment."""
    if data.startswith(b"\x89PNG"):
        chunks = b"".join(_chunk(f"{key}\0{value}".encode("latin-1")) for key, value in facts.items())
        return data[:33] + chunks + data[33:]  # behind the header
    comment = "\n".join(f"{key}: {value}" for key, value in facts.items()).encode()
    colours = 3 * 2 ** ((data[10] & 7) + 1) if data[10] & 0x80 else 0
    start = 13 + colours  # behind the header and the colours of all frames
    blocks = [comment[at : at + 255] for at in range(0, len(comment), 255)]
    block = b"".join(bytes([len(one)]) + one for one in blocks)
    return data[:start] + b"\x21\xfe" + block + b"\0" + data[start:]


def _chunk(text: bytes) -> bytes:
    """Return a tEXt chunk of a PNG."""
    body = b"tEXt" + text
    return struct.pack(">I", len(text)) + body + struct.pack(">I", zlib.crc32(body))


def read_facts(path: Path) -> dict[str, str]:
    """Return the facts stored in a picture; empty if there are none."""
    if not path.exists():
        return {}
    with Image.open(path) as image:
        found = dict(image.info)
    comment = found.get("comment", b"")
    if isinstance(comment, bytes):
        lines = (line.partition(": ") for line in comment.decode().splitlines())
        found |= {key: value for key, _, value in lines}
    return {key: str(found[key]) for key in ("Software", "Command", "Code") if key in found}


def is_stale(picture: Picture) -> bool:
    """Return whether a picture was made with another command or other code."""
    known, today = read_facts(ROOT / "docs" / picture.name), current_facts(picture)
    return any(known.get(key) != today[key] for key in ("Command", "Code"))


def run_walkergen(command: str, *more: str) -> None:
    """Run a command of walkergen with the code of this checkout."""
    words = [sys.executable, "-m", *shlex.split(command.removeprefix("python -m ")), *more]
    subprocess.run(words, check=True, cwd=ROOT, stdout=subprocess.DEVNULL)


def make(pictures: Sequence[Picture]) -> None:
    """Make pictures, those of one command together. A picture without its program is skipped."""
    began = time.perf_counter()
    for command, group in groupby(pictures, key=lambda one: one.command):
        wanted = []
        for picture in group:
            if picture.program and shutil.which(picture.program) is None:
                print(f"{picture.name}: skipped: no {picture.program} here; apt-get install {picture.package}")
            else:
                wanted.append(picture)
        if wanted:
            _make_group(command, wanted)
    print(f"{time.perf_counter() - began:.0f} s in all")


def _make_group(command: str, pictures: Sequence[Picture]) -> None:
    """Run a command in a temporary folder and store its pictures."""
    began = time.perf_counter()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if command:
            out = folder / "movie.gif" if command == MOVIE else folder
            run_walkergen(command, "--quiet", "--out", str(out))
        for picture in pictures:
            made = picture.made
            data = made(folder) if callable(made) else (folder / made).read_bytes()
            for other in picture.companions:
                output.write(ROOT / "docs" / other, (folder / other).read_bytes())
            output.write(ROOT / "docs" / picture.name, add_facts(data, current_facts(picture)))
            took = time.perf_counter() - began
            print(f"{picture.name}: {took:.0f} s, by {command_for(picture)}", flush=True)


def choose(words: Sequence[str]) -> list[Picture]:
    """Return the pictures of some names, of "all", or the outdated ones if no name is given."""
    names = [name for word in words for name in word.split(",") if name]
    if not names:
        return [picture for picture in PICTURES if is_stale(picture)]
    known = {Path(picture.name).stem: picture for picture in PICTURES}
    wrong = [name for name in names if name not in known and name != "all"]
    if wrong:
        sys.exit(f"ONLY={wrong[0]}: must be of {', '.join(known)}, all")
    return [one for name, one in known.items() if name in names or "all" in names]


if __name__ == "__main__":
    pictures = choose(sys.argv[1:])
    expected = sum(picture.seconds for picture in pictures)
    print(f"{len(pictures)} of {len(PICTURES)} pictures, some {expected} s on two cores")
    make(pictures)
