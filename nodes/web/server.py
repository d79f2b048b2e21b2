"""The web server beside the node: uvicorn on a thread of its own."""

import errno
import socket
import ssl
import threading
from dataclasses import dataclass
from typing import Any

import uvicorn
from starlette.types import ASGIApp

STOP_S = 5.0
NEXT_PORTS = 19


@dataclass(frozen=True, slots=True)
class TlsParams:
    """Files in PEM: the server's ``certificate`` and ``key``; with ``client_ca`` clients must
    show a certificate that it signed."""

    certificate: str
    key: str
    client_ca: str = ""


class WebServer:
    """Serves ``app`` until it is closed."""

    def __init__(
        self, app: ASGIApp, host: str, port: int, max_connections: int, tls: TlsParams | None
    ) -> None:
        self._host, self._port = host, port
        self._config = uvicorn.Config(
            app,
            limit_concurrency=max_connections,
            timeout_keep_alive=5,
            h11_max_incomplete_event_size=16 * 1024,
            ws_max_size=1024,
            log_config=None,
            access_log=False,
            server_header=False,
            lifespan="off",
            **_tls(tls),
        )
        self._server = uvicorn.Server(self._config)
        self._thread: threading.Thread | None = None

    def open(self) -> int:
        """Listen and return the port.

        Raises:
            ValueError: none can be had, or the files of ``tls`` cannot be used.
        """
        try:
            self._config.load()
        except (OSError, ValueError) as error:  # ssl.SSLError is an OSError
            raise ValueError(f"tls: {error}") from error
        listening = self._listening()
        self._thread = threading.Thread(
            target=self._server.run, args=([listening],), name="web", daemon=True
        )
        self._thread.start()
        return int(listening.getsockname()[1])

    def _listening(self) -> socket.socket:
        """Return a socket on the port, or on one of the next where another graph has it."""
        family = socket.AF_INET6 if ":" in self._host else socket.AF_INET
        for port in range(self._port, min(self._port + NEXT_PORTS, 65535) + 1):
            listening = socket.socket(family, socket.SOCK_STREAM)
            listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                listening.bind((self._host, port))
                listening.listen()
            except OSError as error:
                listening.close()
                trouble = error
                if error.errno != errno.EADDRINUSE:
                    break
            else:
                return listening
        where = f"{self._host}:{self._port}"
        raise ValueError(f"port: cannot listen on {where}: {trouble.strerror}") from trouble

    def close(self) -> None:
        """Stop serving; requests under way get a moment to end."""
        if self._thread is not None:
            self._server.should_exit = True
            self._thread.join(STOP_S)


def _tls(tls: TlsParams | None) -> dict[str, Any]:
    if tls is None:
        return {}
    clients = {"ssl_ca_certs": tls.client_ca, "ssl_cert_reqs": ssl.CERT_REQUIRED}
    return {
        "ssl_certfile": tls.certificate,
        "ssl_keyfile": tls.key,
        **(clients if tls.client_ca else {}),
    }
