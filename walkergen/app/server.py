"""Server of the page on which walkers are designed, with one endpoint for each request of the page.

Endpoints are below a secret path, and answer only pages of this server. Pages from
elsewhere have another Host or Origin. No file path comes from a page.
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
    child_processes,
    crowd_playback,
    curves,
    downloads,
    effects,
    form,
    sentences,
    slider_ranges,
    static_files,
    template_pictures,
    walker_answers,
)
from walkergen.app import document as documents
from walkergen.app.document import Document
from walkergen.app.server_state import START_VALUES, Server
from walkergen.app.workers import Workers
from walkergen.core.errors import InputError, WalkergenError
from walkergen.core.files import file_reading, output
from walkergen.core.files.ledger import encode_manifest
from walkergen.files import templates
from walkergen.request import TABLE_SCENE

MAX_MESSAGE_BYTES = 1_000_000
"""Longest message of a page, bytes, equal to that of a TOML file."""

MAX_UPLOAD_BYTES = 200_000_000
"""Largest file that may be dropped onto a page, bytes."""

MAX_RECEIVED_BYTES = 5 * MAX_UPLOAD_BYTES
"""Bytes of a message after which the connection is closed, for any sender."""

MAX_UPLOAD_FOLDER_BYTES = 2 * MAX_UPLOAD_BYTES
"""Total size of all stored dropped files, bytes; the oldest are deleted first."""

RECEIVE_TIMEOUT_S = 20.0
"""Time after which a stalled message is abandoned, s."""

SAVED_DOCUMENT = "kept.json"
"""File in the server's folder with the last changed document."""

MAX_SAVED_BYTES = 50 * MAX_MESSAGE_BYTES
"""Largest saved document, bytes: a message with a line for each number in it."""

CONTENT_POLICY = (
    "default-src 'none'; connect-src 'self'; script-src 'self'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data:; frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
)
Result = TypeVar("Result")


Endpoint = Callable[[Server, Request], Awaitable[Response]]
MessageFields = dict[str, Any]
WorkArgument = Callable[[Server, MessageFields], Any]


def application(server: Server) -> Any:
    """Make the ASGI application of a server."""
    doors: dict[str, Endpoint] = {
        "start": _send_start_data,
        "walker": _send_walker,
        "outlook": _answer_endpoint(walker_answers.printing_outlook),
        "curve": _answer_endpoint(curves.speed_curve_table, _is_rough),
        "shares": _answer_endpoint(walker_answers.variance_shares, key="shares"),
        "trouble": _answer_endpoint(walker_answers.trouble_picture),
        "form": _answer_endpoint(form.to_dict),
        "spans": _answer_endpoint(slider_ranges.slider_ranges, _slider_keys, key="spans"),
        "keep": _save_document,
        "run": _run_simulation,
        "crowd": _command_endpoint(crowd_playback.crowd_arguments, _output_folder("crowds")),
        "crowded": _answer_endpoint(crowd_playback.read_playback, _output_folder("crowds")),
        "effects": _command_endpoint(effects.explain_arguments, _output_folder("effects")),
        "effects_drawn": _answer_endpoint(effects.read_picture, _output_folder("effects")),
        "nearest": _command_endpoint(downloads.sweep_arguments, _target_speed, _output_folder("sweep")),
        "make": _make_files,
        "take": _send_files,
        "upload": _receive_upload,
    }
    inner: list[Any] = [
        *(Route(f"/{name}", _handle_refusals(server, door), methods=["POST"]) for name, door in doors.items()),
        Route("/picture/{name}.svg", _handle_refusals(server, _send_picture)),
        *static_files.routes(),
    ]
    word = (server.once or "").encode()
    used: list[bytes] = []

    def once(request: Request) -> Response:
        if used or not secrets.compare_digest(request.path_params["word"].encode(), word):
            return _error_response(["this address has been used: start walkergen app again"], 410)
        used.append(word)
        return RedirectResponse(f"/{server.secret}/", 303)

    outer: list[Any] = [Mount(f"/{server.secret}", routes=inner)]
    if server.once:
        outer.append(Route("/once/{word}", once))
    handlers: Any = {HTTPException: _handle_http_error, Exception: _handle_internal_error}
    return _restrict_hosts(Starlette(routes=outer, exception_handlers=handlers), server.hosts)


BAD_ADDRESS_PAGE = """<!DOCTYPE html>
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
"""Page for unknown addresses."""


def _handle_http_error(request: Request, error: HTTPException) -> Response:
    """Return the refusal of an unknown address or an invalid request. A browser shows a page."""
    if request.method == "GET" and "text/html" in request.headers.get("accept", ""):
        return HTMLResponse(BAD_ADDRESS_PAGE, error.status_code)
    return _error_response([f"this server has no such door: {error.detail}"], error.status_code)


def _handle_internal_error(_: Request, error: Exception) -> Response:
    """Return the answer to an internal error; the terminal shows the error."""
    return _error_response(["a mistake of walkergen: its terminal shows more; please report it"], 500)


def _restrict_hosts(app: Any, hosts: frozenset[str]) -> Any:
    """Return an application that answers only requests from its own pages, under its own name."""

    async def handle_request(scope: Any, receive: Any, send: Any) -> None:
        if scope["type"] != "http":
            await app(scope, receive, send)
            return
        headers = dict(scope["headers"])
        host = headers.get(b"host", b"").decode("latin-1")
        origin = headers.get(b"origin")
        if host not in hosts or origin not in (None, f"http://{host}".encode("latin-1")):
            await _error_response(["this server answers its own pages alone"], 403)(scope, receive, send)
            return

        async def send_with_headers(message: Any) -> None:
            if message["type"] == "http.response.start":
                message["headers"] = [
                    *message["headers"],
                    (b"content-security-policy", CONTENT_POLICY.encode()),
                    (b"referrer-policy", b"no-referrer"),
                    (b"x-content-type-options", b"nosniff"),
                    (b"cache-control", b"no-store"),
                    (b"cross-origin-resource-policy", b"same-origin"),
                ]
            await send(message)

        await app(scope, receive, send_with_headers)

    return handle_request


def _handle_refusals(server: Server, door: Endpoint) -> Any:
    """Return an endpoint that reports the refusals of a job in words."""

    async def endpoint(request: Request) -> Response:
        try:
            return await door(server, request)
        except WalkergenError as error:
            return _json_response({"refused": walker_answers.format_refusal(error)}, 422)
        except (MemoryError, RecursionError):
            return _error_response(["too large for this machine: ask for less"], 422)
        except TimeoutError:
            return _error_response(["the message did not come to its end"], 408)
        except ClientDisconnect:  # the client has gone
            return Response(status_code=204)

    return endpoint


async def _read_body(request: Request, most: int = MAX_MESSAGE_BYTES) -> bytes:
    """Read the message of a page. Raises InputError if it is too long."""
    data, length = bytearray(), 0
    stream = request.stream()
    while True:  # to its end: a client that still sends cannot receive the refusal
        try:
            piece = await asyncio.wait_for(anext(stream), RECEIVE_TIMEOUT_S)
        except StopAsyncIteration:
            break
        length += len(piece)
        if length <= most:
            data += piece
        elif length > MAX_RECEIVED_BYTES:
            break
    if length > most:
        raise InputError(f"{documents.SOURCE}: more than {most / 1e6:g} MB")
    return bytes(data)


async def _read_request(server: Server, request: Request) -> tuple[Document, dict[str, Any]]:
    """Return the document of a request, and its other fields. Raises InputError."""
    message = documents.parse_message(await _read_body(request))
    return documents.from_message(message.pop("document", None), server.place), message


def _json_response(data: Any, status: int = 200) -> Response:
    text = json.dumps(data, allow_nan=False, ensure_ascii=False)
    return Response(text.encode(errors="replace"), status, media_type="application/json")


def _error_response(lines: list[str], status: int) -> Response:
    return _json_response({"refused": [{"key": "", "text": line} for line in lines]}, status)


async def _send_start_data(server: Server, request: Request) -> Response:
    """Return what a page needs once: the files to start from, and the stored document."""
    names = {kind: templates.names(kind) for kind in templates.KINDS}
    listed = [row for row in templates.list_templates().facts["rows"] if row["kind"] == "walkers"]
    about = {row["name"]: row["description"] for row in listed}
    kept = await asyncio.to_thread(_load_saved, server)
    return _json_response(
        {
            **names,
            "walkers": server.place.walkers(),
            "about": about,
            "titles": sentences.TITLES,
            "table": TABLE_SCENE,
            "new": kept is None and not server.anew,
            "document": kept or server.first._asdict(),
            "fresh": server.first._asdict(),
        }
    )


def _load_saved(server: Server) -> Any:
    """Load the stored document; None without one, if its files are gone, or if the command line names another."""
    try:
        data = file_reading.read_bytes(server.folder / SAVED_DOCUMENT, MAX_SAVED_BYTES, "a JSON file")
        kept = documents.parse_message(data).get("document")
        document = documents.from_message(kept, server.place)
    except WalkergenError:
        return None
    same = document[:3] == server.first[:3] and server.first.values == START_VALUES
    return kept if same or not server.anew else None


async def _save_document(server: Server, request: Request) -> Response:
    """Save a document, as the page sent it, for the next start."""
    document = documents.parse_message(await _read_body(request)).get("document")
    documents.from_message(document, server.place)
    kept = encode_manifest({"document": document})
    await asyncio.to_thread(output.rewrite_sealed, server.folder / SAVED_DOCUMENT, kept)
    return _json_response({})


async def _send_walker(server: Server, request: Request) -> Response:
    """Send facts on the walker and its triangles: a line of JSON, then little-endian numbers."""
    document, _ = await _read_request(server, request)
    packed = await _await_work(server.steps, request, walker_answers.pack_walker, document)
    return Response(packed, media_type="application/octet-stream")


def _is_rough(server: Server, asked: MessageFields) -> bool:
    """Return whether a few points suffice, as while a slider moves."""
    return asked.get("rough") is True


def _slider_keys(server: Server, asked: MessageFields) -> list[str]:
    """Return the keys of the sliders whose ranges are requested. Raises InputError."""
    keys = asked.get("keys")
    if not isinstance(keys, list) or not all(isinstance(key, str) for key in keys):
        raise InputError(f"{documents.SOURCE}: keys: must be a list of keys")
    return keys


def _target_speed(server: Server, asked: MessageFields) -> Any:
    """Return the target speed, as the page sent it."""
    return asked.get("speed")


def _output_folder(name: str) -> WorkArgument:
    """Return the folder of this name for the output of a command."""
    return lambda server, asked: server.folder / name


async def _run_on_document(
    work: Callable[..., Result], given: Sequence[WorkArgument], server: Server, request: Request
) -> Result:
    """Run work on a page's walker and the further arguments from `given`, and return its result."""
    document, asked = await _read_request(server, request)
    return await _await_work(server.workers, request, work, document, *(one(server, asked) for one in given))


def _answer_endpoint(work: Callable[..., Any], *given: WorkArgument, key: str = "") -> Endpoint:
    """Return an endpoint that answers with work on a page's walker, in a table if a key is given."""

    async def door(server: Server, request: Request) -> Response:
        result = await _run_on_document(work, given, server, request)
        return _json_response({key: result} if key else result)

    return door


def _command_endpoint(words: Callable[..., list[str]], *given: WorkArgument) -> Endpoint:
    """Return an endpoint that runs a command on a page's walker."""

    async def door(server: Server, request: Request) -> Response:
        command = await _run_on_document(words, given, server, request)
        return EventStream(child_processes.run_module(server.running, child_processes.COMMAND_MODULE, [command]))

    return door


async def _await_work(workers: Workers, request: Request, work: Callable[..., Result], *given: Any) -> Result:
    """Run slow work in a process and return its result. Raises ClientDisconnect if the page is closed meanwhile."""
    result = await child_processes.run_until_disconnect(request.receive, workers.answer(work, *given))
    if result is None:
        raise ClientDisconnect
    return result


class EventStream(Response):
    """Events as lines of JSON. Closing the page ends the event source."""

    media_type = "application/x-ndjson"

    def __init__(self, events: AsyncIterator[child_processes.Event]) -> None:
        super().__init__()
        del self.headers["content-length"]
        self._events = events

    async def __call__(self, scope: Any, receive: Any, send: Any) -> None:
        """Send the events as they arrive."""
        await send({"type": "http.response.start", "status": 200, "headers": self.raw_headers})

        async def lines() -> None:
            async for event in self._events:
                line = json.dumps(event).encode() + b"\n"
                await send({"type": "http.response.body", "body": line, "more_body": True})

        await child_processes.run_until_disconnect(receive, lines())
        await send({"type": "http.response.body", "body": b""})


async def _run_simulation(server: Server, request: Request) -> Response:
    """Simulate the walker; if `short` only for a first estimate."""
    document, asked = await _read_request(server, request)
    sent = {"document": document._asdict(), "short": asked.get("short") is True}
    return EventStream(child_processes.run_module(server.running, child_processes.SIMULATION_MODULE, sent))


async def _read_order(server: Server, request: Request) -> downloads.FileOrder:
    document, asked = await _read_request(server, request)
    what, copies = asked.get("what"), asked.get("copies", 1)
    return await _await_work(server.workers, request, downloads.make_order, document, what, copies, server.folder)


async def _make_files(server: Server, request: Request) -> Response:
    """Make files with their commands; `take` sends them."""
    order = await _read_order(server, request)
    if not order.commands:
        return Response(b"", media_type=EventStream.media_type)
    return EventStream(child_processes.run_module(server.running, child_processes.COMMAND_MODULE, order.commands))


async def _send_files(server: Server, request: Request) -> Response:
    """Send finished files."""
    order = await _read_order(server, request)
    name, data = await _await_work(server.workers, request, downloads.collect_files, order)
    shells = [documents.shell_command(words) for words in order.commands]
    headers = {"content-disposition": f'attachment; filename="{name}"', "walkergen-shell": json.dumps(shells)}
    return Response(data, media_type="application/octet-stream", headers=headers)


async def _receive_upload(server: Server, request: Request) -> Response:
    """Store a file that was dropped onto the page, under a generated name."""
    kind = request.query_params.get("kind", "").lower()
    data = await _read_body(request, MAX_UPLOAD_BYTES)
    if kind not in documents.UPLOAD_ENDINGS:
        raise InputError(
            f"{documents.SOURCE}: files of the kind {kind[:20]!r} are no bodies: drop an SVG or DXF drawing, "
            "a picture (PNG, JPG), or a mesh (STL, OBJ, PLY, OFF, 3MF, GLB)"
        )
    name = await asyncio.to_thread(_store_upload, server.place.uploads, kind, data)
    return _json_response({"file": name, "key": "body.outline" if kind in documents.DRAWING_ENDINGS else "body.mesh"})


def _store_upload(folder: Path, kind: str, data: bytes) -> str:
    """Write a dropped file and return its name. Raises OutputError."""
    name = f"{hashlib.sha256(data).hexdigest()[:16]}.{kind}"
    with output.Folder(folder, "") as target:
        target.write(name, data)
    (folder / name).touch()
    kept = 0
    for path in sorted(folder.glob("*.*"), key=lambda path: path.stat().st_mtime, reverse=True):
        kept += path.stat().st_size
        if kept > MAX_UPLOAD_FOLDER_BYTES and documents.UPLOAD_NAME.fullmatch(path.name) and path.name != name:
            path.unlink()
    return name


async def _send_picture(server: Server, request: Request) -> Response:
    """Send a side view of a template's walker, for the choice of a template."""
    name = request.path_params["name"]
    if name not in templates.names("walkers"):
        return _error_response(["no such picture"], 404)
    text = await asyncio.to_thread(template_pictures.side_view, name)
    return Response(text, media_type="image/svg+xml")
