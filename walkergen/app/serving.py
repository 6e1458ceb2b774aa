"""The server as a process: its port, its address, its end."""

import ipaddress
import socket
import threading
import webbrowser
from pathlib import Path

import uvicorn

from walkergen.app import server as servers
from walkergen.app.document import Document
from walkergen.errors import InputError
from walkergen.files import templates
from walkergen.files.config import read
from walkergen.printing.printers import Printer
from walkergen.scene import Scene
from walkergen.walker.design import Design

LOOPBACK = ("127.0.0.1", "localhost")


def serve(
    design: str, scene: str, printer: str, folder: Path, host: str, port: int, browser: bool
) -> None:
    """Serve pages until Ctrl-C. Raises InputError for files and addresses that are unusable."""
    own = None if design in templates.names("walkers") else design
    for name, kind, model in ((design, "walkers", Design), (scene, "scenes", Scene),
                              (printer, "printers", Printer)):  # fmt: skip
        read(templates.path_of(name, kind), model)
    first = Document(design, scene, printer, servers.START)
    listening = _listening(host, port)
    port = listening.getsockname()[1]
    away = host not in LOOPBACK
    names = (host, *LOOPBACK) if not away else (host,)
    served = servers.new(folder, frozenset(f"{name}:{port}" for name in names), first, own, away)
    path = f"once/{served.once}" if served.once else f"{served.secret}/"
    address = f"http://{host}:{port}/{path}"
    print(f"the page: {address}", flush=True)
    print("Ctrl-C ends it" if not away else "for one device, once; Ctrl-C ends it", flush=True)
    if browser and not away:
        threading.Timer(0.3, webbrowser.open, [address]).start()
    config = uvicorn.Config(
        servers.application(served), log_level="error", access_log=False, server_header=False,
        timeout_graceful_shutdown=1, ws="none", lifespan="off",
    )  # fmt: skip
    uvicorn.Server(config).run(sockets=[listening])


def _listening(host: str, port: int) -> socket.socket:
    """Socket that listens at an address. Raises InputError."""
    try:
        family = socket.AF_INET6 if ipaddress.ip_address(host).version == 6 else socket.AF_INET
    except ValueError:
        family = socket.AF_INET
    listening = socket.socket(family)
    listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listening.bind((host, port))
        listening.listen()  # a browser that is quicker than the server waits
    except (OSError, UnicodeError) as error:
        listening.close()
        reason = getattr(error, "strerror", None) or error
        raise InputError(
            f"--host {host} --port {port}: {reason}: give another port, or 0 for any that is free"
        ) from None
    return listening
