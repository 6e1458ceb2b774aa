"""Server of the page on which walkers are designed: a door for each thing that the page asks.

Doors stand below a path that nobody can guess, and open only to pages of this server: a page of
elsewhere names another Host or Origin. No path of a file comes from a page.
"""

import hashlib
import json
import secrets
from collections.abc import AsyncIterator, Awaitable, Callable
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import RedirectResponse, Response, StreamingResponse
from starlette.routing import Mount, Route

from walkergen.app import answers, children, form, pictures, taking
from walkergen.app import document as documents
from walkergen.app.document import Document, Place
from walkergen.errors import InputError, WalkergenError
from walkergen.files import output, templates, viewer
from walkergen.files.ledger import manifest

MOST_BYTES = 1_000_000
"""Longest message of a page, bytes, as of a TOML file."""

MOST_UPLOADED = 200_000_000
"""Largest file that may be dropped onto a page, bytes."""

KEPT = "kept.json"
"""File in the server's folder with the document that was changed last."""

START = {"scene.run.seconds": 10.0, "scene.run.runs": 8}
"""Values of a new document: a run that is done within seconds."""

POLICY = (
    "default-src 'none'; connect-src 'self'; script-src 'self'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data:; frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
)
ASSETS = {
    "app.css": "text/css",
    **{
        f"{name}.js": "text/javascript"
        for name in ("ask", "state", "form", "part", "outlook", "jobs", "compare", "main")
    },
}
"""Files of the page beside its HTML, and their types."""


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
    """Document of a page that is opened for the first time."""
    once: str | None = None
    """Word in the address that opens the page once, for a phone; None for this machine alone."""


def new(
    folder: Path, hosts: frozenset[str], first: Document, own: str | None, away: bool
) -> Server:
    """Server with fresh secrets; `away` if other machines can reach it."""
    place = Place(folder / "uploads", own)
    once = secrets.token_urlsafe(9) if away else None
    return Server(folder, hosts, secrets.token_urlsafe(18), place, first, once)


def application(server: Server) -> Any:
    """ASGI application of a server."""
    doors: dict[str, Callable[[Server, Request], Awaitable[Response]]] = {
        "start": _start, "walker": _walker, "outlook": _outlook, "form": _form, "keep": _keep,
        "run": _run, "play": _play, "design": _design, "take": _take, "upload": _upload,
    }  # fmt: skip
    inner: list[Any] = [
        *(Route(f"/{name}", _door(server, door), methods=["POST"]) for name, door in doors.items()),
        *(Route(f"/{name}", _asset) for name in ASSETS),
        Route("/", _page), Route("/viewer.js", _viewer), Route("/picture/{name}.svg", _picture),
    ]  # fmt: skip
    used: list[str] = []

    def once(request: Request) -> Response:
        if used or request.path_params["word"] != server.once:
            return _refused(["this address has been used: start walkergen app again"], 410)
        used.append("")
        return RedirectResponse(f"/{server.secret}/", 303)

    outer: list[Any] = [Mount(f"/{server.secret}", routes=inner)]
    if server.once:
        outer.append(Route("/once/{word}", once))
    return _guarded(Starlette(routes=outer), server.hosts)


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
                    *message["headers"], (b"content-security-policy", POLICY.encode()),
                    (b"referrer-policy", b"no-referrer"), (b"x-content-type-options", b"nosniff"),
                    (b"cache-control", b"no-store"),
                    (b"cross-origin-resource-policy", b"same-origin"),
                ]  # fmt: skip
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

    return endpoint


async def _body(request: Request, most: int = MOST_BYTES) -> bytes:
    """Message of a page. Raises InputError for one that is too long."""
    data = bytearray()
    async for piece in request.stream():
        data += piece
        if len(data) > most:
            raise InputError(f"{documents.SOURCE}: more than {most / 1e6:g} MB")
    return bytes(data)


async def _asked(server: Server, request: Request) -> tuple[Document, dict[str, Any]]:
    """Document of a request, and what else it says. Raises InputError."""
    data = documents.json_of(await _body(request))
    inner = data.pop("document", None)
    return documents.read(json.dumps(inner).encode(), server.place), data


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
    kept = await run_in_threadpool(_kept, server)
    return _json({
        **names, "walkers": server.place.walkers(), "about": about,
        "document": kept or server.first._asdict(), "fresh": server.first._asdict(),
    })  # fmt: skip


def _kept(server: Server) -> Any:
    """Document that was kept; None for none, where its files are gone, and for another walker's
    than that of the command line.
    """
    try:
        kept = json.loads((server.folder / KEPT).read_bytes())["document"]
        documents.read(json.dumps(kept).encode(), server.place)
    except (OSError, ValueError, KeyError, TypeError, WalkergenError):
        return None
    return kept if server.place.own in (None, kept["walker"]) else None


async def _keep(server: Server, request: Request) -> Response:
    """Keep a document, as the page sent it, for the next start."""
    data = await _body(request)
    inner = documents.json_of(data).get("document")
    documents.read(json.dumps(inner).encode(), server.place)
    await run_in_threadpool(output.renew, server.folder / KEPT, manifest({"document": inner}))
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

    return Response(await run_in_threadpool(answer), media_type="application/octet-stream")


async def _outlook(server: Server, request: Request) -> Response:
    document, _ = await _asked(server, request)
    return _json(await run_in_threadpool(answers.outlook, document))


async def _form(server: Server, request: Request) -> Response:
    document, _ = await _asked(server, request)

    def answer() -> dict[str, Any]:
        groups = [
            {"title": group.title, "controls": [control._asdict() for control in group.controls]}
            for group in form.groups(document)
        ]
        return {
            "groups": groups,
            "legs": form.listed_legs(document),
            "shapes": form.shapes(document),
        }

    return _json(await run_in_threadpool(answer))


def _streamed(events: AsyncIterator[children.Event]) -> Response:
    """Events as lines of JSON; a page that goes away ends what makes them."""

    async def lines() -> AsyncIterator[bytes]:
        async for event in events:
            yield json.dumps(event).encode() + b"\n"

    return StreamingResponse(lines(), media_type="application/x-ndjson")


async def _run(server: Server, request: Request) -> Response:
    document, _ = await _asked(server, request)
    words = documents.arguments(document, "simulate", "--json")
    return _streamed(children.run(children.COMMAND, words, Path.cwd(), None))


async def _play(server: Server, request: Request) -> Response:
    document, _ = await _asked(server, request)
    return _streamed(children.run(children.PLAY, (), Path.cwd(), document._asdict()))


async def _design(server: Server, request: Request) -> Response:
    """Search for a walker of a wished speed, as `walkergen design` does."""
    document, wish = await _asked(server, request)
    words = taking.search(document, wish, server.folder / "designs")
    return _streamed(children.run(children.COMMAND, words, Path.cwd(), None))


async def _take(server: Server, request: Request) -> Response:
    """Make files by their commands, and hand them out."""
    document, asked = await _asked(server, request)
    what, copies = asked.get("what"), asked.get("copies", 1)
    order = taking.order(document, what, copies, server.folder)
    for words in order.commands:
        refused = None
        async for event in children.run(children.COMMAND, words, Path.cwd(), None):
            refused = event.get("refused", refused)
        if refused:
            return _refused(refused, 422)
    name, data = await run_in_threadpool(taking.collected, order)
    shells = [documents.shell(words) for words in order.commands]
    headers = {
        "content-disposition": f'attachment; filename="{name}"',
        "walkergen-shell": json.dumps(shells),
    }
    return Response(data, media_type="application/octet-stream", headers=headers)


async def _upload(server: Server, request: Request) -> Response:
    """Keep a file that was dropped onto the page, under a name of ours."""
    kind = request.query_params.get("kind", "").lower()
    data = await _body(request, MOST_UPLOADED)
    name = f"{hashlib.sha256(data).hexdigest()[:16]}.{kind}"
    if not documents.UPLOADED.fullmatch(name):
        raise InputError(
            f"{documents.SOURCE}: files of the kind {kind[:20]!r} are no bodies: drop an SVG or "
            "DXF drawing, or a mesh (STL, OBJ, PLY, OFF, 3MF, GLB)"
        )
    path = server.place.uploads / name
    if not path.exists():
        await run_in_threadpool(output.write, path, data)
    return _json({"file": name, "key": "body.outline" if kind in ("svg", "dxf") else "body.mesh"})


async def _picture(request: Request) -> Response:
    """Side view of a template's walker, to start from."""
    name = request.path_params["name"]
    if name not in templates.names("walkers"):
        return Response(status_code=404)
    text = await run_in_threadpool(pictures.side_view, name)
    return Response(text, media_type="image/svg+xml")


def _page(request: Request) -> Response:
    return Response(_asset_bytes("app.html"), media_type="text/html; charset=utf-8")


def _asset(request: Request) -> Response:
    name = request.url.path.rpartition("/")[2]
    return Response(_asset_bytes(name), media_type=f"{ASSETS[name]}; charset=utf-8")


def _viewer(request: Request) -> Response:
    return Response(viewer.script(), media_type="text/javascript; charset=utf-8")


@cache
def _asset_bytes(name: str) -> bytes:
    """File that is shipped beside this module."""
    return Path(__file__).with_name("assets").joinpath(name).read_bytes()
