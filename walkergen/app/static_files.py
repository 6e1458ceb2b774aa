"""Static files of the page: HTML, scripts and style sheets, the same for every walker."""

from functools import cache
from pathlib import Path

from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route

from walkergen.files import viewer

ASSETS = {
    "app.css": "text/css",
    **{
        f"{name}.js": "text/javascript"
        for name in ("ask", "state", "form", "part", "outlook", "jobs", "dish", "effects", "compare", "main")
    },
}
"""Files of the page in addition to its HTML, and their types."""


def routes() -> list[Route]:
    """Return the routes to the page's files."""
    scripts = [Route(f"/{name}", _send_asset) for name in ASSETS]
    return [*scripts, Route("/", _send_page), Route("/viewer.js", _send_viewer_script)]


def _send_page(request: Request) -> Response:
    return Response(_asset_bytes("app.html"), media_type="text/html; charset=utf-8")


def _send_asset(request: Request) -> Response:
    name = request.url.path.rpartition("/")[2]
    return Response(_asset_bytes(name), media_type=f"{ASSETS[name]}; charset=utf-8")


def _send_viewer_script(request: Request) -> Response:
    return Response(viewer.viewer_script(), media_type="text/javascript; charset=utf-8")


@cache
def _asset_bytes(name: str) -> bytes:
    """Read a file of the package's assets."""
    return Path(__file__).with_name("assets").joinpath(name).read_bytes()
