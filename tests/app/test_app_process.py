"""The process of `walkergen app`: its address, what runs for its pages, and the end of both."""

import contextlib
import http.client
import itertools
import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
import urllib.request
from types import SimpleNamespace

import numpy as np
import pytest
from app_doors import LINUX, PAPER, Doors, Process, document, files, lives, until

from walkergen.app import server_process

LONG = document(scene__run__seconds=1e4, scene__run__runs=100)
"""A run that nobody waits for."""

needs_proc = pytest.mark.skipif(not LINUX, reason="looks processes up in /proc")


@pytest.fixture
def process(tmp_path):
    with Process(tmp_path) as process:
        yield process


@needs_proc
@pytest.mark.slow
def test_a_page_that_goes_ends_its_run(process):
    connection = process.send("run", {"document": LONG})
    assert until(process.children)
    time.sleep(1.0)  # amidst its imports
    connection.close()
    assert until(lambda: not process.children(), 10.0)
    for door in ("crowd", "nearest"):
        asked = {"document": LONG, "speed": 60}
        connection = process.send(door, asked)
        running = connection.getresponse()
        pids = until(process.children)
        running.close()
        connection.close()
        assert until(lambda pids=pids: not any(map(lives, pids)), 10.0)


@needs_proc
@pytest.mark.slow
@pytest.mark.parametrize("door", ["run", "nearest", "make"])
def test_a_killed_server_leaves_no_process_and_no_half_file(process, tmp_path, door):
    asked = {"document": LONG, "speed": 60, "what": "zip"}
    with contextlib.closing(process.send(door, asked)):
        pids = until(process.children)
        for wait_s in (0.5, 1.5):  # workers of a search begin meanwhile
            time.sleep(wait_s)
            pids = sorted({*pids, *process.children()})
        process.process.kill()
        assert until(lambda: not any(map(lives, pids)), 30.0)  # 1 s on an idle machine
    assert not [name for name in files(tmp_path) if ".walkergen-" in name]


@needs_proc
@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL, signal.SIGINT])
def test_a_server_that_ends_while_it_saves_keeps_a_whole_document(tmp_path, number):
    tilts = itertools.cycle((5.0, 17.0))
    for moment in np.random.default_rng(number).uniform(0.0, 0.3, int(os.environ.get("WALKERGEN_FAULTS", "2"))):
        with Process(tmp_path) as process, contextlib.suppress(OSError, http.client.HTTPException):
            process.ask("keep", {"document": document(legs__tilt_deg=next(tilts))})
            threading.Timer(moment, process.process.send_signal, [number]).start()
            while True:
                process.ask("keep", {"document": document(legs__tilt_deg=next(tilts))})
        kept = json.loads((tmp_path / "out" / "app" / "kept.json").read_bytes())["document"]
        assert kept in [document(legs__tilt_deg=tilt) for tilt in (5.0, 17.0)]
        assert Doors(tmp_path).ask("start", {}).json["document"] == kept


@needs_proc
@pytest.mark.slow
def test_ctrl_c_ends_the_server_at_once_whatever_runs(process):
    connections = [process.send("run", {"document": LONG}) for _ in range(4)]
    assert until(lambda: len(process.children()) >= 4)
    pids = process.children()
    code, seconds, errors = process.end()
    assert (code, errors) == (0, "")
    assert seconds < 4.0  # 2 s on an idle machine
    assert until(lambda: not any(map(lives, pids)), 5.0)
    for connection in connections:
        connection.close()


@needs_proc
@pytest.mark.slow
def test_ten_tabs_start_four_runs_and_the_others_hear_why(process):
    connections = [process.send("run", {"document": LONG}) for _ in range(10)]
    assert until(lambda: len(process.children()) >= 4)
    # Whoever runs says how far it is
    answers = [connection.getresponse() for connection in connections]
    first = [json.loads(answer.readline()) for answer in answers]
    refused = [event["refused"] for event in first if "refused" in event]
    assert len(refused) == 6
    assert all("4 runs, searches or files" in line for (line,) in refused)
    assert len(process.children()) == 4
    assert process.ask("walker", {"document": PAPER}).status == 200
    for each in (*answers, *connections):
        each.close()
    assert until(lambda: not process.children(), 10.0)


@needs_proc
@pytest.mark.slow
def test_work_whose_page_has_gone_makes_nobody_wait(process):
    first = process.ask("walker", {"document": PAPER})
    assert first.status == 200
    for number in range(100):
        process.send("outlook", {"document": document(body__length_mm=20.0 + 0.1 * number)}).close()
    begun = time.monotonic()
    assert process.ask("walker", {"document": PAPER}).body == first.body
    assert time.monotonic() - begun < 10.0  # 0.1 s on an idle machine; 100 curves take 30


@pytest.mark.slow
def test_a_connection_on_which_nothing_comes_is_closed(process):
    host, _, port = process.host.partition(":")
    silent, begun = (socket.create_connection((host, int(port)), 40.0) for _ in range(2))
    with silent, begun:
        begun.sendall(b"POST / HTTP/1.1\r\nHost: x\r\nX")
        assert silent.recv(1) == begun.recv(1) == b""


def test_a_connection_that_is_quiet_whenever_it_is_looked_at_stays_open():
    """One that answers between two looks was closed with a page's next step on its way."""
    looks, message = [], SimpleNamespace(response_complete=True)
    closed = SimpleNamespace(is_closing=lambda: False, close=lambda: looks.append("closed"))
    later = SimpleNamespace(call_later=lambda _, look, before: looks.append(before))
    connection = SimpleNamespace(transport=closed, loop=later, cycle=message, _close_if_idle=None)
    server_process._IdleTimeoutProtocol._close_if_idle(connection, None)
    connection.cycle = other = SimpleNamespace(response_complete=True)
    server_process._IdleTimeoutProtocol._close_if_idle(connection, message)
    assert looks == [message, other]
    server_process._IdleTimeoutProtocol._close_if_idle(connection, other)
    assert looks[-1] == "closed"


@pytest.mark.slow
def test_an_upload_over_the_limit_hears_why(process):
    answer = process.ask("upload?kind=stl", b"x" * 200_000_001)
    assert (answer.status, answer.refused) == (422, "more than 200 MB")


@needs_proc
def test_a_server_ends_quietly(process):
    assert process.ask("walker", {"document": PAPER}).status == 200
    assert process.end()[::2] == (0, "")


def refusal_of(*words):
    """Line with which `walkergen app` refuses to start."""
    done = subprocess.run(
        [sys.executable, "-m", "walkergen", "app", "--no-browser", *words], capture_output=True, text=True, timeout=60
    )
    assert done.returncode == 2
    assert done.stdout == ""
    assert "Traceback" not in done.stderr
    return done.stderr


@pytest.mark.slow
def test_a_port_in_use_is_refused_in_one_line(process):
    port = process.host.rpartition(":")[2]
    line = refusal_of("--port", port)
    reason = "Address already in use: choose another port, or 0 for a free one"
    assert line == f"error: --port {port}: {reason}\n"


@pytest.mark.slow
@pytest.mark.parametrize("host", ["192.0.2.1", "0.0.0.0", "::", "no.such.host.invalid", "a b", ""])
def test_an_address_of_no_interface_is_refused_in_one_line(host):
    line = refusal_of("--port", "0", "--host", host)
    assert line.startswith(f"error: --host {host or repr(host)}: ")
    assert len(line.splitlines()) == 1


def test_a_port_of_no_machine_is_refused():
    assert "--port" in refusal_of("--port", "70000")


def test_a_walker_that_is_none_is_refused_before_a_page_opens():
    assert "nosuch" in refusal_of("nosuch")
    assert "nosuch" in refusal_of("--scene", "nosuch")


def own_address():
    """Address of this machine that others can call; None without a network."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("192.0.2.1", 9))  # sends nothing
        except OSError:
            return None
        return probe.getsockname()[0]


@pytest.mark.skipif(own_address() is None, reason="no address but the loopback")
def test_an_address_given_by_hand_opens_its_page_once(tmp_path):
    with Process(tmp_path, "--host", own_address()) as process:
        assert process.path.startswith("/once/")
        with urllib.request.urlopen(f"http://{process.host}{process.path}") as page:
            process.path = page.url.removeprefix(f"http://{process.host}")
            assert b"walkergen" in page.read()
        assert process.ask("walker", {"document": PAPER}).status == 200
        assert process.ask("walker", {"document": PAPER}, host="127.0.0.1").status == 403


def test_a_signal_to_end_is_obeyed(process):
    assert process.end(signal.SIGTERM)[0] == -signal.SIGTERM
