"""What a server knows from its start, before it has loaded what answers its pages."""

import asyncio
import secrets
from pathlib import Path
from typing import Any, NamedTuple

from walkergen.app.document import Document, PageFiles
from walkergen.app.workers import Workers

START_VALUES = {"scene.run.seconds": 10.0, "scene.run.runs": 8}
"""Values of a new document: a run that is done within seconds."""

Running = set[asyncio.Future[Any]]
"""Tasks that have a child, of one server."""


class Server(NamedTuple):
    """What a server knows from its start."""

    folder: Path
    """Folder of all that it writes."""
    hosts: frozenset[str]
    """Hosts, with ports, by which its pages call it."""
    secret: str
    """Path below which its doors stand."""
    place: PageFiles
    first: Document
    """Document of the command line, with which a page begins."""
    running: Running
    steps: Workers
    """Processes of walkers alone, so that a slider's step waits for nothing else."""
    workers: Workers
    """Processes of all else that takes its time."""
    anew: bool = False
    """True where the command line says what a page is about: what was kept of others is not it."""
    once: str | None = None
    """Word in the address that opens the page once, for a phone; None for this machine alone."""


def make_server(
    folder: Path, hosts: frozenset[str], first: Document, own: str | None, away: bool, anew: bool = False
) -> Server:
    """Server with fresh secrets; `away` if other machines can reach it."""
    place = PageFiles(folder / "uploads", own)
    once = secrets.token_urlsafe(9) if away else None
    return Server(folder, hosts, secrets.token_urlsafe(18), place, first, set(), Workers(), Workers(), anew, once)
