"""The bus as a command-line tool sees it: ask, listen, publish, see who is there."""

from collections.abc import Callable
from typing import Any

from sceneq_nodes._bus import QueryError, Reply
from sceneq_nodes._credentials import Credentials
from sceneq_nodes._liveness import live_nodes
from sceneq_nodes._runtime import close, get, open_session
from sceneq_schemas.topics import Delivery


class Client:
    """A session of the router at ``endpoint``, to be used in a ``with`` block."""

    def __init__(
        self, endpoint: str, timeout_s: float = 2.0, credentials: Credentials | None = None
    ) -> None:
        """Connect, by default with the credentials in the environment.

        Raises:
            ConnectionError: no router answers within ``timeout_s``.
            ValueError: the credentials cannot be used.
        """
        self._session = open_session(endpoint, timeout_s, credentials)
        self._declared: list[Any] = []

    def __enter__(self) -> "Client":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Leave the network."""
        close(self._session)

    def get(
        self, selector: str, payload: bytes = b"", encoding: str = "", timeout_s: float = 10.0
    ) -> tuple[list[tuple[str, Reply]], list[QueryError]]:
        """Return the (key, reply) pairs and the errors; both empty = nobody answers this key."""
        delivery = Delivery.BULK if "/@" in selector else Delivery.QUERY
        return get(self._session, selector, payload, encoding, timeout_s, delivery)

    def subscribe(
        self, selector: str, callback: Callable[[str, str, bytes], None]
    ) -> Callable[[], None]:
        """Call ``callback(key, encoding, payload)`` on a thread for each message; be quick.

        What is returned ends it.
        """

        def forward(sample: Any) -> None:
            callback(str(sample.key_expr), str(sample.encoding), sample.payload.to_bytes())

        declared = self._session.declare_subscriber(selector, forward)
        self._declared.append(declared)
        return declared.undeclare

    def publish(self, key: str, payload: bytes, encoding: str) -> None:
        """Send one message."""
        self._session.put(key, payload, encoding=encoding)

    def alive(self) -> list[dict[str, str]]:
        """Return ``{"node", "id"}`` of every liveliness token."""
        return live_nodes(self._session)
