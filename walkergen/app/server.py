"""Server of the page on which walkers are designed, with one endpoint for each request of the page.

Endpoints are below a secret path. No file path comes from a page.
"""

import asyncio
import hashlib
import json
import secrets
from collections.abc import Awaitable, Callable, Sequence
from pathlib import Path
from typing import Any, TypeVar

from starlette.applications import Starlette
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect, Request
from starlette.responses import RedirectResponse, Response
from starlette.routing import Mount, Route

from walkergen.app import (
    child_processes,
    command_results,
    curves,
    downloads,
    form,
    messages,
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

MAX_UPLOAD_BYTES = 200_000_000
"""Largest file that may be dropped onto a page, bytes."""

MAX_UPLOAD_FOLDER_BYTES = 2 * MAX_UPLOAD_BYTES
"""Total size of all stored dropped files, bytes; the oldest are deleted first."""

SAVED_DOCUMENT = "kept.json"
"""File in the server's folder with the last changed document."""

MAX_SAVED_BYTES = 50 * messages.MAX_MESSAGE_BYTES
"""Largest saved document, bytes: a message with a line for each number in it."""

Result = TypeVar("Result")


Endpoint = Callable[[Server, Request], Awaitable[Response]]
MessageFields = dict[str, Any]
WorkArgument = Callable[[Server, MessageFields], Any]
"""Function that returns an argument for work in another process, from the fields of the page's message."""


def application(server: Server) -> Any:
    """Return the ASGI application of a server, with all its endpoints."""
    endpoints: dict[str, Endpoint] = {
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
        "crowd": _command_endpoint(command_results.crowd_arguments, _output_folder("crowds")),
        "crowded": _answer_endpoint(command_results.read_playback, _output_folder("crowds")),
        "effects": _command_endpoint(command_results.explain_arguments, _output_folder("effects")),
        "effects_drawn": _answer_endpoint(command_results.read_picture, _output_folder("effects")),
        "nearest": _command_endpoint(downloads.sweep_arguments, _target_speed, _output_folder("sweep")),
        "make": _make_files,
        "take": _send_files,
        "upload": _receive_upload,
    }
    inner: list[Any] = [
        *(Route(f"/{name}", _handle_refusals(server, work), methods=["POST"]) for name, work in endpoints.items()),
        Route("/picture/{name}.svg", _handle_refusals(server, _send_picture)),
        *static_files.routes(),
    ]
    word = (server.once or "").encode()
    used: list[bytes] = []  # the word after its first use

    def redirect_once(request: Request) -> Response:
        """Redirect the first request that has the right secret word to the page, and refuse all others."""
        if used or not secrets.compare_digest(request.path_params["word"].encode(), word):
            return messages.error_response(["This address has already been used. Start walkergen app again."], 410)
        used.append(word)
        return RedirectResponse(f"/{server.secret}/", 303)

    outer: list[Any] = [Mount(f"/{server.secret}", routes=inner)]
    if server.once:
        outer.append(Route("/once/{word}", redirect_once))
    handlers: Any = {HTTPException: messages.handle_http_error, Exception: messages.handle_internal_error}
    return messages.restrict_hosts(Starlette(routes=outer, exception_handlers=handlers), server.hosts)


def _handle_refusals(server: Server, endpoint: Endpoint) -> Any:
    """Return a handler of requests that calls an endpoint and answers with a message if it raises an error."""

    async def handle_request(request: Request) -> Response:
        try:
            return await endpoint(server, request)
        except WalkergenError as error:
            return messages.json_response({"refused": walker_answers.format_refusal(error)}, 422)
        except (MemoryError, RecursionError):
            return messages.error_response(["Too large for the memory of this machine. Try a smaller job."], 422)
        except TimeoutError:
            return messages.error_response(["The message was not received completely. Try again."], 408)
        except ClientDisconnect:  # the client has gone
            return Response(status_code=204)

    return handle_request


async def _read_request(server: Server, request: Request) -> tuple[Document, dict[str, Any]]:
    """Return the document of a request, and its other fields. Raises InputError."""
    message = documents.parse_message(await messages.read_body(request))
    return documents.from_message(message.pop("document", None), server.page_files), message


async def _send_start_data(server: Server, request: Request) -> Response:
    """Send the data that a page loads once: the names of all templates, and the document to begin with."""
    names = {kind: templates.names(kind) for kind in templates.KINDS}
    about = {row["name"]: row["description"] for row in templates.list_templates().facts["rows"]}
    kept = await asyncio.to_thread(_load_saved, server)
    return messages.json_response(
        {
            **names,
            "walkers": server.page_files.walkers(),
            "about": about,
            "titles": sentences.TITLES,
            "table": TABLE_SCENE,
            "new": kept is None and not server.replaces_saved,
            "document": kept or server.first._asdict(),
            "fresh": server.first._asdict(),
        }
    )


def _load_saved(server: Server) -> Any:
    """Load the saved document; None if there is none, its files are missing, or the command line names another."""
    try:
        data = file_reading.read_bytes(server.folder / SAVED_DOCUMENT, MAX_SAVED_BYTES, "a JSON file")
        kept = documents.parse_message(data).get("document")
        document = documents.from_message(kept, server.page_files)
    except WalkergenError:
        return None
    same_files = document[:3] == server.first[:3] and server.first.values == START_VALUES
    return kept if same_files or not server.replaces_saved else None


async def _save_document(server: Server, request: Request) -> Response:
    """Save the page's document, as it was sent, for the next start of the server."""
    document = documents.parse_message(await messages.read_body(request)).get("document")
    documents.from_message(document, server.page_files)
    kept = encode_manifest({"document": document})
    await asyncio.to_thread(output.rewrite_sealed, server.folder / SAVED_DOCUMENT, kept)
    return messages.json_response({})


async def _send_walker(server: Server, request: Request) -> Response:
    """Send facts on the walker as a line of JSON, then its triangles as bytes (see `walker_answers.pack_walker`)."""
    document, _ = await _read_request(server, request)
    packed = await _await_work(server.steps, request, walker_answers.pack_walker, document)
    return Response(packed, media_type="application/octet-stream")


def _is_rough(server: Server, fields: MessageFields) -> bool:
    """Return whether the page requests a curve with few points, as it does while a slider moves."""
    return fields.get("rough") is True


def _slider_keys(server: Server, fields: MessageFields) -> list[str]:
    """Return the keys of the sliders whose ranges are requested. Raises InputError."""
    keys = fields.get("keys")
    if not isinstance(keys, list) or not all(isinstance(key, str) for key in keys):
        raise InputError(f"{documents.SOURCE}: keys: must be a list of keys")
    return keys


def _target_speed(server: Server, fields: MessageFields) -> Any:
    """Return the target speed as the page sent it, not validated."""
    return fields.get("speed")


def _file_choice(server: Server, fields: MessageFields) -> downloads.FileChoice:
    """Return the choice of files that the page requests. Raises InputError."""
    return downloads.parse_choice(fields.get("what"), fields.get("copies", 1))


def _output_folder(name: str) -> WorkArgument:
    """Return a function that returns the folder `name` in the server's folder."""
    return lambda server, fields: server.folder / name


async def _run_on_document(
    work: Callable[..., Result], extra_arguments: Sequence[WorkArgument], server: Server, request: Request
) -> Result:
    """Return the result of `work`, called in another process with the page's document and the extra arguments."""
    document, fields = await _read_request(server, request)
    return await _await_work(server.workers, request, work, document, *(get(server, fields) for get in extra_arguments))


def _answer_endpoint(work: Callable[..., Any], *extra_arguments: WorkArgument, key: str = "") -> Endpoint:
    """Return an endpoint that answers with the result of `work`. With a `key` the answer is {key: result}."""

    async def endpoint(server: Server, request: Request) -> Response:
        result = await _run_on_document(work, extra_arguments, server, request)
        return messages.json_response({key: result} if key else result)

    return endpoint


def _command_endpoint(make_arguments: Callable[..., list[str]], *extra_arguments: WorkArgument) -> Endpoint:
    """Return an endpoint that runs a command and streams its events. `make_arguments` returns the command line."""

    async def endpoint(server: Server, request: Request) -> Response:
        command = await _run_on_document(make_arguments, extra_arguments, server, request)
        return messages.EventStream(
            child_processes.run_module(server.running, child_processes.COMMAND_MODULE, [command])
        )

    return endpoint


async def _await_work(workers: Workers, request: Request, work: Callable[..., Result], *arguments: Any) -> Result:
    """Call `work` in another process and return its result. Raises ClientDisconnect if the page is closed."""
    result = await child_processes.run_until_disconnect(request.receive, workers.answer(work, *arguments))
    if result is None:
        raise ClientDisconnect
    return result


async def _run_simulation(server: Server, request: Request) -> Response:
    """Simulate the walker in a child process and stream its events. With the field `short`, only predict its speed."""
    document, fields = await _read_request(server, request)
    sent = {"document": document._asdict(), "short": fields.get("short") is True}
    return messages.EventStream(child_processes.run_module(server.running, child_processes.SIMULATION_MODULE, sent))


async def _make_files(server: Server, request: Request) -> Response:
    """Make the requested files by running commands, and stream their events. `_send_files` sends the files."""
    commands = await _run_on_document(downloads.file_commands, (_file_choice, _output_folder("")), server, request)
    if not commands:
        return Response(b"", media_type=messages.EventStream.media_type)
    return messages.EventStream(child_processes.run_module(server.running, child_processes.COMMAND_MODULE, commands))


async def _send_files(server: Server, request: Request) -> Response:
    """Send the finished files, with the shell commands that made them in a header."""
    name, data, commands = await _run_on_document(
        downloads.collect_files, (_file_choice, _output_folder("")), server, request
    )
    shells = [documents.shell_command(words) for words in commands]
    headers = {"content-disposition": f'attachment; filename="{name}"', "walkergen-shell": json.dumps(shells)}
    return Response(data, media_type="application/octet-stream", headers=headers)


async def _receive_upload(server: Server, request: Request) -> Response:
    """Store a file that was dropped onto the page, and send its new name and the key that it sets."""
    kind = request.query_params.get("kind", "").lower()
    data = await messages.read_body(request, MAX_UPLOAD_BYTES)
    if kind not in documents.UPLOAD_ENDINGS:
        raise InputError(
            f"{documents.SOURCE}: a file of the type {kind[:20]!r} cannot be a body. Drop an SVG or DXF drawing, "
            "a picture (PNG, JPG), or a mesh (STL, OBJ, PLY, OFF, 3MF, GLB)."
        )
    name = await asyncio.to_thread(_store_upload, server.page_files.uploads, kind, data)
    return messages.json_response(
        {"file": name, "key": "body.outline" if kind in documents.DRAWING_ENDINGS else "body.mesh"}
    )


def _store_upload(folder: Path, kind: str, data: bytes) -> str:
    """Write a dropped file with suffix `kind`, named by its hash. Return its name. The oldest files may be deleted."""
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
        return messages.error_response(["Unknown picture."], 404)
    text = await asyncio.to_thread(template_pictures.side_view, name)
    return Response(text, media_type="image/svg+xml")
