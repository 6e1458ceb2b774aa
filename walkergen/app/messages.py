"""Messages between the server and its pages: allowed senders, largest lengths, and the form of answers.

Endpoints answer only pages of this server. Other pages send another Host or Origin.
"""

import asyncio
import json
from collections.abc import AsyncIterator
from typing import Any

from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import HTMLResponse, Response

from walkergen.app import child_processes
from walkergen.app import document as documents
from walkergen.core.errors import InputError

MAX_MESSAGE_BYTES = 1_000_000
"""Longest message of a page, bytes, equal to that of a TOML file."""

MAX_RECEIVED_BYTES = 1_000_000_000
"""Bytes of a message after which the connection is closed, for any sender."""

RECEIVE_TIMEOUT_S = 20.0
"""Time after which a stalled message is abandoned, s."""

CONTENT_POLICY = (
    "default-src 'none'; connect-src 'self'; script-src 'self'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data:; frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
)

BAD_ADDRESS_PAGE = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>walkergen: incomplete address</title>
<style>body { font: 18px/1.5 system-ui, sans-serif; max-width: 34rem; margin: 3rem auto; padding: 0 1rem;
color: #22282d; background: #fff; } code { overflow-wrap: anywhere; }
@media (prefers-color-scheme: dark) { body { color: #e4e8ec; background: #15191d; } }</style></head>
<body><main><h1>Almost there</h1>
<p>walkergen is running, but this address is incomplete. The full address ends in a long secret word, so that no
other page can reach your designs.</p>
<p>Go to the terminal in which you started walkergen. It shows a line <code>the page: http://…</code>. Open that
full address. Or press Ctrl-C there and start walkergen again. It then opens the page.</p>
</main></body></html>
"""
"""Page for unknown addresses."""


def restrict_hosts(app: Any, hosts: frozenset[str]) -> Any:
    """Return an ASGI application that passes requests for these `hosts` to `app`, and adds security headers.

    It refuses requests with another Host, or with an Origin other than their Host.
    """

    async def handle_request(scope: Any, receive: Any, send: Any) -> None:
        if scope["type"] != "http":
            await app(scope, receive, send)
            return
        headers = dict(scope["headers"])
        host = headers.get(b"host", b"").decode("latin-1")
        origin = headers.get(b"origin")
        if host not in hosts or origin not in (None, f"http://{host}".encode("latin-1")):
            await error_response(["This server answers only its own pages."], 403)(scope, receive, send)
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


def handle_http_error(request: Request, error: HTTPException) -> Response:
    """Return the answer to an unknown address or an invalid request: a page for a browser, else JSON."""
    if request.method == "GET" and "text/html" in request.headers.get("accept", ""):
        return HTMLResponse(BAD_ADDRESS_PAGE, error.status_code)
    return error_response([f"Unknown address: {error.detail}"], error.status_code)


def handle_internal_error(_: Request, error: Exception) -> Response:
    """Return the answer to an internal error; the terminal shows the error."""
    return error_response(["Internal error. See the terminal for details, and please report it."], 500)


async def read_body(request: Request, max_bytes: int = MAX_MESSAGE_BYTES) -> bytes:
    """Read the body of a request. Raises InputError if it is too long, TimeoutError if it stalls."""
    data, length = bytearray(), 0
    stream = request.stream()
    while True:  # to its end: a client that still sends cannot receive the refusal
        try:
            piece = await asyncio.wait_for(anext(stream), RECEIVE_TIMEOUT_S)
        except StopAsyncIteration:
            break
        length += len(piece)
        if length <= max_bytes:
            data += piece
        elif length > MAX_RECEIVED_BYTES:
            break
    if length > max_bytes:
        raise InputError(f"{documents.SOURCE}: more than {max_bytes / 1e6:g} MB")
    return bytes(data)


def json_response(data: Any, status: int = 200) -> Response:
    """Return a response with data as JSON text, and this HTTP status."""
    text = json.dumps(data, allow_nan=False, ensure_ascii=False)
    return Response(text.encode(errors="replace"), status, media_type="application/json")


def error_response(lines: list[str], status: int) -> Response:
    """Return an answer that refuses a request, with a reason in each line, and with this HTTP status."""
    return json_response({"refused": [{"key": "", "text": line} for line in lines]}, status)


class EventStream(Response):
    """Response that sends events as lines of JSON while they arrive. If the page is closed, the events are ended."""

    media_type = "application/x-ndjson"

    def __init__(self, events: AsyncIterator[child_processes.Event]) -> None:
        super().__init__()
        del self.headers["content-length"]
        self._events = events

    async def __call__(self, scope: Any, receive: Any, send: Any) -> None:
        """Send the events as they arrive."""
        await send({"type": "http.response.start", "status": 200, "headers": self.raw_headers})

        async def send_lines() -> None:
            async for event in self._events:
                line = json.dumps(event).encode() + b"\n"
                await send({"type": "http.response.body", "body": line, "more_body": True})

        await child_processes.run_until_disconnect(receive, send_lines())
        await send({"type": "http.response.body", "body": b""})
