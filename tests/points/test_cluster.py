"""A sweep on a dask cluster: a real scheduler and two workers; one is killed."""

import contextlib
import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time

import pytest
from typer.testing import CliRunner

from walkergen.cli import command_line
from walkergen.core.errors import InputError
from walkergen.points import worker_pool

POINTS = [
    "sweep",
    "koumakis2016",
    "--set",
    "legs.tilt_deg=1:40:1",
    "--set",
    "scene.contact.friction=0.1:0.34:0.01",
    "--no-pictures",
    "--quiet",
]


def start_dask(module, *arguments, cwd=None, **environment):
    """Program of dask's in a process of its own."""
    return subprocess.Popen(
        [sys.executable, "-m", f"distributed.cli.{module}", *arguments, "--no-dashboard"],
        stderr=subprocess.DEVNULL,
        cwd=cwd,
        env=os.environ | environment,
    )


def worker(folder, name, **others):
    """Worker of one thread, of the scheduler whose address a file in the folder has."""
    words = ("--scheduler-file", str(folder / "scheduler.json"), "--nthreads", "1", "--no-nanny")
    return start_dask("dask_worker", *words, "--local-directory", str(folder / name), **others)


@pytest.fixture
def cluster(tmp_path):
    """Address of a scheduler, and its two workers."""
    file = tmp_path / "scheduler.json"
    programs = [start_dask("dask_scheduler", "--port", "0", "--scheduler-file", str(file))]
    programs += [worker(tmp_path, name) for name in "ab"]
    try:
        from distributed import Client

        until = time.monotonic() + 60.0
        while not (file.exists() and file.read_text().endswith("}")) and time.monotonic() < until:
            time.sleep(0.1)  # it is written with a delay
        address = json.loads(file.read_text())["address"]
        with Client(address, set_as_default=False) as client:
            client.wait_for_workers(2, timeout=60)
        yield address, programs[1:]
    finally:
        for program in programs:
            program.kill()
            program.wait()


@pytest.mark.nightly
def test_killing_a_worker_changes_no_bit(cluster, tmp_path, monkeypatch):
    address, workers = cluster
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    command = [sys.executable, "-m", "walkergen", *POINTS]
    sweep = subprocess.Popen([*command, "--dask", address, "--out", str(tmp_path / "cluster")])
    table = tmp_path / "cluster" / "table.csv"
    until = time.monotonic() + 120.0
    while (not table.exists() or table.stat().st_size < 2000) and time.monotonic() < until:
        time.sleep(0.05)
    assert sweep.poll() is None  # in the middle
    workers[0].send_signal(signal.SIGKILL)
    assert sweep.wait(timeout=120) == 0
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "other"))
    here = CliRunner().invoke(command_line, [*POINTS, "--out", str(tmp_path / "here")])
    assert here.exit_code == 0, here.output
    assert table.read_bytes() == (tmp_path / "here" / "table.csv").read_bytes()
    assert table.read_bytes().count(b"\n") == 1 + 1000


@pytest.mark.slow
def test_a_worker_without_walkergen_is_named(cluster, tmp_path):
    from distributed import Client

    address, _ = cluster
    (tmp_path / "none").mkdir()
    (tmp_path / "none" / "walkergen.py").write_text('raise ModuleNotFoundError("none here")')
    third = worker(tmp_path, "c", cwd=tmp_path, PYTHONPATH=str(tmp_path / "none"))
    try:
        with Client(address, set_as_default=False) as client:
            client.wait_for_workers(3, timeout=60)
        with pytest.raises(InputError, match=r"worker tcp.* has .*none here"), worker_pool.dask_pool(address):
            pass
    finally:
        third.kill()
        third.wait()


def test_a_scheduler_that_is_not_there_is_one_line(monkeypatch):
    monkeypatch.setattr(worker_pool, "ANSWER_TIMEOUT_S", 0.5)
    with pytest.raises(InputError, match="no scheduler answers there"), worker_pool.dask_pool("tcp://[::1]:9"):
        pass


@pytest.mark.parametrize(
    "answer", [b"", bytes(100), b"\xff" * 5000, b"HTTP/1.1 400 Bad\r\n\r\n", b"SSH-2.0-OpenSSH_9\r\n", b"\0"]
)
def test_a_server_that_is_silent_or_answers_nonsense_is_no_scheduler(monkeypatch, answer):
    monkeypatch.setattr(worker_pool, "ANSWER_TIMEOUT_S", 0.5)
    with socket.create_server(("127.0.0.1", 0)) as server:

        def serve():
            with contextlib.suppress(OSError), server.accept()[0] as connection:
                connection.sendall(answer)
                connection.recv(1)

        threading.Thread(target=serve, daemon=True).start()
        address = f"tcp://127.0.0.1:{server.getsockname()[1]}"
        started = time.monotonic()
        with pytest.raises(InputError, match="no scheduler answers there"), worker_pool.dask_pool(address):
            pass
        assert time.monotonic() - started < 5.0


@pytest.mark.parametrize("address", ["tls://x:1", "ucx://x:1", "tcp://x", "x", "", "tcp://x:1e9"])
def test_an_address_of_another_kind_is_refused(address):
    with pytest.raises(InputError, match=r"write tcp://HOST:PORT"), worker_pool.dask_pool(address):
        pass


def test_workers_of_another_version_are_refused():
    with pytest.raises(InputError, match="worker b has another version of walkergen"):
        worker_pool.check_digests({"a": worker_pool.digest(), "b": "0123456789abcdef"})
    with pytest.raises(InputError, match="worker b has ModuleNotFoundError: No module named"):
        worker_pool.check_digests({"b": "ModuleNotFoundError: No module named 'walkergen'"})
