"""The bus in memory, so that node tests need no network, no threads and no waiting.

    bus = FakeBus()                                   # or FakeBus(Context(...))
    node = Segmentation(Segmentation.Params(), bus.context)
    node.open(bus)
    bus.deliver(node, FRAME, frame)                   # -> node.step(Received(...))
    topic, ids, masks = bus.published[-1]
    reply = bus.query(QUERY_STATUS, parameters={"q": "mug"})   # -> the handler's Reply | None

Every message goes through the real codec, in and out. Ids that are not given are taken from the
context (scene, robot, sensor, node). Several nodes together: ``FakeHub``.
"""

from collections import Counter, deque
from collections.abc import Callable, Mapping
from string import Formatter
from typing import Any, NamedTuple

from sceneq_nodes._bus import Context, ForeignSample, Handler, Node, Received, Reply, Request
from sceneq_nodes._wire import from_bytes, to_bytes
from sceneq_schemas.topics import Topic

CONTEXT = Context(node="test", scene="room", robot="r1", sensor="cam")

Answer = Callable[[Request], Reply | list[Reply] | None]


class Published(NamedTuple):
    """One message that left the node, as a reader would decode it."""

    topic: Topic
    ids: dict[str, str]
    message: Any


class FakeBus:
    """The ``Bus`` protocol with everything in lists; one bus per node."""

    def __init__(self, context: Context = CONTEXT, hub: "FakeHub | None" = None) -> None:
        self.context = context
        self.published: list[Published] = []
        self.subscriptions: dict[str, int] = {}
        self.alive_nodes: set[str] = {context.node}
        self.counters: Counter[str] = Counter()
        self.reported: dict[str, float | int | str] = {}
        self.asked: list[Request] = []
        self._handlers: dict[str, Handler] = {}
        self._answers: dict[str, Answer] = {}
        self._hub = hub
        self.foreign = FakeForeign()

    # what the node calls

    def publish(self, topic: Topic, message: Any, **ids: str) -> None:
        key = topic.key(**ids)
        sent = Published(topic, ids, from_bytes(topic, to_bytes(topic, message)))
        self.published.append(sent)
        if self._hub is not None:
            self._hub.route(key, sent)

    def subscribe(self, topic: Topic, *, depth: int, **ids: str) -> None:
        assert depth >= 1, f"{topic.name}: depth {depth}"
        self.subscriptions[topic.selector(**ids)] = depth

    def serve(self, topic: Topic, handler: Handler, **ids: str) -> None:
        self._handlers[topic.key(**ids)] = handler

    def ask(
        self,
        topic: Topic,
        *,
        parameters: Mapping[str, str] | None = None,
        payload: bytes = b"",
        timeout_s: float = 2.0,
        **ids: str,
    ) -> list[Reply]:
        request = _request(topic, ids, parameters, payload)
        self.asked.append(request)
        answer = self._answers.get(request.key) or self._served(request.key)
        reply = answer(request) if answer else None
        if reply is None:
            return []
        return reply if isinstance(reply, list) else [reply]

    def alive(self) -> frozenset[str]:
        return frozenset(self.alive_nodes)

    def count(self, name: str, by: int = 1) -> None:
        self.counters[name] += by

    def report(self, **values: float | int | str) -> None:
        self.reported |= values

    # what the test calls

    def deliver(self, node: Node, topic: Topic, message: Any, **ids: str) -> None:
        """Give ``message`` to ``node.step``, decoded; the node must have subscribed to it."""
        ids = self._filled(topic, ids)
        key = topic.key(**ids)
        assert self.subscribes(topic, ids), f"nothing subscribed to {key}"
        node.step(Received(topic, key, ids, from_bytes(topic, to_bytes(topic, message))))

    def query(
        self,
        topic: Topic,
        *,
        parameters: Mapping[str, str] | None = None,
        payload: bytes = b"",
        encoding: str = "",
        wildcard: bool = False,
        **ids: str,
    ) -> Reply | None:
        """Return what the node's handler answers; a ``QueryError`` comes out as it is."""
        ids = self._filled(topic, ids)
        request = _request(topic, ids, parameters, payload, encoding, wildcard)
        return self._handlers[request.key](request)

    def answer(self, topic: Topic, answer: Answer, **ids: str) -> None:
        """Script what ``ask`` gets: ``answer(request)`` -> Reply, list of them, None, or raises."""
        self._answers[topic.key(**self._filled(topic, ids))] = answer

    def sent(self, topic: Topic) -> list[Any]:
        """Return the published messages of one topic, in order."""
        return [message for sent_topic, _, message in self.published if sent_topic is topic]

    def subscribes(self, topic: Topic, ids: Mapping[str, str]) -> bool:
        """Tell whether a message of ``topic`` with ``ids`` would reach the node."""
        return any(
            _covers(selector, topic.key(**ids)) and topic.ids(topic.key(**ids)) is not None
            for selector in self.subscriptions
        )

    def handler(self, key: str) -> Handler | None:
        """Return the handler that the node serves on ``key``."""
        return self._handlers.get(key)

    def _served(self, key: str) -> Handler | None:
        return self._hub.handler(key) if self._hub else self._handlers.get(key)

    def _filled(self, topic: Topic, ids: Mapping[str, str]) -> dict[str, str]:
        names = [name for _, name, _, _ in Formatter().parse(topic.pattern) if name]
        known = {n: getattr(self.context, n) for n in names if hasattr(self.context, n)}
        return {n: v for n, v in (known | dict(ids)).items() if n in names}


class FakeForeign:
    """Keys of others in lists: ``arrive`` is what the network would bring."""

    session_id = "0123456789abcdef0123456789abcdef"

    def __init__(self) -> None:
        self.listening: dict[str, tuple[Callable[[ForeignSample], None], bool]] = {}
        self.published: list[ForeignSample] = []
        self.held: list[str] = []

    def listen(
        self, selector: str, take: Callable[[ForeignSample], None], *, latched: bool = False
    ) -> None:
        self.listening[selector] = (take, latched)

    def publish(self, key: str, payload: bytes, attachment: bytes) -> None:
        self.published.append(ForeignSample(key, payload, attachment))

    def hold(self, key: str) -> None:
        self.held.append(key)

    def arrive(self, key: str, payload: bytes, attachment: bytes = b"") -> int:
        """Hand a sample to whoever listens; return how many did."""
        takers = [take for selector, (take, _) in self.listening.items() if _covers(selector, key)]
        for take in takers:
            take(ForeignSample(key, payload, attachment))
        return len(takers)


class FakeHub:
    """Several nodes on one bus: what one publishes is stepped through the others, in order.

    hub = FakeHub()
    mapping = hub.add(Mapping, Mapping.Params(), replace(CONTEXT, node="mapping"))
    views = hub.add(Views, Views.Params(), replace(CONTEXT, node="views"))
    hub.publish(FRAME, frame)
    hub.run()                                         # until nothing is left to deliver
    hub.bus(views).published
    """

    def __init__(self) -> None:
        self._members: list[tuple[Node, FakeBus]] = []
        self._queue: deque[tuple[Node, Received]] = deque()

    def add(self, node_class: Any, params: Any, context: Context) -> Any:
        """Open a node and return it."""
        bus = FakeBus(context, hub=self)
        node = node_class(params, context)
        self._members.append((node, bus))
        for _, member in self._members:
            member.alive_nodes |= {m.context.node for _, m in self._members}
        node.open(bus)
        return node

    def bus(self, node: Node) -> FakeBus:
        """Return the bus that ``node`` was opened with."""
        return next(bus for member, bus in self._members if member is node)

    def publish(self, topic: Topic, message: Any, **ids: str) -> None:
        """Publish as somebody outside, with ids taken from ``CONTEXT`` when not given."""
        outside = FakeBus(hub=self)
        outside.publish(topic, message, **outside._filled(topic, ids))

    def run(self) -> int:
        """Step nodes until every message is delivered; return how many were."""
        steps = 0
        while self.step():
            steps += 1
        return steps

    def step(self) -> bool:
        """Deliver the oldest message; return whether there was one."""
        if not self._queue:
            return False
        node, received = self._queue.popleft()
        node.step(received)
        return True

    def route(self, key: str, sent: Published) -> None:
        """Queue a published message for every node that subscribed to it."""
        received = Received(sent.topic, key, sent.ids, sent.message)
        for node, bus in self._members:
            if bus.subscribes(sent.topic, sent.ids):
                self._queue.append((node, received))

    def handler(self, key: str) -> Handler | None:
        """Return the first handler that any node serves on ``key``."""
        return next((h for _, bus in self._members if (h := bus.handler(key))), None)


def _request(
    topic: Topic,
    ids: Mapping[str, str],
    parameters: Mapping[str, str] | None,
    payload: bytes,
    encoding: str = "",
    wildcard: bool = False,
) -> Request:
    key = topic.key(**ids)
    return Request(topic, key, ids, wildcard, dict(parameters or {}), payload, encoding)


def _covers(selector: str, key: str) -> bool:
    wanted, got = selector.split("/"), key.split("/")
    return len(wanted) == len(got) and all(w in ("*", g) for w, g in zip(wanted, got, strict=True))
