"""Who may ask: checked before anything else is read.

A page of somebody else's must not ask through a visitor's browser: requests must name this host
(else a name that is made to point here would do) and, where a browser says where they come from,
come from our own page. No CORS header is ever sent.
"""

import hmac
from collections.abc import Iterable
from dataclasses import dataclass
from urllib.parse import urlsplit

from starlette.datastructures import Headers
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from sceneq_nodes.web.problem import ProblemError

LOOPBACK = frozenset({"localhost", "127.0.0.1", "[::1]"})
OPEN_PATHS = ("/", "/static/", "/openapi.json")
"""What holds nothing of the scene: the page itself, which then asks for the token."""
TOKEN_PROTOCOL = "sceneq.token."
SECURITY_HEADERS = (
    (b"content-security-policy", b"default-src 'self'; img-src 'self' blob: data:; "
     b"style-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'"),
    (b"x-content-type-options", b"nosniff"),
    (b"referrer-policy", b"no-referrer"),
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Access:
    """``token``: what a client must know, "" = nothing; ``hosts``: names this server goes by."""

    token: str
    hosts: frozenset[str]
    max_body_bytes: int


class Guard:
    """Lets requests through to ``app``, or answers with a problem."""

    def __init__(self, app: ASGIApp, access: Access) -> None:
        self._app = app
        self._access = access

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Check one connection."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        try:
            self._check(scope)
        except ProblemError as problem:
            await self._refuse(problem, scope, receive, send)
            return
        await self._app(scope, self._limited(receive), _with_headers(send))

    def _check(self, scope: Scope) -> None:
        headers = Headers(scope=scope)
        host = hostname(headers.get("host", ""))
        if host not in self._access.hosts:
            raise ProblemError(421, f"this is not {host or 'a host without a name'}", "see hosts:")
        origin = headers.get("origin")
        if origin is not None and urlsplit(origin).netloc != headers.get("host"):
            raise ProblemError(403, f"a page of {origin} may not ask here")
        if int_or(headers.get("content-length"), 0) > self._access.max_body_bytes:
            raise ProblemError(413, f"the limit is {self._access.max_body_bytes} bytes")
        if self._access.token and not _is_open(scope["path"]) and not self._knows(headers):
            raise ProblemError(401, "a token is needed", "Authorization: Bearer TOKEN")

    def _knows(self, headers: Headers) -> bool:
        said = [headers.get("authorization", "").removeprefix("Bearer ")]
        said += [p.removeprefix(TOKEN_PROTOCOL) for p in protocols(headers)]
        return any(hmac.compare_digest(one.encode(), self._access.token.encode()) for one in said)

    def _limited(self, receive: Receive) -> Receive:
        """Count a body that does not say how long it is."""
        left = self._access.max_body_bytes

        async def limited() -> Message:
            nonlocal left
            message = await receive()
            left -= len(message.get("body", b""))
            if left < 0:
                raise ProblemError(413, f"the limit is {self._access.max_body_bytes} bytes")
            return message

        return limited

    async def _refuse(
        self, problem: ProblemError, scope: Scope, receive: Receive, send: Send
    ) -> None:
        if scope["type"] == "websocket":
            await receive()
            await send({"type": "websocket.close", "code": 1008, "reason": problem.detail[:100]})
        else:
            await problem.response()(scope, receive, _with_headers(send))


def hostname(host: str) -> str:
    """Return the name in a Host header, without the port."""
    return host if host.endswith("]") else host.rpartition(":")[0] or host


def protocols(headers: Headers) -> list[str]:
    """Return what a WebSocket offers as protocols, the one place where a page can say a token."""
    return [one.strip() for one in headers.get("sec-websocket-protocol", "").split(",")]


def int_or(text: str | None, default: int) -> int:
    """Return the number in ``text``."""
    return int(text) if text is not None and text.isascii() and text.isdigit() else default


def _is_open(path: str) -> bool:
    return path == "/" or any(path.startswith(one) for one in OPEN_PATHS[1:])


def _with_headers(send: Send) -> Send:
    async def sending(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers: Iterable[tuple[bytes, bytes]] = message.get("headers", ())
            message = {**message, "headers": [*headers, *SECURITY_HEADERS]}
        await send(message)

    return sending
