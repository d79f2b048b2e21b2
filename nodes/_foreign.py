"""Zenoh keys of other programs, on the session of a node's bus."""

from collections.abc import Callable
from threading import Lock
from typing import Any

import zenoh

from sceneq_nodes._bus import ForeignSample


class ForeignSession:
    """``ForeignKeys`` on one session; what is declared lives as long as the session."""

    def __init__(self, session: zenoh.Session) -> None:
        self.session_id = str(session.zid())
        self._session = session
        self._declared: list[Any] = []
        self._publishers: dict[str, zenoh.Publisher] = {}
        self._publishing = Lock()

    def listen(
        self, selector: str, take: Callable[[ForeignSample], None], *, latched: bool = False
    ) -> None:
        """Call ``take`` with every sample; latched data come from the caches of their writers."""

        def enqueue(sample: zenoh.Sample) -> None:
            attachment = b"" if sample.attachment is None else sample.attachment.to_bytes()
            take(ForeignSample(str(sample.key_expr), sample.payload.to_bytes(), attachment))

        if latched:
            history = zenoh.ext.HistoryConfig(detect_late_publishers=True)
            subscriber: Any = zenoh.ext.declare_advanced_subscriber(
                self._session, selector, enqueue, history=history
            )
        else:
            subscriber = self._session.declare_subscriber(selector, enqueue)
        self._declared.append(subscriber)

    def publish(self, key: str, payload: bytes, attachment: bytes) -> None:
        """Send bytes without an encoding, as the writers of these keys do."""
        with self._publishing:
            if key not in self._publishers:
                drop = zenoh.CongestionControl.DROP
                self._publishers[key] = self._session.declare_publisher(
                    key, congestion_control=drop
                )
        self._publishers[key].put(payload, attachment=attachment or None)

    def hold(self, key: str) -> None:
        """Hold a liveliness token."""
        self._declared.append(self._session.liveliness().declare_token(key))
