"""Who may ask the workbench: this machine's browser, with its token, from its own page."""

from __future__ import annotations

import secrets
from collections.abc import Awaitable, Callable, MutableMapping
from http.cookies import SimpleCookie
from typing import Any
from urllib.parse import parse_qs

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
    """Refuses all but the page that was opened, before anything of a request is read."""

    def __init__(self, app: App, token: str, port: int) -> None:
        self._app, self._token = app, token
        self._hosts = {f"127.0.0.1:{port}", f"localhost:{port}"}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, or answer it."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        if scope["type"] != "http":
            return
        headers = {k.decode("latin-1").lower(): v.decode("latin-1") for k, v in scope["headers"]}
        refused = self._refused(scope, headers)
        if refused is not None:
            await _answer(send, *refused)
            return
        if self._is_entry(scope):
            cookie = f"{COOKIE}={self._token}; HttpOnly; SameSite=Strict; Path=/"
            await _answer(send, 303, "", [("location", "/"), ("set-cookie", cookie)])
            return
        limit = LARGEST_UPLOAD if scope["path"] == UPLOADS else LARGEST_REQUEST
        await self._app(scope, _limited(receive, limit), _with_policy(send))

    def _refused(self, scope: Scope, headers: dict[str, str]) -> tuple[int, str] | None:
        host, origin = headers.get("host", ""), headers.get("origin")
        if host not in self._hosts:
            return 421, "another host"
        unsafe = scope["method"] not in ("GET", "HEAD")
        if (origin is None and unsafe) or origin not in (None, f"http://{host}"):
            return 403, "another origin"
        if headers.get("sec-fetch-site", "none") not in ("same-origin", "none"):
            return 403, "another site"
        if not self._is_entry(scope) and not self._knows(headers.get("cookie", "")):
            return 401, "no token: open the address that the command has printed"
        if unsafe:
            length = headers.get("content-length", "")
            if not length.isascii() or not length.isdecimal():
                return 411, "no length"
            if int(length) > (LARGEST_UPLOAD if scope["path"] == UPLOADS else LARGEST_REQUEST):
                return 413, f"too large: {int(length) / 2**20:.0f} MiB"
        return None

    def _is_entry(self, scope: Scope) -> bool:
        """Whether this is the address that the command has opened."""
        if scope["path"] != "/" or scope["method"] != "GET":
            return False
        tokens = parse_qs(scope.get("query_string", b"").decode("latin-1")).get("token", [""])
        return secrets.compare_digest(tokens[0].encode(), self._token.encode())

    def _knows(self, cookie: str) -> bool:
        try:
            morsel = SimpleCookie(cookie).get(COOKIE)
        except Exception:  # whatever somebody sends as a cookie
            return False
        return morsel is not None and secrets.compare_digest(
            morsel.value.encode(), self._token.encode()
        )


def _limited(receive: Receive, limit: int) -> Receive:
    """What is read, up to a limit whatever the length was said to be."""
    remaining = limit

    async def read() -> MutableMapping[str, Any]:
        nonlocal remaining
        message = await receive()
        remaining -= len(message.get("body", b""))
        return {"type": "http.disconnect"} if remaining < 0 else message

    return read


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
