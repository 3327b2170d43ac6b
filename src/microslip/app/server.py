"""Web server of the workbench: routes and start-up."""

from __future__ import annotations

import asyncio
import io
import json
import mimetypes
import os
import secrets
import shutil
import socket
import tempfile
import webbrowser
import zipfile
from collections.abc import AsyncIterator, Awaitable, Callable, MutableMapping
from contextlib import asynccontextmanager
from http.cookies import SimpleCookie
from pathlib import Path
from secrets import token_urlsafe
from typing import Any
from urllib.parse import parse_qs

from microslip._core.errors import InputError
from microslip._core.packages import needed_for
from microslip.app.jobs import Forms, Run, Workspace, check_study

Scope = MutableMapping[str, Any]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

COOKIE = "microslip"
LARGEST_UPLOAD = 256 * 2**20
LARGEST_REQUEST = 2**20
UPLOADS = "/api/uploads"
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; "
    "connect-src 'self'; frame-src 'self'; frame-ancestors 'none'; base-uri 'none'; "
    "form-action 'none'"
)


class Guard:
    """Middleware that rejects requests without the token of the session before it reads them."""

    def __init__(self, app: App, token: str, port: int) -> None:
        self._app, self._token = app, token
        self._hosts = {f"127.0.0.1:{port}", f"localhost:{port}"}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request to the application, or reject it."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        if scope["type"] != "http":
            return
        headers = {k.decode("latin-1").lower(): v.decode("latin-1") for k, v in scope["headers"]}
        rejection = self._rejection(scope, headers)
        if rejection is not None:
            await _answer(send, *rejection)
            return
        if self._is_entry(scope):
            cookie = f"{COOKIE}={self._token}; HttpOnly; SameSite=Strict; Path=/"
            await _answer(send, 303, "", [("location", "/"), ("set-cookie", cookie)])
            return
        await self._app(scope, receive, _with_policy(send))

    def _rejection(self, scope: Scope, headers: dict[str, str]) -> tuple[int, str] | None:
        host, origin = headers.get("host", ""), headers.get("origin")
        if host not in self._hosts:
            return 421, "another host"
        unsafe = scope["method"] not in ("GET", "HEAD")
        if (origin is None and unsafe) or origin not in (None, f"http://{host}"):
            return 403, "another origin"
        if headers.get("sec-fetch-site", "none") not in ("same-origin", "none"):
            return 403, "another site"
        if not self._is_entry(scope) and not self._knows(headers.get("cookie", "")):
            return 401, "no token: open the address that the command printed"
        if unsafe:
            length = headers.get("content-length", "")
            # A chunked body could be longer than its declared length.
            if "transfer-encoding" in headers or not (length.isascii() and length.isdecimal()):
                return 411, "no length"
            if int(length) > (LARGEST_UPLOAD if scope["path"] == UPLOADS else LARGEST_REQUEST):
                return 413, f"too large: {int(length) / 2**20:.0f} MiB"
        return None

    def _is_entry(self, scope: Scope) -> bool:
        if scope["path"] != "/" or scope["method"] != "GET":
            return False
        tokens = parse_qs(scope.get("query_string", b"").decode("latin-1")).get("token", [""])
        return secrets.compare_digest(tokens[0].encode(), self._token.encode())

    def _knows(self, cookie: str) -> bool:
        try:
            morsel = SimpleCookie(cookie).get(COOKIE)
        except Exception:  # malformed cookie
            return False
        return morsel is not None and secrets.compare_digest(
            morsel.value.encode(), self._token.encode()
        )


def _with_policy(send: Send) -> Send:
    async def put(message: MutableMapping[str, Any]) -> None:
        if message["type"] == "http.response.start":
            named = {name.lower() for name, _ in message.get("headers", [])}
            message["headers"] = [
                *message.get("headers", []),
                *((name, value) for name, value in _HEADERS if name not in named),
            ]
        await send(message)

    return put


_HEADERS = [
    (b"content-security-policy", POLICY.encode()),
    (b"x-content-type-options", b"nosniff"),
    (b"referrer-policy", b"no-referrer"),
    (b"cross-origin-resource-policy", b"same-origin"),
    (b"cache-control", b"no-store"),
]


async def _answer(
    send: Send, status: int, text: str, headers: list[tuple[str, str]] | None = None
) -> None:
    plain = [("content-type", "text/plain; charset=utf-8"), *(headers or [])]
    encoded = [*((k.encode(), v.encode()) for k, v in plain), *_HEADERS]
    await send({"type": "http.response.start", "status": status, "headers": encoded})
    await send({"type": "http.response.body", "body": text.encode("utf-8")})


_FOLDER = Path(__file__).parent
_ASSETS = {
    "/": "app.html", "/app.js": "app.js", "/app.css": "app.css", "/ticks.js": "../figures/ticks.js",
}  # fmt: skip
_PREFIX = "microslip-app-"
# A report contains its own script and needs no access to this origin.
_REPORT = "sandbox allow-scripts; frame-ancestors 'self'"
_PICTURE = "default-src 'none'; style-src 'unsafe-inline'; img-src data:"


def build(workspace: Workspace, token: str, port: int) -> App:
    """Build the web application; a :class:`Guard` rejects requests without the token."""
    with needed_for("the workbench needs", "app"):
        from starlette.applications import Starlette
        from starlette.requests import ClientDisconnect, Request
        from starlette.responses import FileResponse, JSONResponse, Response
        from starlette.routing import Route

    def refusal(error: Exception, status: int = 422) -> Response:
        return JSONResponse({"error": str(error)}, status)

    async def page_file(request: Request) -> Response:
        path = _FOLDER / _ASSETS[request.url.path]
        return FileResponse(path, media_type=mimetypes.guess_type(path.name)[0])

    async def upload(request: Request) -> Response:
        place = workspace.place(request.query_params.get("name", "file"))
        try:
            with place.path.open("wb") as file:
                async for chunk in request.stream():
                    file.write(chunk)
        except ClientDisconnect:
            workspace.uploads.pop(place.id)
            shutil.rmtree(place.path.parent, ignore_errors=True)
            raise
        return JSONResponse(place.summary())

    async def look(request: Request) -> Response:
        stored = workspace.uploads.get(request.path_params["id"])
        if stored is None:
            return refusal(KeyError("no such upload"), 404)
        try:
            table = await _table(request)
            if table.get("what") == "study":
                text = check_study(stored.path)
                return JSONResponse({"what": "study", "name": stored.name, "text": text})
            kind = "scan" if table.get("what") == "scan" else "record"
            view = await workspace.look(kind, stored, table.get("options"))
            return JSONResponse(view, 422 if "error" in view else 200)
        except InputError as error:
            return refusal(error)

    async def runs(request: Request) -> Response:
        if request.method == "GET":
            return JSONResponse([run.summary() for run in workspace.runs.values()])
        try:
            return JSONResponse(workspace.start(await _table(request)).summary())
        except InputError as error:
            return refusal(error)

    def run_of(request: Request) -> Run | None:
        return workspace.runs.get(request.path_params["id"])

    async def run_by_id(request: Request) -> Response:
        run = run_of(request)
        if run is None:
            return refusal(KeyError("no such run"), 404)
        if request.method == "DELETE":
            await workspace.remove(run)
            return JSONResponse({})
        if request.method == "POST":
            await workspace.cancel(run)
        return JSONResponse(run.summary())

    async def result(request: Request) -> Response:
        run = run_of(request)
        files = {} if run is None else run.files()
        path = files.get(request.path_params["name"])  # looked up, never joined to a path
        if path is None:
            return refusal(KeyError("no such file"), 404)
        policy = {".html": _REPORT, ".svg": _PICTURE}.get(path.suffix, "default-src 'none'")
        return FileResponse(path, headers={"content-security-policy": policy})

    async def download(request: Request) -> Response:
        run = run_of(request)
        if run is None or not run.files():
            return refusal(KeyError("no such result"), 404)
        data = await asyncio.to_thread(_archive, run)
        name = f"microslip-{run.kind}-{run.id[:6]}.zip"
        headers = {"content-disposition": f'attachment; filename="{name}"'}
        return Response(data, media_type="application/zip", headers=headers)

    async def forms(request: Request) -> Response:
        return JSONResponse({
            name: [vars(field) for field in fields] for name, fields in workspace.forms.items()
        })  # fmt: skip

    async def example(request: Request) -> Response:
        from microslip.study.new import demo_text

        place = workspace.place("study.toml")
        place.path.write_text(demo_text(), encoding="utf-8")
        return JSONResponse(place.summary())

    @asynccontextmanager
    async def lifespan(app: Any) -> AsyncIterator[None]:
        yield
        await workspace.close()

    routes = [
        *(Route(path, page_file) for path in _ASSETS),
        Route("/api/uploads", upload, methods=["POST"]),
        Route("/api/uploads/{id}/look", look, methods=["POST"]),
        Route("/api/forms", forms),
        Route("/api/example", example, methods=["POST"]),
        Route("/api/runs", runs, methods=["GET", "POST"]),
        Route("/api/runs/{id}", run_by_id, methods=["GET", "POST", "DELETE"]),
        Route("/runs/{id}/files/{name}", result),
        Route("/runs/{id}/download.zip", download),
    ]
    return Guard(Starlette(routes=routes, lifespan=lifespan), token, port)


async def _table(request: Any) -> dict[str, Any]:
    try:
        table = json.loads(await request.body())
    except (ValueError, RecursionError):
        raise InputError("a request must be JSON") from None
    if not isinstance(table, dict):
        raise InputError("a request must be a JSON object")
    return table


def _archive(run: Run) -> bytes:
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("command.txt", f"{run.command}\n")
        for path in sorted(run.folder.iterdir()):
            if path.is_file():
                archive.write(path, path.name)
        for name, path in run.files().items():
            archive.write(path, f"result/{name}")
    return file.getvalue()


def serve(forms: Forms, port: int = 0, open_browser: bool = True, say: Any = print) -> None:
    """Serve the workbench on this machine until interrupted."""
    with needed_for("the workbench needs", "app"):
        import uvicorn
    listening = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    try:
        listening.bind(("127.0.0.1", port))
    except OSError as error:
        listening.close()
        raise InputError(f"port {port} cannot be used: {error.strerror}") from None
    port, token = listening.getsockname()[1], token_urlsafe(32)
    with tempfile.TemporaryDirectory(prefix=f"{_PREFIX}{os.getpid()}-") as folder:
        app = build(Workspace(Path(folder), forms), token, port)
        address = f"http://127.0.0.1:{port}/?token={token}"
        say(f"The workbench runs at {address}\nPress Ctrl-C to stop it and delete its files.")
        if open_browser:
            webbrowser.open(address)
        config = uvicorn.Config(app, log_level="warning", access_log=False, server_header=False)
        uvicorn.Server(config).run(sockets=[listening])
