"""A bus inside one process: the same nodes in lockstep, every message delivered, nothing encoded.

Messages are delivered in the order in which they were published, so a run is a function of its
input alone.
"""

from collections import Counter, deque
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from sceneq_nodes._bus import Context, Handler, Node, Received, Reply, Request
from sceneq_schemas.topics import Topic


@dataclass(frozen=True, slots=True)
class _Subscription:
    node: str
    topic: Topic
    ids: Mapping[str, str]


class LocalHub:
    """The nodes, who listens to what, who answers what, and the messages under way."""

    def __init__(self) -> None:
        self.nodes: dict[str, Node] = {}
        self.counters: Counter[str] = Counter()
        self.reported: dict[str, dict[str, float | int | str]] = {}
        self._subscriptions: list[_Subscription] = []
        self._handlers: dict[str, tuple[Topic, Handler, Mapping[str, str]]] = {}
        self._under_way: deque[tuple[str, Received]] = deque()

    def add(self, node: Node, context: Context) -> None:
        """Open a node on this hub; raise ``ValueError`` when it cannot."""
        self.nodes[context.node] = node
        self.reported[context.node] = {}
        node.open(LocalBus(self, context))

    def idle(self, name: str) -> None:
        """Let one node do what it does without input, then deliver all that follows."""
        self.nodes[name].step(None)
        while self._under_way:
            receiver, received = self._under_way.popleft()
            self.nodes[receiver].step(received)

    def close(self) -> None:
        """Close every node."""
        for node in self.nodes.values():
            node.close()

    def publish(self, received: Received) -> None:
        """Queue a message for everyone who listens to it."""
        for wanted in self._subscriptions:
            if wanted.topic is received.topic and wanted.ids.items() <= received.ids.items():
                self._under_way.append((wanted.node, received))

    def subscribe(self, node: str, topic: Topic, ids: Mapping[str, str]) -> None:
        """Remember that ``node`` listens."""
        self._subscriptions.append(_Subscription(node, topic, ids))

    def serve(self, topic: Topic, handler: Handler, ids: Mapping[str, str]) -> None:
        """Remember who answers a key."""
        self._handlers[topic.key(**ids)] = (topic, handler, ids)

    def ask(self, key: str, parameters: Mapping[str, str], payload: bytes = b"") -> list[Reply]:
        """Return what the one who answers ``key`` says; raise its ``QueryError``."""
        if key not in self._handlers:
            return []
        topic, handler, ids = self._handlers[key]
        reply = handler(Request(topic, key, ids, False, parameters, payload, "application/json"))
        return [] if reply is None else [reply]


class LocalBus:
    """One node's side of a ``LocalHub``."""

    def __init__(self, hub: LocalHub, context: Context) -> None:
        self.context = context
        self._hub = hub

    def publish(self, topic: Topic, message: Any, **ids: str) -> None:
        """Queue ``message`` as it is."""
        self._hub.publish(Received(topic, topic.key(**ids), ids, message))

    def subscribe(self, topic: Topic, *, depth: int, **ids: str) -> None:
        """Listen; nothing is ever dropped here, so ``depth`` does not matter."""
        self._hub.subscribe(self.context.node, topic, ids)

    def serve(self, topic: Topic, handler: Handler, **ids: str) -> None:
        """Answer a key."""
        self._hub.serve(topic, handler, ids)

    def ask(
        self,
        topic: Topic,
        *,
        parameters: Mapping[str, str] | None = None,
        payload: bytes = b"",
        timeout_s: float = 2.0,
        **ids: str,
    ) -> list[Reply]:
        """Call the handler of the key."""
        return self._hub.ask(topic.key(**ids), parameters or {}, payload)

    def alive(self) -> frozenset[str]:
        """Return the nodes on the hub."""
        return frozenset(self._hub.nodes)

    def count(self, name: str, by: int = 1) -> None:
        """Add to a counter of all nodes together."""
        self._hub.counters[name] += by

    def report(self, **values: float | int | str) -> None:
        """Keep the newest values of this node."""
        self._hub.reported[self.context.node].update(values)
