"""The built browser client: files from one folder, and its first page for every other path that a person may
open.
"""

import os
from mimetypes import guess_type
from pathlib import Path

from fastapi import APIRouter
from fastapi.responses import FileResponse, HTMLResponse
from starlette.requests import Request
from starlette.responses import Response

from app.edge.error_answers import allowed_methods, method_not_allowed
from app.errors import NotFound
from app.settings import Settings
from estimators.sentences import say

_TREE = Path(__file__).resolve().parents[2] / "web" / "dist"
_PACKAGED = Path(__file__).resolve().parents[1] / "static"
NOT_PAGES = ("api", "ws", "viewer")
"""First parts of paths that are never answered with the client's first page."""

_NOT_BUILT = (
    "<!doctype html><html lang=en><title>Telemotion</title><h1>The browser client is not built</h1>"
    "<p>Run <code>make web</code> and load this page again. The service itself is running: "
    "<a href=/api/docs>its interface</a>.</html>"
)


def client_folder(settings: Settings) -> Path | None:
    """Return the folder of the built client, or None when there is none.

    Parameters
    ----------
    settings : Settings
        `client_dir` wins over the tree's web/dist, which wins over the packaged one.
    """
    candidates = [settings.client_dir] if settings.client_dir else [_TREE, _PACKAGED]
    return next((folder.resolve() for folder in candidates if (folder / "index.html").is_file()), None)


def client_router(settings: Settings) -> APIRouter:
    """Return the routes of the client; include them last, they match every path."""
    router = APIRouter(include_in_schema=False)

    @router.get("/{path:path}", response_class=Response)
    def client(path: str, request: Request) -> Response:
        """Return a file of the client, or its first page."""
        if path.split("/", 1)[0] in NOT_PAGES:
            if allowed_methods(request):
                return method_not_allowed(request)
            raise NotFound(say("edge.no_such_address"))
        folder = client_folder(settings)
        if folder is None:
            return HTMLResponse(_NOT_BUILT, status_code=503)
        target = (folder / path).resolve()
        # `Path.is_file` raises where folder and address together are too long for the file system.
        if target.is_relative_to(folder) and os.path.isfile(target) and target.name != "index.html":
            # Built files carry a hash of their content in their name; others (icons, the worker) may change.
            hashed = path.startswith("assets/")
            caching = "public, max-age=31536000, immutable" if hashed else "no-cache"
            return _file(target, caching, request)
        if "." in path.rsplit("/", 1)[-1]:
            raise NotFound(say("edge.no_such_file"))
        return _file(folder / "index.html", "no-cache", request)

    return router


def _file(target: Path, caching: str, request: Request) -> Response:
    """Return a file, packed at build time where the browser takes it so: nothing is packed while one waits."""
    headers = {"Cache-Control": caching, "Vary": "Accept-Encoding"}
    accepted = {
        part.split(";", 1)[0].strip() for part in request.headers.get("accept-encoding", "").split(",")
    }
    for encoding, ending in (("br", ".br"), ("gzip", ".gz")):
        packed = target.with_name(target.name + ending)
        if encoding in accepted and packed.is_file():
            media_type = guess_type(target.name)[0] or "application/octet-stream"
            return FileResponse(
                packed, media_type=media_type, headers=headers | {"Content-Encoding": encoding}
            )
    return FileResponse(target, headers=headers)
