"""A chat server in this process that does what a test wrote down, the nasty things included."""

import json
import socket
import struct
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

Act = Callable[["_Handler"], None]


def says(
    content: str | None, status: int = 200, usage: dict[str, int] | None = None, **headers: str
) -> Act:
    """A completion with this text; ``usage`` is what the server counts."""
    message = {"role": "assistant", "content": content}
    counted = {"prompt_tokens": 900, "completion_tokens": 8} if usage is None else usage
    body = {"choices": [{"index": 0, "message": message}], "usage": counted}
    return sends(json.dumps(body).encode(), status, **headers)


def chooses(key: str) -> Act:
    return says(json.dumps({"choice": key}))


def chooses_first(handler: "_Handler") -> None:
    """Takes the first of the choices that the request enumerates."""
    form = handler.chat.requests[-1]["response_format"]["json_schema"]["schema"]
    chooses(form["properties"]["choice"]["enum"][0])(handler)


def sends(body: bytes, status: int = 200, **headers: str) -> Act:
    """Exactly these bytes; ``retry_after="7"`` becomes the header ``retry-after``."""

    def act(handler: "_Handler") -> None:
        handler.send_response(status)
        handler.send_header("Content-Length", str(len(body)))
        for name, value in headers.items():
            handler.send_header(name.replace("_", "-"), value)
        handler.end_headers()
        handler.wfile.write(body)

    return act


def waits_then(act: Act) -> Act:
    """Answers only once the test is over (or has called ``ChatServer.release``)."""

    def later(handler: "_Handler") -> None:
        handler.chat.released.wait(60)
        act(handler)

    return later


def drips(handler: "_Handler") -> None:
    """Sends one byte after the other, for as long as somebody reads."""
    handler.send_response(200)
    handler.send_header("Content-Length", "100000")
    handler.end_headers()
    while not handler.chat.released.wait(0.02):
        handler.wfile.write(b" ")
        handler.wfile.flush()


def cuts(handler: "_Handler") -> None:
    """Ends the connection in the middle of the reply."""
    handler.send_response(200)
    handler.send_header("Content-Length", "1000")
    handler.end_headers()
    handler.wfile.write(b'{"choices": [')
    handler.close_connection = True


def resets(handler: "_Handler") -> None:
    """Ends the connection before any reply."""
    handler.connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    handler.connection.close()
    handler.close_connection = True


@dataclass
class ChatServer:
    """``script`` holds what to do with each request; the last act is repeated."""

    script: list[Act]
    url: str = ""
    requests: list[dict[str, Any]] = field(default_factory=list)
    headers: list[dict[str, str]] = field(default_factory=list)
    paths: list[str] = field(default_factory=list)
    released: threading.Event = field(default_factory=threading.Event)
    lock: threading.Lock = field(default_factory=threading.Lock)

    def next_act(self) -> Act:
        return self.script.pop(0) if len(self.script) > 1 else self.script[0]

    def asked(self, number: int = -1) -> str:
        """Return the text of a request."""
        parts = self.requests[number]["messages"][-1]["content"]
        return next(part["text"] for part in parts if part["type"] == "text")

    def images(self, number: int = -1) -> list[str]:
        """Return the data URLs of a request."""
        parts = self.requests[number]["messages"][-1]["content"]
        return [part["image_url"]["url"] for part in parts if part["type"] == "image_url"]


class _Handler(BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    chat: ChatServer

    def do_POST(self) -> None:
        body = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
        with self.chat.lock:
            self.chat.requests.append(body)
            self.chat.headers.append(dict(self.headers.items()))
            self.chat.paths.append(self.path)
            act = self.chat.next_act()
        try:
            act(self)
        except OSError:  # the client has gone, which is what some tests are about
            self.close_connection = True

    def log_message(self, format: str, *args: Any) -> None:
        """Keep quiet."""

    def handle(self) -> None:
        try:
            super().handle()
        except OSError:
            self.close_connection = True


class _Server(ThreadingHTTPServer):
    daemon_threads = True
    block_on_close = False


@contextmanager
def chat_server(*script: Act) -> Iterator[ChatServer]:
    """Run a server on a free port of this machine until the block ends."""
    chat = ChatServer(list(script))
    handler = type("Handler", (_Handler,), {"chat": chat})
    server = _Server(("127.0.0.1", 0), handler)
    chat.url = f"http://127.0.0.1:{server.server_address[1]}/v1"
    thread = threading.Thread(target=server.serve_forever, args=(0.01,), daemon=True)
    thread.start()
    try:
        yield chat
    finally:
        chat.released.set()
        server.shutdown()
        server.server_close()
        thread.join()
