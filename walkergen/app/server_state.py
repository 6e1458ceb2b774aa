"""State of a server at its start, before it has loaded the modules that answer its pages."""

import asyncio
import secrets
from pathlib import Path
from typing import Any, NamedTuple

from walkergen.app.document import Document, PageFiles
from walkergen.app.workers import Workers

START_VALUES = {"scene.run.seconds": 10.0, "scene.run.runs": 8}
"""Values of a new document: a run that finishes within seconds."""

Running = set[asyncio.Future[Any]]
"""Tasks of one server that run a child process."""


class Server(NamedTuple):
    """State of a server at its start."""

    folder: Path
    """Folder for all output of the server."""
    hosts: frozenset[str]
    """Hosts, with ports, in the addresses that its pages may use."""
    secret: str
    """Secret path under which all endpoints are."""
    page_files: PageFiles
    first: Document
    """Document of the command line, with which a page starts."""
    running: Running
    steps: Workers
    """Processes that only build walkers, so that a moving slider never waits for other work."""
    workers: Workers
    """Processes for all other slow work."""
    replaces_saved: bool = False
    """True if the command line names a document, which replaces the saved one."""
    once: str | None = None
    """Secret in an address that opens the page once, for another device; None if only this machine has access."""


def make_server(
    folder: Path, hosts: frozenset[str], first: Document, walker_file: str | None, remote: bool, replaces_saved: bool
) -> Server:
    """Return the state of a new server with new secrets.

    Parameters
    ----------
    folder
        Folder for all output.
    hosts
        Hosts, with ports, that pages may use as the server's address.
    first
        Document that pages start with.
    walker_file
        File of the walker in this document; None for a template.
    remote
        True if other machines can reach the server.
    replaces_saved
        True if `first` replaces the saved document.
    """
    files = PageFiles(folder / "uploads", walker_file)
    once = secrets.token_urlsafe(9) if remote else None
    return Server(
        folder, hosts, secrets.token_urlsafe(18), files, first, set(), Workers(), Workers(), replaces_saved, once
    )
