"""Zenoh, and the only file that knows it: the bus of a node, sessions of clients and routers.

Zenoh's threads never decode, compute or wait here: a sample goes into the bounded inbox, a query
into the bounded pool, and every query is finished with a reply, an error or nothing.
"""

import json
import logging
import threading
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import zenoh

from sceneq_nodes._bus import Context, Handler, QueryError, Received, Reply
from sceneq_nodes._counters import Counters
from sceneq_nodes._credentials import Credentials, given_credentials
from sceneq_nodes._foreign import ForeignSession
from sceneq_nodes._inbox import Inbox, Raw
from sceneq_nodes._liveness import live_nodes
from sceneq_nodes._logs import query_attachment
from sceneq_nodes._queries import QueryPool, error_from_bytes, format_parameters
from sceneq_nodes._served import Served
from sceneq_nodes._session import client_config, router_config
from sceneq_nodes._wire import from_bytes, to_bytes
from sceneq_schemas.errors import DecodeError
from sceneq_schemas.topics import LIVE, Delivery, Topic

log = logging.getLogger(__name__)


PRIORITY = {
    Delivery.LATEST: zenoh.Priority.DATA_LOW,
    Delivery.STATE: zenoh.Priority.DATA_HIGH,
    Delivery.QUERY: zenoh.Priority.INTERACTIVE_HIGH,
    Delivery.BULK: zenoh.Priority.DATA_LOW,
    Delivery.BACKGROUND: zenoh.Priority.BACKGROUND,
}


class ZenohBus:
    """The ``Bus`` of one node, on a session of its own."""

    def __init__(self, context: Context, endpoint: str, counters: Counters) -> None:
        """Connect to the router at ``endpoint``; waits for it as long as it takes."""
        self.context = context
        self._session = open_session(endpoint)
        self.foreign = ForeignSession(self._session)
        self._counters = counters
        self._inbox = Inbox()
        self._pool = QueryPool()
        self._publishers: dict[str, zenoh.Publisher] = {}
        self._publishing = threading.Lock()
        self._served: list[Served] = []
        self._announced = False
        self._declared: list[Any] = []

    def publish(self, topic: Topic, message: Any, **ids: str) -> None:
        """Send ``message``, dropped rather than waited for when the link is full."""
        data = to_bytes(topic, message)
        self._publisher(topic, topic.key(**ids)).put(data)
        self._counters.topic(topic.name, "out")

    def subscribe(self, topic: Topic, *, depth: int, **ids: str) -> None:
        """Deliver the topic to ``take``; beyond ``depth`` the oldest is dropped and counted."""
        selector = topic.selector(**ids)
        self._inbox.open(selector, depth)
        enqueue = partial(self._enqueue, topic, selector)
        self._declared.append(self._session.declare_subscriber(selector, enqueue))

    def serve(self, topic: Topic, handler: Handler, **ids: str) -> None:
        """Answer queries on the topic's key from the pool, from ``announce`` on."""
        key = topic.key(**ids)
        self._served.append(Served(topic, key, ids, handler, self._pool, self._counters))
        if self._announced:
            self._declare_served()

    def ask(
        self,
        topic: Topic,
        *,
        parameters: Mapping[str, str] | None = None,
        payload: bytes = b"",
        timeout_s: float = 2.0,
        **ids: str,
    ) -> list[Reply]:
        """Return the replies; raise ``QueryError`` when there are only errors."""
        selector = topic.key(**ids)
        if parameters:
            selector += "?" + format_parameters(parameters)
        replies, errors = get(self._session, selector, payload, "", timeout_s, topic.delivery)
        if errors and not replies:
            raise errors[0]
        for _, reply in replies:
            if len(reply.payload) > topic.max_bytes:
                raise QueryError("too_large", f"{topic.name}: {len(reply.payload)} bytes")
        return [reply for _, reply in replies]

    def alive(self) -> frozenset[str]:
        """Return the names of the nodes that hold a liveliness token."""
        return frozenset(ids["node"] for ids in live_nodes(self._session))

    def count(self, name: str, by: int = 1) -> None:
        """Add to a counter that health and metrics publish."""
        self._counters.count(name, by)

    def report(self, **values: float | int | str) -> None:
        """Set values that the next health message carries."""
        self._counters.report(**values)

    def announce(self, instance: str) -> None:
        """Answer queries and hold the liveliness token; a half-open node does neither."""
        self._announced = True
        self._declare_served()
        key = LIVE.key(node=self.context.node, id=instance)
        self._declared.append(self._session.liveliness().declare_token(key))

    def take(self, timeout_s: float) -> Received | None:
        """Return the next message that decodes, or ``None`` after ``timeout_s``."""
        raw = self._inbox.take(timeout_s)
        while raw is not None:
            if (received := self._decode(raw)) is not None:
                return received
            raw = self._inbox.take(0.0)
        return None

    def depths(self) -> dict[str, int]:
        """Return how many messages wait per key expression."""
        return self._inbox.depths()

    def close(self) -> None:
        """Leave the network."""
        close(self._session)

    def _declare_served(self) -> None:
        for served in self._served:
            self._declared.append(self._session.declare_queryable(served.key, served.accept))
        self._served.clear()

    def _publisher(self, topic: Topic, key: str) -> zenoh.Publisher:
        with self._publishing:
            if key not in self._publishers:
                self._publishers[key] = self._session.declare_publisher(
                    key,
                    encoding=topic.encoding,
                    congestion_control=zenoh.CongestionControl.DROP,
                    priority=PRIORITY[topic.delivery],
                    express=topic.delivery is Delivery.QUERY,
                )
            return self._publishers[key]

    def _enqueue(self, topic: Topic, selector: str, sample: zenoh.Sample) -> None:
        """On zenoh's thread: look at the envelope only, then hand over."""
        key, encoding, size = str(sample.key_expr), str(sample.encoding), len(sample.payload)
        if encoding != topic.encoding:
            self._undecodable(topic, key, f"encoding {encoding!r:.80}")
        elif size > topic.max_bytes:
            self._undecodable(topic, key, f"{size} bytes, the limit is {topic.max_bytes}")
        elif not self._inbox.put(selector, Raw(topic, key, sample.payload.to_bytes())):
            self._counters.topic(topic.name, "dropped")

    def _decode(self, raw: Raw) -> Received | None:
        try:
            ids = raw.topic.ids(raw.key)
            if ids is None:
                raise DecodeError("an id outside [a-z0-9_-]+ in the key")
            message = from_bytes(raw.topic, raw.data)
        except DecodeError as error:
            self._undecodable(raw.topic, raw.key, str(error))
            return None
        self._counters.topic(raw.topic.name, "in")
        return Received(raw.topic, raw.key, ids, message)

    def _undecodable(self, topic: Topic, key: str, reason: str) -> None:
        """Count, and log the 1st, 2nd, 4th, 8th, ... so that a flood stays readable."""
        total = self._counters.topic(topic.name, "undecodable")
        if total & (total - 1) == 0:
            log.warning("undecodable no. %d on %s: %s", total, key, reason)


def get(
    session: zenoh.Session,
    selector: str,
    payload: bytes,
    encoding: str,
    timeout_s: float,
    delivery: Delivery = Delivery.QUERY,
) -> tuple[list[tuple[str, Reply]], list[QueryError]]:
    """Return the (key, reply) pairs and the errors that a query gets, as urgent as it is."""
    replies, errors = [], []
    for result in session.get(
        selector,
        payload=payload or None,
        encoding=encoding or None,
        timeout=timeout_s,
        consolidation=zenoh.ConsolidationMode.NONE,
        priority=PRIORITY[delivery],
        express=delivery is Delivery.QUERY,
        attachment=query_attachment(),
    ):
        if result.ok is not None:
            reply = Reply(result.ok.payload.to_bytes(), str(result.ok.encoding))
            replies.append((str(result.ok.key_expr), reply))
        elif result.err is not None:
            errors.append(error_from_bytes(result.err.payload.to_bytes()))
    return replies, errors


def open_session(
    endpoint: str, timeout_s: float | None = None, credentials: Credentials | None = None
) -> zenoh.Session:
    """Return a client session; without ``credentials``, those in the environment are shown.

    Raises ``ConnectionError`` when no router answers within ``timeout_s`` (``None`` = wait for
    ever), ``ValueError`` for unusable credentials.
    """
    config = client_config(endpoint, timeout_s, credentials or given_credentials())
    return _open(config, f"no router at {endpoint}: start one with 'sceneq up'")


def open_router(
    listen: Sequence[str], connect: Sequence[str], credentials: Credentials | None = None
) -> zenoh.Session:
    """Return a router session, which enforces the access rules among its ``credentials``.

    Raises ``ConnectionError`` when it cannot listen, ``ValueError`` for unusable credentials.
    """
    config = router_config(listen, connect, credentials)
    return _open(config, f"cannot listen on {', '.join(listen)}: {{reason}}")


def close(session: zenoh.Session) -> None:
    """Leave the network; zenoh's threads would keep the process alive without it."""
    session.close()  # type: ignore[no-untyped-call]


def _open(config: Mapping[str, Any], trouble: str) -> zenoh.Session:
    zenoh.try_init_log_from_env()  # type: ignore[no-untyped-call]  # on request: it fills stdout
    try:
        return zenoh.open(zenoh.Config.from_json5(json.dumps(config)))
    except zenoh.ZError as error:
        reason = "the port is in use" if "in use" in str(error) else str(error)
        raise ConnectionError(trouble.format(reason=reason)) from error
