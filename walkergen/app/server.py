"""Server of the page on which walkers are designed: a door for each thing that the page asks.

Doors stand below a path that nobody can guess, and open only to pages of this server: a page of
elsewhere names another Host or Origin. No path of a file comes from a page.
"""

import asyncio
import hashlib
import json
import secrets
from collections.abc import AsyncIterator, Awaitable, Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from starlette.applications import Starlette
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect, Request
from starlette.responses import RedirectResponse, Response
from starlette.routing import Mount, Route

from walkergen.app import answers, children, form, pictures, statics, taking
from walkergen.app import document as documents
from walkergen.app.document import Document, Place
from walkergen.errors import InputError, WalkergenError
from walkergen.files import output, reading, templates
from walkergen.files.ledger import manifest

MOST_BYTES = 1_000_000
"""Longest message of a page, bytes, as of a TOML file."""

MOST_UPLOADED = 200_000_000
"""Largest file that may be dropped onto a page, bytes."""

MOST_HEARD = 5 * MOST_UPLOADED
"""Bytes of a message after which it is broken off, whoever sends it."""

THREADS = 2
"""Answers that are made at once: more would share the same core, and all be late."""

KEPT = "kept.json"
"""File in the server's folder with the document that was changed last."""

MOST_KEPT = 50 * MOST_BYTES
"""Largest such file, bytes: a message with a line for each number in it."""

START = {"scene.run.seconds": 10.0, "scene.run.runs": 8}
"""Values of a new document: a run that is done within seconds."""

POLICY = (
    "default-src 'none'; connect-src 'self'; script-src 'self'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data:; frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
)
Result = TypeVar("Result")


class Server(NamedTuple):
    """What a server knows from its start."""

    folder: Path
    """Folder of all that it writes."""
    hosts: frozenset[str]
    """Hosts, with ports, by which its pages call it."""
    secret: str
    """Path below which its doors stand."""
    place: Place
    first: Document
    """Document of the command line, with which a page begins."""
    running: children.Running
    """What has a child."""
    threads: ThreadPoolExecutor
    """Threads of all else that takes its time."""
    anew: bool = False
    """True where the command line says what a page is about: what was kept of others is not it."""
    once: str | None = None
    """Word in the address that opens the page once, for a phone; None for this machine alone."""


def new(
    folder: Path, hosts: frozenset[str], first: Document, own: str | None, away: bool, anew: bool = False
) -> Server:
    """Server with fresh secrets; `away` if other machines can reach it."""
    place = Place(folder / "uploads", own)
    once = secrets.token_urlsafe(9) if away else None
    return Server(
        folder, hosts, secrets.token_urlsafe(18), place, first, set(), ThreadPoolExecutor(THREADS), anew, once
    )


def application(server: Server) -> Any:
    """ASGI application of a server."""
    doors: dict[str, Callable[[Server, Request], Awaitable[Response]]] = {
        "start": _start,
        "walker": _walker,
        "outlook": _outlook,
        "form": _form,
        "keep": _keep,
        "run": _run,
        "play": _play,
        "design": _design,
        "take": _take,
        "upload": _upload,
    }
    inner: list[Any] = [
        *(Route(f"/{name}", _door(server, door), methods=["POST"]) for name, door in doors.items()),
        Route("/picture/{name}.svg", _door(server, _picture)),
        *statics.routes(),
    ]
    word = (server.once or "").encode()
    used: list[bytes] = []

    def once(request: Request) -> Response:
        if used or not secrets.compare_digest(request.path_params["word"].encode(), word):
            return _refused(["this address has been used: start walkergen app again"], 410)
        used.append(word)
        return RedirectResponse(f"/{server.secret}/", 303)

    outer: list[Any] = [Mount(f"/{server.secret}", routes=inner)]
    if server.once:
        outer.append(Route("/once/{word}", once))
    handlers: Any = {HTTPException: _no_door, Exception: _mistake}
    return _guarded(Starlette(routes=outer, exception_handlers=handlers), server.hosts)


def _no_door(_: Request, error: HTTPException) -> Response:
    """Refusal of what is asked of no door, or not as doors are asked."""
    return _refused([f"this server has no such door: {error.detail}"], error.status_code)


def _mistake(_: Request, error: Exception) -> Response:
    """Answer where walkergen has a mistake, which the terminal then shows."""
    return _refused(["a mistake of walkergen: its terminal shows more; please report it"], 500)


def _guarded(app: Any, hosts: frozenset[str]) -> Any:
    """Application that answers only pages of its own, by its own name."""

    async def guarded(scope: Any, receive: Any, send: Any) -> None:
        if scope["type"] != "http":
            await app(scope, receive, send)
            return
        headers = dict(scope["headers"])
        host = headers.get(b"host", b"").decode("latin-1")
        origin = headers.get(b"origin")
        if host not in hosts or origin not in (None, f"http://{host}".encode("latin-1")):
            await _refused(["this server answers its own pages alone"], 403)(scope, receive, send)
            return

        async def safely(message: Any) -> None:
            if message["type"] == "http.response.start":
                message["headers"] = [
                    *message["headers"],
                    (b"content-security-policy", POLICY.encode()),
                    (b"referrer-policy", b"no-referrer"),
                    (b"x-content-type-options", b"nosniff"),
                    (b"cache-control", b"no-store"),
                    (b"cross-origin-resource-policy", b"same-origin"),
                ]
            await send(message)

        await app(scope, receive, safely)

    return guarded


def _door(server: Server, door: Callable[[Server, Request], Awaitable[Response]]) -> Any:
    """Endpoint that refuses in words what a job refuses."""

    async def endpoint(request: Request) -> Response:
        try:
            return await door(server, request)
        except WalkergenError as error:
            return _json({"refused": answers.refusal(error)}, 422)
        except (MemoryError, RecursionError):
            return _refused(["too large for this machine: ask for less"], 422)
        except ClientDisconnect:  # nobody reads this
            return Response(status_code=400)

    return endpoint


async def _body(request: Request, most: int = MOST_BYTES) -> bytes:
    """Message of a page. Raises InputError for one that is too long."""
    data, length = bytearray(), 0
    async for piece in request.stream():  # to its end: who still sends hears no refusal
        length += len(piece)
        if length <= most:
            data += piece
        elif length > MOST_HEARD:
            break
    if length > most:
        raise InputError(f"{documents.SOURCE}: more than {most / 1e6:g} MB")
    return bytes(data)


async def _asked(server: Server, request: Request) -> tuple[Document, dict[str, Any]]:
    """Document of a request, and what else it says. Raises InputError."""
    message = documents.json_of(await _body(request))
    return documents.read(message.pop("document", None), server.place), message


def _json(data: Any, status: int = 200) -> Response:
    text = json.dumps(data, allow_nan=False, ensure_ascii=False)
    return Response(text.encode(errors="replace"), status, media_type="application/json")


def _refused(lines: list[str], status: int) -> Response:
    return _json({"refused": [{"key": "", "text": line} for line in lines]}, status)


async def _start(server: Server, request: Request) -> Response:
    """What a page needs once: the files to start from, and the document that was kept."""
    names = {kind: templates.names(kind) for kind in templates.KINDS}
    listed = [row for row in templates.listing().facts["rows"] if row["kind"] == "walkers"]
    about = {row["name"]: row["description"] for row in listed}
    kept = await _worked(server, _kept, server)
    return _json(
        {
            **names,
            "walkers": server.place.walkers(),
            "about": about,
            "document": kept or server.first._asdict(),
            "fresh": server.first._asdict(),
        }
    )


def _kept(server: Server) -> Any:
    """Document that was kept; None for none, where its files are gone, and for another one than
    that of the command line.
    """
    try:
        data = reading.content(server.folder / KEPT, MOST_KEPT, "a JSON file")
        kept = documents.json_of(data).get("document")
        document = documents.read(kept, server.place)
    except WalkergenError:
        return None
    same = document[:3] == server.first[:3] and server.first.values == START
    return kept if same or not server.anew else None


async def _keep(server: Server, request: Request) -> Response:
    """Keep a document, as the page sent it, for the next start."""
    document = documents.json_of(await _body(request)).get("document")
    documents.read(document, server.place)
    kept = manifest({"document": document})
    await _worked(server, output.renew, server.folder / KEPT, kept)
    return _json({})


async def _walker(server: Server, request: Request) -> Response:
    """Facts on the walker and its triangles: a line of JSON, then little-endian numbers."""
    document, _ = await _asked(server, request)

    def answer() -> bytes:
        facts, mesh = answers.walker(document)
        corners, legs = answers.triangles(mesh), answers.of_legs(document, mesh)
        head = json.dumps(facts | {"triangles": len(corners)}, allow_nan=False).encode()
        head += b" " * (-(len(head) + 1) % 4) + b"\n"  # numbers begin at a multiple of 4 bytes
        return head + corners.tobytes() + legs.tobytes()

    return Response(await _worked(server, answer), media_type="application/octet-stream")


async def _outlook(server: Server, request: Request) -> Response:
    document, _ = await _asked(server, request)
    return _json(await _worked(server, answers.outlook, document))


async def _form(server: Server, request: Request) -> Response:
    document, _ = await _asked(server, request)

    def answer() -> dict[str, Any]:
        groups = [
            {"title": group.title, "controls": [control._asdict() for control in group.controls]}
            for group in form.groups(document)
        ]
        return {"groups": groups, "legs": form.listed_legs(document), "shapes": form.shapes(document)}

    return _json(await _worked(server, answer))


async def _worked(server: Server, work: Callable[..., Result], *given: Any) -> Result:
    """Result of what takes its time, beside which the server listens on."""
    return await asyncio.get_running_loop().run_in_executor(server.threads, work, *given)


class Streamed(Response):
    """Events as lines of JSON; a page that goes away ends what makes them."""

    media_type = "application/x-ndjson"

    def __init__(self, events: AsyncIterator[children.Event]) -> None:
        super().__init__()
        del self.headers["content-length"]
        self._events = events

    async def __call__(self, scope: Any, receive: Any, send: Any) -> None:
        """Send the events as they come."""
        await send({"type": "http.response.start", "status": 200, "headers": self.raw_headers})

        async def lines() -> None:
            async for event in self._events:
                line = json.dumps(event).encode() + b"\n"
                await send({"type": "http.response.body", "body": line, "more_body": True})

        await children.while_heard(receive, lines())
        await send({"type": "http.response.body", "body": b""})


async def _run(server: Server, request: Request) -> Response:
    document, _ = await _asked(server, request)
    words = await _worked(server, documents.arguments, document, "simulate", "--json")
    return Streamed(children.run(server.running, children.COMMAND, words, None))


async def _play(server: Server, request: Request) -> Response:
    document, _ = await _asked(server, request)
    return Streamed(children.run(server.running, children.PLAY, (), document._asdict()))


async def _design(server: Server, request: Request) -> Response:
    """Search for a walker of a wished speed, as `walkergen design` does."""
    document, wish = await _asked(server, request)
    words = await _worked(server, taking.search, document, wish, server.folder / "designs")
    return Streamed(children.run(server.running, children.COMMAND, words, None))


async def _take(server: Server, request: Request) -> Response:
    """Make files by their commands, and hand them out."""
    document, asked = await _asked(server, request)
    what, copies = asked.get("what"), asked.get("copies", 1)
    order = await _worked(server, taking.order, document, what, copies, server.folder)
    made = await children.while_heard(request.receive, _made(server, order))
    return made or _refused(["the server has ended"], 503)


async def _made(server: Server, order: taking.Order) -> Response:
    for words in order.commands:
        refused = None
        async for event in children.run(server.running, children.COMMAND, words, None):
            refused = event.get("refused", refused)
        if refused:
            return _refused(refused, 422)
    name, data = await _worked(server, taking.collected, order)
    shells = [documents.shell(words) for words in order.commands]
    headers = {"content-disposition": f'attachment; filename="{name}"', "walkergen-shell": json.dumps(shells)}
    return Response(data, media_type="application/octet-stream", headers=headers)


async def _upload(server: Server, request: Request) -> Response:
    """Keep a file that was dropped onto the page, under a name of ours."""
    kind = request.query_params.get("kind", "").lower()
    data = await _body(request, MOST_UPLOADED)
    if kind not in documents.DROPPED:
        raise InputError(
            f"{documents.SOURCE}: files of the kind {kind[:20]!r} are no bodies: drop an SVG or "
            "DXF drawing, or a mesh (STL, OBJ, PLY, OFF, 3MF, GLB)"
        )
    name = await _worked(server, _uploaded, server.place.uploads, kind, data)
    return _json({"file": name, "key": "body.outline" if kind in ("svg", "dxf") else "body.mesh"})


def _uploaded(folder: Path, kind: str, data: bytes) -> str:
    """Name of a file that was dropped, once it is written. Raises OutputError."""
    name = f"{hashlib.sha256(data).hexdigest()[:16]}.{kind}"
    with output.Folder(folder, "") as target:
        target.write(name, data)
    return name


async def _picture(server: Server, request: Request) -> Response:
    """Side view of a template's walker, to start from."""
    name = request.path_params["name"]
    if name not in templates.names("walkers"):
        return _refused(["no such picture"], 404)
    text = await _worked(server, pictures.side_view, name)
    return Response(text, media_type="image/svg+xml")
