"""Process of the server: its port, its address, its shutdown."""

import contextlib
import errno
import ipaddress
import logging
import socket
import threading
import webbrowser
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import uvicorn
from uvicorn.protocols.http.h11_impl import H11Protocol

from walkergen.app import server_state as servers
from walkergen.app.document import Document
from walkergen.core.errors import InputError
from walkergen.files import templates

LOOPBACK = ("127.0.0.1", "localhost")

PLAIN_PORT = 80
"""Port that browsers omit from an address."""


IDLE_S = 10.0
"""Time after which a connection without an answer in progress is closed, s."""


class _IdleTimeoutProtocol(H11Protocol):
    """Connection that is closed when it receives nothing, or when a message stalls."""

    def connection_made(self, transport: Any) -> None:
        super().connection_made(transport)
        self.loop.call_later(IDLE_S, self._close_if_idle, None)

    def _close_if_idle(self, before: Any) -> None:
        """Close the connection if no request came, or if `before`, the request at the last check, is still the last."""
        if self.transport.is_closing():
            return
        if self.cycle is None or (self.cycle is before and self.cycle.response_complete):
            self.transport.close()
        else:
            self.loop.call_later(IDLE_S, self._close_if_idle, self.cycle)


class _CleanupServer(uvicorn.Server):
    """Server that first ends the children of its pages at shutdown, and logs nothing more."""

    def __init__(self, config: uvicorn.Config, state: servers.Server) -> None:
        super().__init__(config)
        self._state = state

    async def shutdown(self, sockets: Any = None) -> None:
        """Stop child processes and workers, then the server."""
        from walkergen.app import child_processes

        logging.getLogger("uvicorn.error").disabled = True
        await child_processes.stop_all(self._state.running)
        for workers in (self._state.steps, self._state.workers):
            workers.stop()
        await super().shutdown(sockets)


def serve(start: Document, replaces_saved: bool, folder: Path, host: str, port: int, browser: bool) -> None:
    """Serve the page until Ctrl-C. Raises InputError for an unusable `host` or `port`.

    Parameters
    ----------
    start
        Valid document that the page begins with, unless there is a saved one.
    replaces_saved
        True to begin with `start` even if there is a saved document, which it replaces.
    folder
        Folder for all output.
    host, port
        Address of this machine and port; port 0 for a free one.
    browser
        True to open the page.
    """
    own_file = None if start.walker in templates.names("walkers") else start.walker
    first = start._replace(values=servers.START_VALUES | dict(start.values))
    remote = _is_remote(host)
    listening = _open_socket(host, port)
    port = listening.getsockname()[1]
    names = (host,) if remote else (host, *LOOPBACK)
    served = servers.make_server(folder, _allowed_hosts(names, port), first, own_file, remote, replaces_saved)
    path = f"once/{served.once}" if served.once else f"{served.secret}/"
    address = f"http://{_bracket_ipv6(host)}:{port}/{path}"
    for workers in (served.steps, served.workers):
        workers.start()
    print(f"the page: {address}", flush=True)
    print("Ctrl-C ends it" if not remote else "for one device, once; Ctrl-C stops it", flush=True)
    if browser and not remote:
        threading.Timer(0.3, webbrowser.open, [address]).start()
    with contextlib.suppress(KeyboardInterrupt):  # Ctrl-C ends the server
        from walkergen.app import server  # this import takes as long as the browser takes to start

        config = uvicorn.Config(
            server.application(served),
            log_level="error",
            access_log=False,
            server_header=False,
            timeout_graceful_shutdown=1,
            ws="none",
            lifespan="off",
            http=_IdleTimeoutProtocol,
            loop="asyncio",
        )
        _CleanupServer(config, served).run(sockets=[listening])


def _allowed_hosts(names: Sequence[str], port: int) -> frozenset[str]:
    """Return the values of the header Host that browsers send for these names and a port."""
    bracketed = [_bracket_ipv6(name).lower() for name in names]
    plain = bracketed if port == PLAIN_PORT else []
    return frozenset([*(f"{name}:{port}" for name in bracketed), *plain])


def _bracket_ipv6(host: str) -> str:
    """Return a host as written in a URL: IPv6 addresses in brackets."""
    return f"[{host}]" if ":" in host else host


def _is_remote(host: str) -> bool:
    """Return whether other machines can reach a host. Raises InputError for a host that pages cannot open."""
    if host in LOOPBACK:
        return False
    try:
        address = ipaddress.ip_address(host or "0.0.0.0")
    except ValueError:
        return True
    if address.is_unspecified:
        raise InputError(
            f"‹host=›{host or repr(host)}: means every address of this machine. Give the one "
            "that the other device opens."
        )
    return not address.is_loopback


def _open_socket(host: str, port: int) -> socket.socket:
    """Return a socket that listens at a host and port. Raises InputError."""
    listening = socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET)
    # Windows lets two programs share a port, unless SO_EXCLUSIVEADDRUSE forbids it. Elsewhere SO_REUSEADDR allows a
    # port whose last connections are still closing
    alone = getattr(socket, "SO_EXCLUSIVEADDRUSE", None)
    try:
        listening.setsockopt(socket.SOL_SOCKET, alone or socket.SO_REUSEADDR, 1)
        listening.bind((host, port))
        listening.listen()  # a browser that is faster than the server waits
    except (OSError, UnicodeError) as error:
        listening.close()
        reason = getattr(error, "strerror", None) or "is no address"
        if getattr(error, "errno", None) in (errno.EADDRINUSE, errno.EACCES):
            advice = f"‹port=›{port}: {reason}: choose another port, or 0 for a free one"
        else:
            advice = f"‹host=›{host[:80]}: {reason}: give an address of this machine, or leave it out"
        raise InputError(advice) from None
    return listening
