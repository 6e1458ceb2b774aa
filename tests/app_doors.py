"""Doors of `walkergen app`, called in this process or in one of its own, and hostile messages."""

import asyncio
import contextlib
import http.client
import json
import math
import os
import random
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

from walkergen.app import server, server_state
from walkergen.app.document import Document
from walkergen.core.files import config
from walkergen.core.printing.printers import Printer
from walkergen.core.scene import Scene
from walkergen.core.walker.design import Design

HOST = "127.0.0.1:8765"
PATIENCE_S = 180.0
"""Longest wait for what takes a second on an idle machine."""

PAPER = {"walker": "koumakis2016", "scene": "plane-90hz", "printer": "prusa-mk3s", "values": {}}
"""Document of a page without changed keys."""

QUICK = ("start", "walker", "outlook", "curve", "shares", "form", "spans", "keep", "upload", "take", "effects_drawn")
MAKING = ("run", "crowd", "nearest", "make", "effects")
"""Addresses that the server answers itself, and those that a child process answers."""


def document(**values):
    """Document of the paper's walker; two underscores in a key mean a dot."""
    return PAPER | {"values": {key.replace("__", "."): value for key, value in values.items()}}


class Answer(NamedTuple):
    status: int
    headers: dict[str, str]
    body: bytes

    @property
    def json(self) -> Any:
        return json.loads(self.body)

    @property
    def refused(self) -> str:
        """Words of a refusal, in a line each."""
        return "\n".join(line["text"] for line in self.json["refused"])

    @property
    def events(self) -> list[Any]:
        return [json.loads(line) for line in self.body.splitlines()]


class Doors:
    """Application of a server whose folder is out/app below a folder, called without a socket."""

    begun: ClassVar[list[Any]] = []
    """Servers of this one and the one before; processes of earlier ones end."""

    def __init__(self, folder: Path, away: bool = False, own: str | None = None) -> None:
        self.folder = folder / "out" / "app"
        walker = own or PAPER["walker"]
        first = Document(walker, PAPER["scene"], PAPER["printer"], server_state.START_VALUES)
        self.server = server_state.make_server(self.folder, frozenset([HOST]), first, own, away, own is not None)
        self.app = server.application(self.server)
        Doors.begun.append(self.server)
        while len(Doors.begun) > 2:
            gone = Doors.begun.pop(0)
            for workers in (gone.steps, gone.workers):
                workers.stop()

    def make_files(self, message):
        """Answer with files, once they are made; the refusal where they cannot be."""
        made = self.ask("make", message)
        refused = [] if made.status != 200 else [event for event in made.events if "refused" in event]
        if refused:
            lines = [{"key": "", "text": line} for line in refused[0]["refused"]]
            return made._replace(status=422, body=json.dumps({"refused": lines}).encode())
        return self.ask("take", message) if made.status == 200 else made

    def ask(self, door, message=None, leave_s=None, method="POST", query="", **headers):
        """Answer to a message (bytes, or what becomes JSON); the page goes after `leave_s`."""
        data = message if isinstance(message, bytes) else json.dumps(message).encode()
        return self.request(f"/{self.server.secret}/{door}", data, leave_s, method, query, **headers)

    def request(self, path, data=b"", leave_s=None, method="POST", query="", **headers):
        """Answer to a request by its whole path."""
        fields = {"host": HOST} | headers
        scope = {
            "type": "http",
            "method": method,
            "path": path,
            "raw_path": path.encode(),
            "query_string": query.encode(),
            "root_path": "",
            "scheme": "http",
            "http_version": "1.1",
            "server": ("127.0.0.1", 8765),
            "client": ("127.0.0.1", 1),
            "headers": [(key.encode(), value.encode("latin-1")) for key, value in fields.items()],
        }
        return asyncio.run(self._request(scope, data, leave_s))

    async def _request(self, scope, data, leave_s):
        pieces = [data[at : at + 65536] for at in range(0, len(data), 65536)] or [b""]
        sent: list[Any] = []

        async def receive():
            if pieces:
                piece = pieces.pop(0)
                return {"type": "http.request", "body": piece, "more_body": bool(pieces)}
            await asyncio.sleep(PATIENCE_S if leave_s is None else leave_s)
            return {"type": "http.disconnect"}

        async def send(message):
            sent.append(message)

        await self.app(scope, receive, send)
        start, *rest = sent
        headers = {key.decode(): value.decode("latin-1") for key, value in start["headers"]}
        return Answer(start["status"], headers, b"".join(each.get("body", b"") for each in rest))


class Process:
    """`walkergen app` in a process of its own, a context that ends it."""

    def __init__(self, folder: Path, *words: str) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-m", "walkergen", "app", "--port", "0", "--no-browser", *words],
            cwd=folder,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        line = self.process.stdout.readline()
        self.host, self.path = re.search(r"http://([^/]+)(/\S*)", line).groups()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.communicate()

    def send(self, door, message, **headers):
        """Connection on which a message was sent; its answer is not awaited."""
        connection = http.client.HTTPConnection(self.host, timeout=PATIENCE_S)
        data = message if isinstance(message, bytes) else json.dumps(message).encode()
        connection.request("POST", self.path + door, data, headers)
        return connection

    def ask(self, door, message, **headers):
        """Answer to a message."""
        with contextlib.closing(self.send(door, message, **headers)) as connection:
            answer = connection.getresponse()
            return Answer(answer.status, dict(answer.getheaders()), answer.read())

    def children(self):
        """Process ids of its children and theirs, also of those whose parent has gone, but for its workers."""
        return [pid for pid in pids() if is_below(pid, self.process.pid) and not is_worker(pid)]

    def end(self, number=signal.SIGINT):
        """Exit code, time that the end took (s), and what was printed of errors."""
        begun = time.monotonic()
        self.process.send_signal(number)
        _, errors = self.process.communicate(timeout=PATIENCE_S)
        return self.process.returncode, time.monotonic() - begun, errors


def pids():
    return [int(path.name) for path in Path("/proc").iterdir() if path.name.isdigit()]


def is_below(pid, parent):
    """True for a process that descends from another that lives."""
    while pid > 1:
        try:
            stat = Path(f"/proc/{pid}/stat").read_text()
        except OSError:
            return False
        pid = int(stat.rpartition(")")[2].split()[1])
        if pid == parent:
            return True
    return False


def is_worker(pid):
    """True for a process that answers for pages, and for what keeps its pipes."""
    try:
        return b"multiprocessing" in Path(f"/proc/{pid}/cmdline").read_bytes()
    except OSError:
        return True


def lives(pid):
    """True for a process that runs; False for one that has ended, awaited or not."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def until(condition, seconds=PATIENCE_S):
    """Wait for a condition; returns what it was at last."""
    end = time.monotonic() + seconds
    while not (value := condition()) and time.monotonic() < end:
        time.sleep(0.02)
    return value


def files(folder):
    """Names of all files below a folder."""
    return {str(path.relative_to(folder)) for path in folder.rglob("*") if not path.is_dir()}


# --- hostile messages ----------------------------------------------------------------------------

KEYS = [
    prefix + ".".join(path)
    for prefix, model in (("", Design), ("scene.", Scene), ("printer.", Printer))
    for path in config.key_paths(model)
] + ["legs[1].tilt_deg", "legs[2].along_mm", "legs[99].kind", "walker.mesh", "body.points_mm"]
ODD = (
    None,
    True,
    False,
    0,
    -1,
    1e-320,
    1e308,
    math.nan,
    math.inf,
    -math.inf,
    2**63,
    10**400,
    "",
    "x",
    "nan",
    "1e5",
    "\x00",
    "\x1b[31m",
    "\x7f",
    "\u202e",
    "\ud800",
    "\U0001f600",
    "é" * 300,
    "a" * 200_000,
    "../../etc/passwd",
    "/etc/passwd",
    "C:\\x.stl",
    "disc",
    "text",
    "braced",
    "auto",
    "0" * 16 + ".stl",
    [],
    {},
    [[]],
    [1, "a"],
    {"": 1},
    {"a.b": {"c": [{}]}},
    [[-1e9, 0], [0, 0], [1, 1]],
    [{"kind": "braced"}] * 3,
    {"tilt_deg": 5},
    "=",
    "a\nb = 1",
    '"',
)
"""Values that no page sends."""

BLOBS = (
    b"",
    b"null",
    b"[]",
    b"{",
    b"\xff\xfe",
    b'{"document": 1}',
    b'{"document": {}}',
    b"[" * 100_000,
    b'{"a":' * 5000 + b"1" + b"}" * 5000,
    b'{"document": {"walker": NaN}}',
    b"9" * 5000,
    b'{"document": ' + b"[" * 40 + b"]" * 40 + b"}",
    b'"' + b"x" * 1_200_000 + b'"',
)
"""Messages that are no documents."""


def value(rng):
    """Value of a key: odd, or a number such as keys have, or odd ones within lists and tables."""
    way = rng.random()
    if way < 0.4:
        return rng.choice((0.1, 0.5, 1, 2, 4, 10, 30, 45, 90)) * rng.choice((1, 1, 1, -1, 0.37))
    if way < 0.9:
        return rng.choice(ODD)
    inner = [value(rng) for _ in range(rng.randrange(3))]
    return inner if rng.random() < 0.5 else {rng.choice(KEYS)[:20]: each for each in inner}


def message(rng):
    """Message of no page, or of one that sets a few keys to random values."""
    if rng.random() < 0.1:
        return rng.choice(BLOBS)
    asked: dict[Any, Any] = {"document": json.loads(json.dumps(PAPER))}
    asked["document"]["scene"] = rng.choice(("plane-90hz", "lane-90hz"))
    for _ in range(rng.choice((0, 1, 1, 2, 3))):
        key = rng.choice(KEYS) if rng.random() < 0.9 else str(rng.choice(ODD))[:100]
        asked["document"]["values"][key] = value(rng)
    if rng.random() < 0.1:
        asked["document"][rng.choice(("walker", "scene", "printer", "values", "more"))] = value(rng)
    asked |= {"what": "stl", "copies": 1, "speed": 40, "rough": True}
    asked["keys"] = ["legs.tilt_deg", "body.length_mm"]
    for key in ("what", "copies", "speed", "keys", "rough"):
        if rng.random() < 0.2:
            asked[key] = value(rng)
    return json.dumps(asked).encode("utf-8", "surrogatepass")


def messages(seed, count):
    """Messages by a seed."""
    rng = random.Random(seed)
    return [message(rng) for _ in range(count)]


def faults(answer):
    """Return what is wrong with an answer: nothing if it is valid or a refusal in words."""
    if answer.status in (200, 204, 503):  # the page went before its answer, or its file, was made
        return []
    if not 400 <= answer.status < 500:
        return [f"status {answer.status}"]
    lines = answer.json["refused"]
    texts = [line["text"] for line in lines]
    found = [] if texts and all(texts) else ["no words"]
    if any(len(text) > 200 or not text.isprintable() for text in texts):
        found.append(f"words that cannot be shown: {texts}")
    if any(word in text for text in texts for word in ("Traceback", "page:")):
        found.append(f"words of a programmer: {texts}")
    return found


LINUX = sys.platform == "linux" and os.path.isdir("/proc")  # noqa: PTH112
