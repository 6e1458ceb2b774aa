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
"""Tasks of one server that have a child."""


class Server(NamedTuple):
    """State of a server at its start."""

    folder: Path
    """Folder for all its output."""
    hosts: frozenset[str]
    """Hosts, with ports, that its pages may use as its address."""
    secret: str
    """Path of its endpoints."""
    page_files: PageFiles
    first: Document
    """Document of the command line, which a page starts with."""
    running: Running
    steps: Workers
    """Separate processes for walkers, so that the steps of a slider never wait."""
    workers: Workers
    """Processes for all other slow work."""
    replaces_saved: bool = False
    """True if the command line names a document, which replaces the saved one."""
    once: str | None = None
    """Secret in the address that opens the page once, for a phone; None for this machine alone."""


def make_server(
    folder: Path, hosts: frozenset[str], first: Document, own: str | None, remote: bool, replaces_saved: bool = False
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
    own
        File of this document's walker; None for a template.
    remote
        True if other machines can reach the server.
    replaces_saved
        True if `first` replaces the saved document.
    """
    place = PageFiles(folder / "uploads", own)
    once = secrets.token_urlsafe(9) if remote else None
    return Server(
        folder, hosts, secrets.token_urlsafe(18), place, first, set(), Workers(), Workers(), replaces_saved, once
    )
