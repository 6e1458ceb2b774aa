"""Hostile tries: a table of classes, each a few lines; thousands of tries are drawn from it.

A try is a command line and the files that it finds. Each runs in a process of its own, forked from
one that has imported what commands need, under limits of memory and time; all are judged alike.
"""

import io
import json
import math
import os
import random
import resource
import signal
import struct
import sys
import traceback
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

SECONDS, MEMORY = 60, 3 * 2**30
"""Time of a try, and memory beyond what the process had before."""

WIDEST = 1000


class Try(NamedTuple):
    """A command line, and what lies in its folder: bytes, or the name of a kind of `KINDS`."""

    label: str
    words: tuple[str, ...]
    files: Mapping[str, bytes | str] = {}


class Seen(NamedTuple):
    code: int
    out: str
    err: str
    new: list[str]
    """Files in the folder that were not there before."""


def faults(one: Try, seen: Seen) -> list[str]:
    """Return what is wrong with the outcome of a try; empty if it is sound."""
    found = []
    answered = seen.code == 1 and "cannot be written" in seen.err
    if seen.code not in (0, 2) and not answered:
        found.append(f"exit code {seen.code}")
    if "Traceback" in seen.err or "Warning" in seen.err:
        found.append("traceback or warning of a library")
    if seen.code == 2 and not any(line.lower().startswith("error: ") for line in seen.err.splitlines()):
        found.append("no line of error")
    left = [name for name in seen.new if name != "out/trouble.png"]  # the drawing of what stands on no legs
    if seen.code == 2 and left:
        found.append(f"refused, and left {left[:3]}")
    for line in seen.err.splitlines():
        if len(line) > WIDEST:
            found.append(f"line of {len(line)} letters")
    for text in (seen.out, seen.err):
        if hidden := [letter for letter in text if letter not in "\n\t" and _hidden(letter)]:
            found.append(f"raw {hidden[0]!r}")
    outside = [name for name in seen.new if not name.startswith(("out", "page.html"))]
    if outside and one.words[0] != "templates":
        found.append(f"wrote outside its folder: {outside[:3]}")
    if seen.code == 0 and "nan" in seen.out.lower().split():
        found.append("nan in its output")
    return found


def _hidden(letter: str) -> bool:
    code = ord(letter)
    return (
        code < 32
        or 127 <= code < 160
        or 0xD800 <= code < 0xE000
        or 0x200E <= code < 0x2010
        or 0x2028 <= code < 0x202F
        or 0x2066 <= code < 0x206A
    )


# --- running -------------------------------------------------------------------------------------


def warm() -> None:
    """Import what commands import, so that processes forked from this one need not."""
    import importlib
    import pkgutil

    import walkergen

    for module in pkgutil.walk_packages(walkergen.__path__, "walkergen."):
        if module.name != "walkergen.__main__":
            importlib.import_module(module.name)
    for name in ("trimesh", "ezdxf", "svgelements", "scipy.optimize", "scipy.stats", "rich.table"):
        importlib.import_module(name)


def run_try(one: Try, folder: Path, seconds: int = SECONDS) -> Seen:
    """Run a try in an empty folder, in a process of its own."""
    for name, content in one.files.items():
        place = folder / name
        place.parent.mkdir(parents=True, exist_ok=True)
        if isinstance(content, str):
            KINDS[content](place)
        else:
            place.write_bytes(content)
    before = _files_in(folder)
    told = folder.with_name(folder.name + ".told")
    child = os.fork()
    if child == 0:
        _run_child(one.words, folder, told, seconds)
    _, status = os.waitpid(child, 0)
    code = os.waitstatus_to_exitcode(status)
    out, err = json.loads(told.read_text()) if told.exists() else ("", f"died of {code}")
    return Seen(code, out, err, sorted(_files_in(folder) - before))


def _run_child(words: tuple[str, ...], folder: Path, told: Path, seconds: int) -> None:
    """Run the command line, tell what it printed, and end this process."""
    code = 70
    try:
        os.chdir(folder)
        resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
        signal.setitimer(signal.ITIMER_REAL, 4 * seconds)
        limit = _size() + MEMORY
        resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
        out, err = (io.TextIOWrapper(io.BytesIO(), "utf-8", "surrogatepass", write_through=True) for _ in range(2))
        sys.stdout, sys.stderr, sys.argv = out, err, ["walkergen", *words]
        warnings.simplefilter("default")
        try:
            from walkergen.cli import main

            main()
            code = 0
        except SystemExit as end:
            code = end.code if isinstance(end.code, int) else int(end.code is not None)
        except BaseException:
            err.write(traceback.format_exc())
            code = 1
        texts = [one.buffer.getvalue().decode("utf-8", "surrogatepass") for one in (out, err)]
        told.write_text(json.dumps(texts))
    finally:
        os._exit(code)


def _size() -> int:
    """Memory that this process may have by its addresses, bytes."""
    try:
        pages = int(Path("/proc/self/statm").read_text().split()[0])
        return pages * resource.getpagesize()
    except OSError:
        return 8 * 2**30


def _files_in(folder: Path) -> set[str]:
    return {str(path.relative_to(folder)) for path in folder.rglob("*") if not path.is_dir()}


# --- what is hostile -----------------------------------------------------------------------------

NUMBERS = (
    "5e-324",
    "1e-320",
    "-1e-310",
    "-0.0",
    "1e-200",
    "1e-13",
    "-1e-9",
    "1e-7",
    "1e17",
    "1e150",
    "1.7e308",
    "-1.7e308",
    "nan",
    "-nan",
    "inf",
    "-inf",
    "9" * 400,
    "9" * 5000,
    "0x" + "f" * 9000,
    "-9223372036854775809",
    "18446744073709551616",
    "0",
    "-1",
    "1",
    "2",
    "0.5",
    "1e9",
    "0b1",
    "0o7",
)
TEXTS = (
    r'""',
    r'"\u001b[31mred"',
    r'"\u009b2J"',
    r'"\u202Eabc"',
    r'"\u0000"',
    r'"\u0007"',
    r'"\u2066x"',
    '"' + "a" * 300 + '"',
    '"' + "b" * 20_000 + '"',
    '"../../x"',
    '"/etc/passwd"',
    '"."',
    '"/"',
    '"<script>alert(1)</script>"',
    '"{{7*7}}"',
    r'"a\nb"',
    '"%s%n"',
    '"[bold]x[/bold]"',
    '"CON"',
    '"\U0001f600"',
    r'"\u0301\u0301"',
    '"=1+1"',
    "''",
    "'''\n\n'''",
)
OTHERS = (
    "true",
    "[]",
    "{}",
    "[[]]",
    "[1]",
    "[true, 'x']",
    "{a = 1}",
    "[{}]",
    "1979-05-27",
    "07:32:00",
    "1979-05-27T07:32:00Z",
    "[" * 40 + "]" * 40,
    "[" * 3000,
    "{a = " * 50 + "1" + "}" * 50,
    "[1e-320, 2]",
    "[nan]",
    "[" + "1," * 3000 + "]",
)
WORDS = (
    "",
    " ",
    "\n",
    "5%\n",
    "1\n",
    "1_0",
    "١٢",
    "１",
    "nan",
    "inf",
    "-inf",
    "1e999",
    "1e-999",
    "-0",
    "0x1",
    "1e-320",
    "9" * 5000,
    "1,",
    ",",
    ":",
    "1:2",
    "1:2:0",
    "1:2:1e-300",
    "0:1e300:1",
    "--",
    "-",
    "\x1b[31m",
    "\x9b1m",
    "\u202ex",
    "a\tb",
    "\udcff",
    "é" * 300,
    "x" * 5000,
    "../x",
    "/",
    "/dev/null",
    "1;2",
    "1 2",
    "%s",
    "{}",
    "$HOME",
    "[bold]",
    "=",
    "a=b",
    "legs=1",
    "scene.=1",
    "True",
    "none",
    "5 %",
    "5%%",
    "%",
    "1mm/s/s",
    "1s",
    "0s",
    "1e-9s",
    "1e9h",
    "auto",
    "1e-9",
    "1e9",
    "10:5001",
)
CELLS = (
    "",
    " ",
    "nan",
    "inf",
    "-inf",
    "1e17",
    "1e300",
    "-1e300",
    "1e-320",
    "-0.0",
    "1_0",
    "١",
    "0x1p3",
    '"',
    '"1',
    "x" * 300,
    "\x1b[31m",
    "\u202e",
    "-5",
    "1e12",
    "9" * 400,
    "1,1",
    "0",
    "true",
    "\0",
)
BLOBS = (
    b"",
    b"\n",
    b"\0" * 100,
    b"\xff\xfe a\0",
    b"\xef\xbb\xbf",
    b"caf\xe9",
    bytes(range(256)),
    b"a" * 1_200_000,
    b"\n" * 300_000,
    b"=" * 1000,
    b"[" * 5000,
    b'"""',
    b"a.b.c=" * 500,
    b"\x1b[2J",
    b"a,b\n1",
    b"," * 100_000,
    b"a" + b".a" * 100_000 + b"=1",
    b"{}",
    b"[]",
    b"<svg/>",
    b"solid\n",
    b"<svg xmlns='http://www.w3.org/2000/svg' width='1mm' height='1mm'><path d='M0 0L1 0L1 1Z'/></svg>",
)


def _socket(place: Path) -> None:
    import socket

    here = Path.cwd()
    os.chdir(place.parent)  # names of sockets are short
    try:
        with socket.socket(socket.AF_UNIX) as made:
            made.bind(place.name)
    finally:
        os.chdir(here)


def _sparse(place: Path) -> None:
    with place.open("wb") as stream:
        stream.truncate(20 * 10**9)


KINDS: Mapping[str, Callable[[Path], None]] = {
    "fifo": os.mkfifo,
    "loop": lambda place: place.symlink_to(place),
    "endless": lambda place: place.symlink_to("/dev/zero"),
    "socket": _socket,
    "sparse": _sparse,
    "folder": Path.mkdir,
    "dangling": lambda place: place.symlink_to("nowhere"),
    "terminal": lambda place: place.symlink_to("/dev/tty"),
    "memory": lambda place: place.symlink_to("/proc/self/mem"),
    "growing": lambda place: place.symlink_to("/proc/kmsg"),
}

READERS: Mapping[str, tuple[str, ...]] = {
    "x.toml": ("predict", "{}"),
    "s.toml": ("predict", "--scene", "{}"),
    "p.toml": ("check", "--printer", "{}"),
    "w.toml": ("sweep", "--file", "{}", "--out", "out"),
    "t.csv": ("analyse", "{}", "--out", "out", "--no-pictures"),
    "f.csv": ("fit", "{}", "--no-pictures", "--out", "out"),
    "m.csv": ("family", "--tilt", "10", "--legs", "braced", "--measured", "{}", "--out", "out"),
    "weights.csv": ("predict", "--weights", "{}"),
    "o.csv": ("plate", "--orders", "{}", "--out", "out"),
    "c.csv": ("calibrate", "{}", "--out", "out"),
    "film.mp4": ("track", "{}", "--mm-per-px", "1"),
    **{f"b.{end}": ("check", "{}") for end in ("stl", "obj", "ply", "off", "3mf", "glb")},
    **{f"d.{end}": ("predict", "--set", 'body={{outline="{}"}}') for end in ("svg", "dxf")},
    "e.stl": ("predict", "--set", 'body={{mesh="{}"}}'),
}
"""Commands that read a file, by the file's name."""


def _reading(name: str) -> tuple[str, ...]:
    return tuple(word.format(name) for word in READERS[name])


# --- classes of tries ----------------------------------------------------------------------------


def keys(rng: random.Random) -> Try:
    """A key of a file with a hostile value, in the file or by --set."""
    from walkergen.core.files.config import key_paths as keys_of
    from walkergen.core.printing.printers import Printer
    from walkergen.core.scene import Scene
    from walkergen.core.walker.design import Design

    flag, model = rng.choice((("", Design), ("--scene", Scene), ("--printer", Printer)))
    path = rng.choice(keys_of(model))
    value = rng.choice(rng.choice((NUMBERS, NUMBERS, TEXTS, OTHERS)))
    command = "check" if model is Printer else "predict"
    if rng.random() < 0.4 and len(value) < 10_000:
        prefix = {"": "", "--scene": "scene.", "--printer": "printer."}[flag]
        return Try("set", (command, "--set", f"{prefix}{'.'.join(path)}={value}"))
    text = f"{'.'.join(path)} = {value}\n"
    if model is Printer:
        text += "bed_width_mm = 200\nbed_depth_mm = 200\nheight_mm = 100\n"
    words = (command, "x.toml") if not flag else (command, flag, "x.toml")
    return Try("key", words, {"x.toml": text.encode("utf-8", "surrogatepass")})


def sweeps(rng: random.Random) -> Try:
    """A sweep's file with hostile values, ranges and bounds."""
    ends = [rng.choice((*NUMBERS[:20], "0", "5", "10")) for _ in range(3)]
    odd = (f'"{":".join(ends)}"', f'"{ends[0]}:{ends[1]}"', f"[{ends[0]}, {ends[1]}]", f'"{ends[0]}"')
    value = rng.choice((*odd, *odd, *OTHERS, *TEXTS, *NUMBERS))
    name = rng.choice(("legs.tilt_deg", "scene.drive.gamma", "scene.run.seed", "name", "nope"))
    text = rng.choice(
        (
            f'[grid]\n"{name}" = {value}\n',
            f"[grid]\n{name} = {value}\n",
            f'[sample]\npoints = 4\n[sample.between]\n"{name}" = {value}\n',
            f'[sample]\npoints = {value}\n[sample.between]\n"legs.tilt_deg" = [5, 10]\n',
            f'[set]\n"{name}" = {value}\n[grid]\n"legs.length_mm" = "7:8:1"\n',
            f'error = {value}\nseed = {value}\n[grid]\n"legs.tilt_deg" = "5:10:5"\n',
            f'keep = {value}\nmodel = {value}\n[grid]\n"legs.tilt_deg" = "5:10:5"\n',
        )
    )
    words = ("sweep", "--file", "w.toml", "--no-pictures", "--out", "out")
    return Try("sweep", words, {"w.toml": text.encode("utf-8", "surrogatepass")})


def limits(rng: random.Random) -> Try:
    """Some numbers at the very ends of what is allowed."""
    from walkergen.core.files import config
    from walkergen.core.scene import Scene
    from walkergen.core.walker.design import Design

    words: list[str] = []
    for _ in range(rng.choice((1, 1, 2, 4))):
        prefix, model = rng.choice((("", Design), ("scene.", Scene), ("scene.", Scene)))
        path = rng.choice(config.key_paths(model))
        told = config.describe_allowed_values(path, model).split()
        ends = [word for sign, word in pairwise(told) if sign in (">=", "<=")]
        if ends:
            words += ["--set", f"{prefix}{'.'.join(path)}={rng.choice(ends)}"]
    return Try("limits", ("predict", *words))


def names(rng: random.Random) -> Try:
    """A hostile key, table or header."""
    word = rng.choice(TEXTS)
    text = rng.choice((f"{word} = 1\n", f"[{word}]\nx = 1\n", f"[legs]\n{word} = 1\n", f"legs.{word} = 1\n"))
    return Try("name", ("predict", "x.toml"), {"x.toml": text.encode()})


def kinds(rng: random.Random) -> Try:
    """Something that is no file where a file is expected."""
    name, kind = rng.choice(list(READERS)), rng.choice(list(KINDS))
    return Try(f"{kind} {name}", _reading(name), {name: kind})


def blobs(rng: random.Random) -> Try:
    """A file of other contents than its reader expects."""
    name, blob = rng.choice(list(READERS)), rng.choice(BLOBS)
    return Try(f"blob {name}", _reading(name), {name: blob})


def paths(rng: random.Random) -> Try:
    """A hostile name of a file."""
    name = rng.choice(list(READERS))
    words = tuple(word.format(rng.choice(WORDS) or "x") for word in READERS[name])
    return Try(f"path {name}", words)


def _form() -> str:
    """Form of a calibration plate, filled in: PLA of 2.7 GPa on a plate."""
    modulus, density, width = 2.7e9, 1.22e-3, 5.0
    rows = ["part,measured,reading,error,unloaded_mm,weight_g,at_mm"]
    for number, (thick, long, weight) in enumerate(((0.4, 50.0, 0.5), (1.0, 80.0, 3.0)), 1):
        stiff = modulus * width * thick**3 / 12.0
        hertz = 0.5596 * math.sqrt(stiff / (density * width * thick * long**4))
        sunk = weight * 9806.65 * (long - 2.0) ** 3 / (3.0 * stiff)
        readings = [
            ("thickness_mm", thick, 0.02),
            ("width_mm", width, 0.05),
            ("free_length_mm", long, 0.5),
            ("swings_20_s", 20.0 / hertz, 0.01),
        ]
        rows += [f"strip_{number},{name},{value:.4f},{error},,," for name, value, error in readings]
        rows += [f"strip_{number},deflection_mm,{40.0 - sunk:.2f},0.5,40,{weight},{long - 2.0}"] * 2
    block = [
        ("mass_g", 12.2, 0.01),
        ("length_mm", 20, 0.05),
        ("width_mm", 25, 0.05),
        ("height_mm", 20, 0.05),
        ("slides_deg", 14, 1),
    ]
    rows += [f"block,{name},{value},{error},,," for name, value, error in block]
    rows += ["walker,slides_deg,15,1,,,", *["walker,flight_s,0.04,0.002,,,10"] * 2]
    return "\n".join(rows) + "\n"


TABLES: Mapping[str, tuple[str, int]] = {
    "t.csv": (
        "t_s,particle,x_mm,y_mm,theta_rad,plate_speed_mm_s\n"
        + "".join(f"{0.1 * k:.1f},{p},{k},{0.1 * k},0.1,30\n" for p in (0, 1) for k in range(30)),
        6,
    ),
    "f.csv": (
        "tilt_deg,speed_mm_s,speed_se_mm_s,legs,plate_speed_mm_s\n"
        + "".join(f"{t},{3 * t + 5},2,{legs},31\n" for t in (0, 5, 10, 15, 20) for legs in ("flexible", "braced")),
        5,
    ),
    "m.csv": ("tilt_deg,speed_mm_s,speed_se_mm_s\n10,40,2\n10,45,2\n", 3),
    "weights.csv": ("part,grams,body_g,leg_g\nkoumakis2016_t10_flexible_s1.00,1,,\n", 4),
    "o.csv": ("design,tilt_deg,legs,copies\nkoumakis2016,10,braced,2\n", 4),
    "c.csv": (_form(), 7),
}
"""Sound tables, with the number of their columns."""


def cells(rng: random.Random) -> Try:
    """A sound table with some hostile cells, headers or lines."""
    name = rng.choice(list(TABLES))
    text, wide = TABLES[name]
    rows = [line.split(",") for line in text.splitlines()]
    first = int(rng.random() < 0.8)
    for _ in range(rng.choice((1, 1, 2, 10))):
        row = rng.randrange(first, len(rows)) if first < len(rows) else 0
        rows[row][rng.randrange(min(wide, len(rows[row])))] = rng.choice(CELLS)
    if rng.random() < 0.2:
        column, cell = rng.randrange(wide), rng.choice(CELLS)
        for row in rows[1:]:
            row[min(column, len(row) - 1)] = cell
    ends = rng.choice(("\n", "\n", "\r\n", "\r"))
    data = ends.join(",".join(row) for row in rows).encode("utf-8", "surrogatepass")
    return Try(f"cells {name}", _reading(name), {name: data})


def forms(rng: random.Random) -> Try:
    """A form of a calibration plate that is nearly right: rows left out, numbers off or empty."""
    head, *lines = TABLES["c.csv"][0].splitlines()
    rows = [line.split(",") for line in lines]
    for _ in range(rng.choice((1, 1, 2, 6))):
        at, way = rng.randrange(len(rows)), rng.random()
        if way < 0.2 and len(rows) > 1:
            del rows[at]
        elif way < 0.3:
            rows.insert(rng.randrange(len(rows)), rows[at])
        else:
            column = rng.choice([k for k, cell in enumerate(rows[at]) if k > 1 and cell])
            scale = rng.choice((0.5, 0.9, 1.1, 2.0, 2.0, 0.0, -1.0, 1e-6, 10.0, 1e6))
            rows[at][column] = f"{scale * float(rows[at][column]):.6g}" if way < 0.9 else ""
    text = "\n".join((head, *(",".join(row) for row in rows))) + "\n"
    return Try("form", _reading("c.csv"), {"c.csv": text.encode()})


COMMANDS: Mapping[str, tuple[tuple[str, ...], Mapping[str, bytes]]] = {
    "predict": ((), {}),
    "analyse": (("t.csv", "--no-pictures", "--out", "out"), {"t.csv": TABLES["t.csv"][0].encode()}),
    "fit": (("f.csv", "--no-pictures", "--out", "out"), {"f.csv": TABLES["f.csv"][0].encode()}),
    "check": ((), {}),
    "track": (("film.mp4",), {"film.mp4": b"no film"}),
    "templates": ((), {}),
    "export": (("--out", "out"), {}),
    "plate": (("--tilt", "10", "--out", "out"), {}),
    "calibrate": (("c.csv", "--out", "out"), {"c.csv": TABLES["c.csv"][0].encode()}),
    "family": (("--tilt", "10", "--legs", "braced", "--no-pictures", "--out", "out"), {}),
    "sweep": (("--set", "legs.tilt_deg=5,10", "--out", "out"), {}),
    "simulate": (("--seconds", "0.05", "--runs", "1", "--out", "out"), {}),
    "movie": (("--fps", "3", "--out", "out"), {}),
    "accuracy": (("--budget", "0s", "--out", "out"), {}),
    "explain": (("--no-cost",), {}),
}
"""Commands that end soon with any added flag, with their inputs."""


def _options(name: str) -> list[Any]:
    """Options of a command, which may lie below another."""
    import typer

    from walkergen.cli import command_line

    command: Any = typer.main.get_command(command_line)
    for word in name.split():
        command = command.commands[word]
    return [one for one in command.params if one.opts and one.opts[0].startswith("--")]


def flags(rng: random.Random) -> Try:
    """A flag with a hostile value."""
    name = rng.choice(list(COMMANDS))
    words, files = COMMANDS[name]
    option = rng.choice(_options(name))
    value = rng.choice(WORDS)
    if "\0" in value:
        value = "x"
    given = (option.opts[0],) if getattr(option, "is_flag", False) else (f"{option.opts[0]}={value}",)
    if option.opts[0] == "--out":
        given = ("--out", f"out/{value.strip('/') or 'x'}"[:4000])
    return Try(f"{name} {option.opts[0]}", (*name.split(), *words, *given), files)


NEAR: Mapping[type, Sequence[str]] = {
    int: ("0", "1", "2", "3", "100", "10000", "-1"),
    float: ("0", "1e-9", "1e-3", "0.01", "0.3", "1", "3", "30", "100", "1e4", "1e9", "-1"),
}
DEEP: Mapping[str, tuple[tuple[str, ...], Mapping[str, bytes]]] = {
    "fit": (("f.csv", "--no-pictures", "--out", "out"), {"f.csv": TABLES["f.csv"][0].encode()}),
    "calibrate": COMMANDS["calibrate"],
}
"""Commands of long work, where options that are allowed lead on."""


def ends(rng: random.Random) -> Try:
    """Options of long work at the ends of what they take, some at a time."""
    name = rng.choice(list(DEEP))
    words, files = DEEP[name]
    kinds = {one.opts[0]: one.type_descriptor.annotation for one in _options(name)}
    numbers = [flag for flag in kinds if kinds[flag] in NEAR and flag != "--workers"]
    chosen = rng.sample(numbers, min(len(numbers), rng.choice((1, 2))))
    given = [f"{flag}={rng.choice(NEAR[kinds[flag]])}" for flag in chosen]
    if name == "fit" and rng.random() < 0.3:
        given.append("--model=rigid")
    return Try(f"ends {name}", (*name.split(), *words, *given), files)


def commands(rng: random.Random) -> Try:
    """A hostile command, sub-command or argument."""
    word, other = rng.choice(WORDS), rng.choice(WORDS)
    form = rng.randrange(6)
    words = (
        (word,),
        ("predict", word),
        ("templates", word),
        ("templates", "show", word),
        ("templates", "copy", "prusa-mk3s", f"out/{word.strip('/')}"),
        ("selftest", "--only", word or "nope"),
    )[form]
    del other
    return Try("command", words)


def _cube() -> bytes:
    """Binary STL of a tetrahedron."""
    corners = ((0, 0, 0), (9, 0, 0), (0, 9, 0), (0, 0, 9))
    faces = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))
    return _stl([corners[at] for face in faces for at in face])


def _walls() -> bytes:
    """Binary STL of a closed box that is a sound body."""
    corners = [(x, y, z) for x in (0.0, 20.0) for y in (0.0, 4.0) for z in (0.0, 10.0)]
    faces = (
        (0, 1, 3),
        (0, 3, 2),
        (4, 6, 7),
        (4, 7, 5),
        (0, 4, 5),
        (0, 5, 1),
        (2, 3, 7),
        (2, 7, 6),
        (0, 2, 6),
        (0, 6, 4),
        (1, 5, 7),
        (1, 7, 3),
    )
    return _stl([corners[at] for face in faces for at in face])


def _stl(corners: Sequence[tuple[float, ...]]) -> bytes:
    body = b"".join(
        struct.pack("<12fH", 0, 0, 0, *(x for at in corners[k : k + 3] for x in at), 0)
        for k in range(0, len(corners), 3)
    )
    return b"binary".ljust(80) + struct.pack("<I", len(corners) // 3) + body


ODD = (math.nan, math.inf, 1e300, -1e9, 1e-30, 0.0)


def bodies(rng: random.Random) -> Try:
    """A body from a mesh that is open, inverted, split, flat, far away or not of numbers."""
    data = _walls()[84:]
    faces = [bytearray(data[at : at + 50]) for at in range(0, len(data), 50)]
    for _ in range(rng.choice((1, 1, 3, 12))):
        face, way = rng.randrange(len(faces)), rng.randrange(5)
        corner = 12 * rng.randrange(1, 4) + 4 * rng.randrange(3)
        if way == 0:
            faces[face][12:36] = faces[face][24:36] + faces[face][12:24]
        elif way == 1 and len(faces) > 1:
            del faces[face]
        elif way == 2:
            faces.append(faces[face])
        elif way == 3:
            number = rng.choice(ODD)
            number = min(number, 3e38) if math.isfinite(number) else number
            faces[face][corner : corner + 4] = struct.pack("<f", number)
        else:  # a corner moves with all that share it: still closed, or folded into itself
            place = bytes(faces[face][12:24])
            moved = struct.pack("<3f", *(rng.uniform(-10.0, 30.0) for _ in range(3)))
            faces = [bytearray(bytes(one).replace(place, moved)) for one in faces]
    if rng.random() < 0.1:
        for one in faces:  # all of it inside out
            one[12:36] = one[24:36] + one[12:24]
    stl = b"binary".ljust(80) + struct.pack("<I", len(faces)) + b"".join(map(bytes, faces))
    name = rng.choice(("family", "plate", "check", "mesh", "export", "predict"))
    if name == "mesh":
        return Try("body check", ("check", "b.stl"), {"b.stl": stl})
    out = () if name in ("check", "predict") else ("--out", "out")
    quick = ("--no-pictures",) if name in ("family", "plate") else ()
    repair = rng.choice(("false", "true", "true"))
    body = f'body={{mesh="b.stl", repair={repair}}}'
    words = (name, "--tilt", "10", "--set", body, *quick, *out)
    return Try(f"body {name}", words, {"b.stl": stl})


SOLIDS: Mapping[str, bytes] = {
    "b.stl": _cube(),
    "b.obj": b"v 0 0 0\nv 9 0 0\nv 0 9 0\nv 0 0 9\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n",
    "b.off": b"OFF\n4 4 6\n0 0 0\n9 0 0\n0 9 0\n0 0 9\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n",
    "b.ply": b"ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
    b"property float z\nelement face 4\nproperty list uchar int vertex_indices\n"
    b"end_header\n0 0 0\n9 0 0\n0 9 0\n0 0 9\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n",
    "d.svg": BLOBS[-1],
    "d.dxf": b"0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n4\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n"
    b"0\nCIRCLE\n8\n0\n10\n0\n20\n0\n40\n9\n0\nENDSEC\n0\nEOF\n",
}
PIECES = (
    b"",
    b"-1",
    b"1e300",
    b"nan",
    b"1e-320",
    b"999999999",
    b"9" * 400,
    b"\xff",
    b"\0",
    b"0",
    b"inf",
    b"\x1b[31m",
    b"<!ENTITY a 'b'>",
    b"4294967295",
)


def shapes(rng: random.Random) -> Try:
    """A sound mesh or drawing with some bytes changed, doubled or cut off."""
    name = rng.choice(list(SOLIDS))
    data = bytearray(SOLIDS[name])
    for _ in range(rng.choice((1, 1, 2, 8))):
        at = rng.randrange(len(data) or 1)
        way = rng.randrange(4)
        if way == 0:
            data[at : at + rng.randrange(1, 6)] = rng.choice(PIECES)
        elif way == 1 and data:
            data[at] = rng.randrange(256)
        elif way == 2:
            del data[at:]
        else:
            data[at:at] = data[at : at + 40] * rng.choice((1, 2, 500))
    return Try(f"shape {name}", _reading(name), {name: bytes(data)})


CLASSES: tuple[tuple[Callable[[random.Random], Try], int], ...] = (
    (keys, 10),
    (limits, 4),
    (sweeps, 3),
    (names, 2),
    (kinds, 6),
    (blobs, 4),
    (paths, 4),
    (cells, 6),
    (flags, 8),
    (commands, 2),
    (shapes, 4),
    (ends, 5),
    (bodies, 5),
    (forms, 2),
)
"""Makers of tries, and how often each is drawn."""


def draw_tries(seed: int, count: int, only: str = "") -> Iterator[Try]:
    """Tries by a seed: equal seeds give equal tries."""
    rng = random.Random(seed)
    chosen = [(make, weight) for make, weight in CLASSES if not only or make.__name__ == only]
    for _ in range(count):
        (make,) = rng.choices([one for one, _ in chosen], [weight for _, weight in chosen])
        yield make(rng)
