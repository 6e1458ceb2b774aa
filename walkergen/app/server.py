"""Server of the page on which walkers are designed: a door for each thing that the page asks.

Doors stand below a path that nobody can guess, and open only to pages of this server: a page of
elsewhere names another Host or Origin. No path of a file comes from a page.
"""

import asyncio
import hashlib
import json
import secrets
from collections.abc import AsyncIterator, Awaitable, Callable, Sequence
from pathlib import Path
from typing import Any, TypeVar

from starlette.applications import Starlette
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect, Request
from starlette.responses import HTMLResponse, RedirectResponse, Response
from starlette.routing import Mount, Route

from walkergen.app import (
    answers,
    children,
    crowding,
    curves,
    effects,
    form,
    pictures,
    sentences,
    spans,
    statics,
    taking,
)
from walkergen.app import document as documents
from walkergen.app.document import Document
from walkergen.app.served import START, Server
from walkergen.app.workers import Workers
from walkergen.core.errors import InputError, WalkergenError
from walkergen.core.files import output, reading
from walkergen.core.files.ledger import manifest
from walkergen.files import templates
from walkergen.request import TABLE

MOST_BYTES = 1_000_000
"""Longest message of a page, bytes, as of a TOML file."""

MOST_UPLOADED = 200_000_000
"""Largest file that may be dropped onto a page, bytes."""

MOST_HEARD = 5 * MOST_UPLOADED
"""Bytes of a message after which it is broken off, whoever sends it."""

MOST_UPLOADS = 2 * MOST_UPLOADED
"""Sum of all files that were dropped and are kept, bytes: the oldest go."""

SILENT_S = 20.0
"""Time after which a message that has not ended, and goes on no more, is given up, s."""

KEPT = "kept.json"
"""File in the server's folder with the document that was changed last."""

MOST_KEPT = 50 * MOST_BYTES
"""Largest such file, bytes: a message with a line for each number in it."""

POLICY = (
    "default-src 'none'; connect-src 'self'; script-src 'self'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data:; frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
)
Result = TypeVar("Result")


Door = Callable[[Server, Request], Awaitable[Response]]
Asked = dict[str, Any]
Given = Callable[[Server, Asked], Any]


def application(server: Server) -> Any:
    """ASGI application of a server."""
    doors: dict[str, Door] = {
        "start": _start,
        "walker": _walker,
        "outlook": _answer(answers.outlook),
        "curve": _answer(curves.answer, _rough),
        "shares": _answer(answers.shares, key="shares"),
        "trouble": _answer(answers.trouble),
        "form": _answer(form.whole),
        "spans": _answer(spans.spans, _keys, key="spans"),
        "keep": _keep,
        "run": _run,
        "crowd": _command(crowding.words, _folder("crowds")),
        "crowded": _answer(crowding.played, _folder("crowds")),
        "effects": _command(effects.words, _folder("effects")),
        "effects_drawn": _answer(effects.picture, _folder("effects")),
        "nearest": _command(taking.search, _speed, _folder("sweep")),
        "make": _make,
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


LOST = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>walkergen: the address is not whole</title>
<style>body { font: 18px/1.5 system-ui, sans-serif; max-width: 34rem; margin: 3rem auto; padding: 0 1rem;
color: #22282d; background: #fff; } code { overflow-wrap: anywhere; }
@media (prefers-color-scheme: dark) { body { color: #e4e8ec; background: #15191d; } }</style></head>
<body><main><h1>Almost there</h1>
<p>walkergen runs here, but this address is not whole: it ends in a long secret word, so that no other page
can reach your designs.</p>
<p>Go to the terminal in which you started walkergen. It shows a line <code>the page: http://…</code>: open that
address, to its last letter. Or end it there with Ctrl-C and start it again: it opens the page itself.</p>
</main></body></html>
"""
"""Page of an address that leads nowhere."""


def _no_door(request: Request, error: HTTPException) -> Response:
    """Refusal of what is asked of no door, or not as doors are asked; a person reads a page."""
    if request.method == "GET" and "text/html" in request.headers.get("accept", ""):
        return HTMLResponse(LOST, error.status_code)
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


def _door(server: Server, door: Door) -> Any:
    """Endpoint that refuses in words what a job refuses."""

    async def endpoint(request: Request) -> Response:
        try:
            return await door(server, request)
        except WalkergenError as error:
            return _json({"refused": answers.refusal(error)}, 422)
        except (MemoryError, RecursionError):
            return _refused(["too large for this machine: ask for less"], 422)
        except TimeoutError:
            return _refused(["the message did not come to its end"], 408)
        except ClientDisconnect:  # nobody reads this
            return Response(status_code=204)

    return endpoint


async def _body(request: Request, most: int = MOST_BYTES) -> bytes:
    """Message of a page. Raises InputError for one that is too long."""
    data, length = bytearray(), 0
    stream = request.stream()
    while True:  # to its end: who still sends hears no refusal
        try:
            piece = await asyncio.wait_for(anext(stream), SILENT_S)
        except StopAsyncIteration:
            break
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
    """Return what a page needs once: the files to start from, and the stored document."""
    names = {kind: templates.names(kind) for kind in templates.KINDS}
    listed = [row for row in templates.listing().facts["rows"] if row["kind"] == "walkers"]
    about = {row["name"]: row["description"] for row in listed}
    kept = await asyncio.to_thread(_kept, server)
    return _json(
        {
            **names,
            "walkers": server.place.walkers(),
            "about": about,
            "titles": sentences.TITLES,
            "table": TABLE,
            "new": kept is None and not server.anew,
            "document": kept or server.first._asdict(),
            "fresh": server.first._asdict(),
        }
    )


def _kept(server: Server) -> Any:
    """Load the stored document; None without one, if its files are gone, or if the command line names another."""
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
    await asyncio.to_thread(output.renew, server.folder / KEPT, kept)
    return _json({})


async def _walker(server: Server, request: Request) -> Response:
    """Facts on the walker and its triangles: a line of JSON, then little-endian numbers."""
    document, _ = await _asked(server, request)
    packed = await _worked(server.steps, request, answers.packed, document)
    return Response(packed, media_type="application/octet-stream")


def _rough(server: Server, asked: Asked) -> bool:
    """Whether a few points do, as while a slider moves."""
    return asked.get("rough") is True


def _keys(server: Server, asked: Asked) -> list[str]:
    """Keys of the sliders whose ranges are asked for. Raises InputError."""
    keys = asked.get("keys")
    if not isinstance(keys, list) or not all(isinstance(key, str) for key in keys):
        raise InputError(f"{documents.SOURCE}: keys: must be a list of keys")
    return keys


def _speed(server: Server, asked: Asked) -> Any:
    """Wished speed, as the page sent it."""
    return asked.get("speed")


def _folder(name: str) -> Given:
    """Folder of this name, in which a command leaves what it makes."""
    return lambda server, asked: server.folder / name


async def _answered(work: Callable[..., Result], given: Sequence[Given], server: Server, request: Request) -> Result:
    """Run work on a page's walker and the further arguments from `given`, and return its result."""
    document, asked = await _asked(server, request)
    return await _worked(server.workers, request, work, document, *(one(server, asked) for one in given))


def _answer(work: Callable[..., Any], *given: Given, key: str = "") -> Door:
    """Door that answers by work on a page's walker; with a key in a table of this one."""

    async def door(server: Server, request: Request) -> Response:
        result = await _answered(work, given, server, request)
        return _json({key: result} if key else result)

    return door


def _command(words: Callable[..., list[str]], *given: Given) -> Door:
    """Door that runs a command of a page's walker."""

    async def door(server: Server, request: Request) -> Response:
        command = await _answered(words, given, server, request)
        return Streamed(children.run(server.running, children.COMMANDS, [command]))

    return door


async def _worked(workers: Workers, request: Request, work: Callable[..., Result], *given: Any) -> Result:
    """Run slow work in a process and return its result. Raises ClientDisconnect if the page has gone meanwhile."""
    result = await children.while_heard(request.receive, workers.answer(work, *given))
    if result is None:
        raise ClientDisconnect
    return result


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
    """Simulate the walker; if `short` only for a first number."""
    document, asked = await _asked(server, request)
    sent = {"document": document._asdict(), "short": asked.get("short") is True}
    return Streamed(children.run(server.running, children.RUN, sent))


async def _ordered(server: Server, request: Request) -> taking.Order:
    document, asked = await _asked(server, request)
    what, copies = asked.get("what"), asked.get("copies", 1)
    return await _worked(server.workers, request, taking.order, document, what, copies, server.folder)


async def _make(server: Server, request: Request) -> Response:
    """Make files by their commands, for `take` to hand out."""
    order = await _ordered(server, request)
    if not order.commands:
        return Response(b"", media_type=Streamed.media_type)
    return Streamed(children.run(server.running, children.COMMANDS, order.commands))


async def _take(server: Server, request: Request) -> Response:
    """Hand out files that were made."""
    order = await _ordered(server, request)
    name, data = await _worked(server.workers, request, taking.collected, order)
    shells = [documents.shell(words) for words in order.commands]
    headers = {"content-disposition": f'attachment; filename="{name}"', "walkergen-shell": json.dumps(shells)}
    return Response(data, media_type="application/octet-stream", headers=headers)


async def _upload(server: Server, request: Request) -> Response:
    """Keep a file that was dropped onto the page, under a name of ours."""
    kind = request.query_params.get("kind", "").lower()
    data = await _body(request, MOST_UPLOADED)
    if kind not in documents.DROPPED:
        raise InputError(
            f"{documents.SOURCE}: files of the kind {kind[:20]!r} are no bodies: drop an SVG or DXF drawing, "
            "a picture (PNG, JPG), or a mesh (STL, OBJ, PLY, OFF, 3MF, GLB)"
        )
    name = await asyncio.to_thread(_uploaded, server.place.uploads, kind, data)
    return _json({"file": name, "key": "body.outline" if kind in documents.DRAWINGS else "body.mesh"})


def _uploaded(folder: Path, kind: str, data: bytes) -> str:
    """Name of a file that was dropped, once it is written. Raises OutputError."""
    name = f"{hashlib.sha256(data).hexdigest()[:16]}.{kind}"
    with output.Folder(folder, "") as target:
        target.write(name, data)
    (folder / name).touch()
    kept = 0
    for path in sorted(folder.glob("*.*"), key=lambda path: path.stat().st_mtime, reverse=True):
        kept += path.stat().st_size
        if kept > MOST_UPLOADS and documents.UPLOADED.fullmatch(path.name) and path.name != name:
            path.unlink()
    return name


async def _picture(server: Server, request: Request) -> Response:
    """Side view of a template's walker, to start from."""
    name = request.path_params["name"]
    if name not in templates.names("walkers"):
        return _refused(["no such picture"], 404)
    text = await asyncio.to_thread(pictures.side_view, name)
    return Response(text, media_type="image/svg+xml")
