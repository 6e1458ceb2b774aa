"""Command lines that run for a page in separate processes, so that the page never waits.

A child without a listening page is ended, and a child whose server was killed ends itself.
"""

import asyncio
import contextlib
import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import AsyncIterator, Coroutine, Sequence
from typing import Any, TypeVar

from walkergen.app import sentences
from walkergen.app.server_state import Running
from walkergen.core.files.progress import Progress

COMMAND_MODULE = "walkergen.cli.command_child"
"""Module that runs command lines as a child."""

SIMULATION_MODULE = "walkergen.app.simulation_child"
"""Module that simulates a walker: a first estimate, a run for playback, then the complete request."""

MAX_CHILDREN = 4
"""Largest number of simultaneous child processes. A browser opens six connections to a server, for all tabs together,
and sliders need some of them."""

KILL_DELAY_S = 1.0
"""Time after which an interrupted child is killed, s."""

PAUSE_S = 0.2
"""Smallest time between two progress events of a child, s."""

MAX_LINE_BYTES = 2**26
"""Longest line of a child, bytes. A run for playback is one line of 0.3 MB."""

Event = dict[str, Any]
Result = TypeVar("Result")


async def run_module(running: Running, module: str, sent: Any) -> AsyncIterator[Event]:
    """Run a module's main in a child process, and yield the events that it prints, each a line of JSON.

    The child receives `sent` as a line of JSON. After a failure, or if MAX_CHILDREN others run, the last event is
    {"refused": lines}. `running`: tasks of this server. Closing the iterator, or cancelling its task, ends the child.
    """
    task = asyncio.current_task()
    assert task is not None
    if len(running - {task}) >= MAX_CHILDREN:
        yield {
            "refused": [
                f"{MAX_CHILDREN} runs, searches or files are already being made for pages of this server. "
                "Stop one, or wait until one is done."
            ]
        }
        return
    running.add(task)
    try:
        async for event in _run_process(module, sent):
            yield event
    finally:
        running.discard(task)


async def _run_process(module: str, sent: Any) -> AsyncIterator[Event]:
    """Run a module's main in a child process and yield its events, as `run_module` does, for any number of children."""
    try:
        child = await asyncio.create_subprocess_exec(
            sys.executable,
            "-m",
            module,
            limit=MAX_LINE_BYTES,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            start_new_session=True,  # its own workers end with it
        )
    except OSError as error:
        yield {"refused": [f"the command cannot be started: {error.strerror}"]}
        return
    assert child.stdin is not None
    assert child.stdout is not None
    assert child.stderr is not None
    errors = asyncio.ensure_future(child.stderr.read())
    try:
        with contextlib.suppress(ConnectionError):  # it ended before it read its input: its output states why
            child.stdin.write(json.dumps(sent).encode() + b"\n")
            await child.stdin.drain()
        async for line in child.stdout:
            yield json.loads(line)
        code = await child.wait()
        printed = (await errors).decode(errors="replace").splitlines()
    finally:
        errors.cancel()
        await _stop_child(child)
    if code:
        yield {"refused": _error_lines(printed, code)}


def _error_lines(printed: Sequence[str], code: int) -> list[str]:
    """Return the error messages in the lines that a failed child printed; without any, the last line and the code."""
    lines = [sentences.to_plain_text(line.removeprefix("error: ")) for line in printed if line.startswith("error: ")]
    return lines or [*printed[-1:], f"the command ended with exit code {code}"]


def send_event(event: Event, stream: Any = None) -> None:
    """Send an event from this child to its server: print it to a stream, by default standard output."""
    print(json.dumps(event), file=stream, flush=True)


def progress_sender(stream: Any = None) -> Progress:
    """Return a progress callback that sends events to the server. It drops reports within PAUSE_S of the last one."""
    sent_at = 0.0

    def send_progress(what: str, done: int, total: int) -> None:
        nonlocal sent_at
        if time.monotonic() - sent_at > PAUSE_S:
            sent_at = time.monotonic()
            send_event({"progress": [what, done, total]}, stream)

    return send_progress


async def _stop_child(child: asyncio.subprocess.Process) -> None:
    """End a child and its workers: first by SIGINT, so that no file stays incomplete, then by SIGKILL."""
    try:
        _send_signal(child, "SIGINT")
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(child.wait(), KILL_DELAY_S)
    finally:
        _send_signal(child, "SIGKILL")
    await child.wait()


def _send_signal(child: asyncio.subprocess.Process, name: str) -> None:
    """Send the named signal to a child and its descendants. On Windows, end the child instead."""
    with contextlib.suppress(ProcessLookupError, PermissionError):
        if hasattr(os, "killpg"):
            os.killpg(child.pid, getattr(signal, name))
        elif child.returncode is None:
            child.terminate()


async def run_until_disconnect(receive: Any, work: Coroutine[Any, Any, Result]) -> Result | None:
    """Await `work` and return its result. Cancel it and return None if `receive` (of ASGI) reports a closed page."""
    working, gone = asyncio.ensure_future(work), asyncio.ensure_future(_wait_for_disconnect(receive))
    try:
        await asyncio.wait({working, gone}, return_when=asyncio.FIRST_COMPLETED)
    finally:
        gone.cancel()
        working.cancel()
        await asyncio.wait({working})
    return None if working.cancelled() else working.result()


async def _wait_for_disconnect(receive: Any) -> None:
    while (await receive())["type"] != "http.disconnect":
        pass


async def stop_all(running: Running) -> None:
    """End all children of a server, and the tasks that wait for them."""
    for task in running:
        task.cancel()
    if running:
        await asyncio.wait(set(running))


def receive_and_watch_server() -> Any:
    """Return the JSON value that the server sent to this child. Start a thread that ends the child with the server.

    The thread waits until standard input is closed, as happens when the server ends in any way.
    """
    sent = json.loads(sys.stdin.buffer.readline() or b"null")

    def exit_with_server() -> None:
        while os.read(sys.stdin.fileno(), 4096):
            pass
        if hasattr(os, "killpg"):
            os.kill(os.getpid(), signal.SIGINT)  # unfinished files are removed
            time.sleep(KILL_DELAY_S)
            os.killpg(0, signal.SIGKILL)
        os._exit(1)

    threading.Thread(target=exit_with_server, daemon=True).start()
    return sent
