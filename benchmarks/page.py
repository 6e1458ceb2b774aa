"""The server of `walkergen app` without a browser: a slider's step, a large mesh, the zip, a first number of a run.

Each row is a time by the clock, and the CPU time of the server with all its processes, and the goal.
Run: python benchmarks/page.py [--steps 40]
"""

import argparse
import contextlib
import http.client
import json
import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from app import PAPER, large_mesh, quantiles

WARM_S = 6.0
"""Time for processes of the server to import what they need."""


class Server:
    """`walkergen app` in a folder of its own, asked as a page does."""

    def __init__(self, folder):
        words = [sys.executable, "-m", "walkergen", "app", "--port", "0", "--no-browser"]
        self.process = subprocess.Popen(words, cwd=folder, stdout=subprocess.PIPE, text=True, start_new_session=True)
        address = re.search(r"http://([^/]+)(/\S*)", self.process.stdout.readline())
        self.host, self.path = address.groups()

    def ask(self, door, message, until=lambda line: False):
        """Lines of an answer, up to one that is waited for, and the time to it, s."""
        begun = time.monotonic()
        with contextlib.closing(http.client.HTTPConnection(self.host)) as connection:
            data = message if isinstance(message, bytes) else json.dumps(message)
            connection.request("POST", self.path + door, data)
            answer = connection.getresponse()
            lines = []
            for line in answer:
                lines.append(line)
                if until(line):
                    break
            assert answer.status == 200, lines
        return lines, time.monotonic() - begun

    def cpu_seconds(self):
        """CPU time of the server, of all that it has started and of what of that has ended, s."""
        parents, times = {}, {}
        for path in Path("/proc").glob("[0-9]*/stat"):
            with contextlib.suppress(OSError):
                fields = path.read_text().rpartition(")")[2].split()
                parents[int(path.parent.name)] = int(fields[1])
                times[int(path.parent.name)] = sum(map(int, fields[11:15]))
        below = {self.process.pid}
        while more := {pid for pid, parent in parents.items() if parent in below} - below:
            below |= more
        return sum(times[pid] for pid in below) / os.sysconf("SC_CLK_TCK")


def document(walker="koumakis2016", **values):
    return PAPER | {"walker": walker, "values": {key.replace("__", "."): value for key, value in values.items()}}


def row(name, times, cpu, goal=""):
    clock = f"{1e3 * times[0]:.0f} ms" if len(times) == 1 else quantiles(1e3 * np.array(times))
    print(f"{name:38} {clock:26} CPU {1e3 * cpu / len(times):7.0f} ms  {goal}", flush=True)


def time_requests(server, name, door, messages, goal="", until=lambda line: False):
    """Print how long answers to messages took, one after the other; returns the last one."""
    before = server.cpu_seconds()
    times = []
    for message in messages:
        lines, taken = server.ask(door, message, until)
        times.append(taken)
    row(name, times, server.cpu_seconds() - before, goal)
    return lines


def print_rows(server, folder, count):
    """Print every row."""
    rng = np.random.default_rng(1)
    server.ask("walker", {"document": document()})
    server.ask("outlook", {"document": document()})
    time.sleep(WARM_S)
    spans = {"legs__tilt_deg": (3, 25), "body__length_mm": (26, 32), "scene__contact__friction": (0.2, 0.4)}
    for key, (low, high) in spans.items():
        pages = [{"document": document(**{key: round(value, 3)})} for value in rng.uniform(low, high, count)]
        time_requests(server, f"step of {key.replace('__', '.')}", "walker", pages, "goal p95 150 ms, with the browser")
    lengths = [document(body__length_mm=round(value, 3)) for value in rng.uniform(26, 32, 6)]
    time_requests(server, "what the printer says", "outlook", [{"document": each} for each in lengths])
    rough = [{"document": each, "rough": True} for each in lengths]
    time_requests(server, "curve while a slider moves", "curve", rough, "goal 40 ms")
    time_requests(server, "curve at rest", "curve", [{"document": each} for each in lengths])
    time_requests(server, "what to measure next, on wish", "shares", [{"document": each} for each in lengths])
    path, faces = large_mesh(folder)
    (answer,) = time_requests(server, f"upload, {faces} faces", "upload?kind=stl", [path.read_bytes()], "goal 400 ms")
    body = {"body": {"mesh": json.loads(answer)["file"]}, "legs.placement": "auto"}
    mesh = [{"document": PAPER | {"values": body | {"legs.tilt_deg": tilt}}} for tilt in np.linspace(5, 15, 6).round(2)]
    time_requests(server, "its first walker", "walker", mesh[:1], "goal 400 ms, with the upload")
    time_requests(server, "further steps of it", "walker", mesh[1:], "goal 400 ms")
    order = {"document": document(legs__tilt_deg=9.0), "what": "zip", "copies": 4}
    time_requests(server, "the zip, made", "make", [order], "goal 5 s")
    time_requests(server, "the zip, handed out", "take", [order])
    run = {"document": document(legs__tilt_deg=9.0, scene__run__seconds=10.0, scene__run__runs=8)}
    told = b'"first": true'
    lines = time_requests(server, "let it run, to a first number", "run", [run], "goal 4 s", lambda line: told in line)
    assert told in lines[-1]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, default=40)
    options = parser.parse_args()
    print(f"{os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}")
    with tempfile.TemporaryDirectory() as folder:
        server = Server(folder)
        try:
            print_rows(server, Path(folder), options.steps)
        finally:
            server.process.terminate()
            server.process.wait()


if __name__ == "__main__":
    main()
