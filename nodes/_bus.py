"""What a node sees of the network: a small protocol, so that tests can run nodes without one."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar, Protocol

from sceneq_schemas.topics import Topic


@dataclass(frozen=True, slots=True)
class Context:
    """Where a node runs: its name in the graph and the scene, robot and sensor it works for.

    ``store``: the folder of this scene's durable files, private to its owner; ``None`` = nothing
    outlives the process.
    """

    node: str
    scene: str
    robot: str
    sensor: str
    store: Path | None = None


@dataclass(frozen=True, slots=True)
class Received:
    """A decoded message from the inbox."""

    topic: Topic
    key: str
    ids: Mapping[str, str]
    message: Any


@dataclass(frozen=True, slots=True)
class Request:
    """A query that reached one of this node's queryables.

    ``wildcard`` is true when the client's key expression was not this queryable's exact key.
    """

    topic: Topic
    key: str
    ids: Mapping[str, str]
    wildcard: bool
    parameters: Mapping[str, str] = field(default_factory=dict)
    payload: bytes = b""
    encoding: str = ""


@dataclass(frozen=True, slots=True)
class Reply:
    """The answer to a request."""

    payload: bytes
    encoding: str


class QueryError(Exception):
    """An answer that says what went wrong; travels as ``reply_err`` {code, message, hint}."""

    def __init__(
        self, code: str, message: str, hint: str = "", retry_ms: int | None = None
    ) -> None:
        super().__init__(f"{code}: {message}")
        self.code = code
        self.message = message
        self.hint = hint
        self.retry_ms = retry_ms


Handler = Callable[[Request], Reply | None]
"""Answers one request on a pool thread; ``None`` = this queryable has nothing to say."""


@dataclass(frozen=True, slots=True)
class ForeignSample:
    """Data on a key of somebody else, as it came; ``attachment`` is empty when there is none."""

    key: str
    payload: bytes
    attachment: bytes


class ForeignKeys(Protocol):
    """Keys that are not in our table, such as those of ROS 2: raw bytes in and out."""

    session_id: str

    def listen(
        self, selector: str, take: Callable[[ForeignSample], None], *, latched: bool = False
    ) -> None:
        """Call ``take`` with what comes on ``selector``, on a thread of the network: only enqueue.

        ``latched``: also with the last that was said before, as far as its writer keeps it.
        """

    def publish(self, key: str, payload: bytes, attachment: bytes) -> None:
        """Send bytes, dropped rather than waited for when the link is full."""

    def hold(self, key: str) -> None:
        """Hold a liveliness token for as long as the node lives."""


class Bus(Protocol):
    """Publish, subscribe, serve and ask."""

    context: Context

    def publish(self, topic: Topic, message: Any, **ids: str) -> None:
        """Send ``message`` (a schema dataclass, or a JSON-able dict when the topic has no type)."""

    def subscribe(self, topic: Topic, *, depth: int, **ids: str) -> None:
        """Deliver this topic to the node's ``step``; beyond ``depth`` the oldest is dropped."""

    def serve(self, topic: Topic, handler: Handler, **ids: str) -> None:
        """Answer queries on this topic's key from a bounded pool, once ``open`` has returned."""

    def ask(
        self,
        topic: Topic,
        *,
        parameters: Mapping[str, str] | None = None,
        payload: bytes = b"",
        timeout_s: float = 2.0,
        **ids: str,
    ) -> list[Reply]:
        """Return the replies ([] = nobody answered); raise ``QueryError`` on an error reply."""

    def alive(self) -> frozenset[str]:
        """Return the names of the nodes that hold a liveliness token."""

    def count(self, name: str, by: int = 1) -> None:
        """Add to a counter that health and metrics publish, such as ``frames_skipped``."""

    def report(self, **values: float | int | str) -> None:
        """Set values that the next health message carries, such as ``instances=12``."""


def foreign_keys(bus: Bus) -> ForeignKeys:
    """Return access to keys that are not ours.

    Raises:
        ValueError: a bus without a network, as inside `sceneq map`.
    """
    keys: ForeignKeys | None = getattr(bus, "foreign", None)
    if keys is None:
        raise ValueError("this needs a network: run the graph with 'sceneq up'")
    return keys


class Node(Protocol):
    """A process of the graph: no work in ``__init__``, everything heavy in ``open``."""

    Params: ClassVar[type]
    idle_s: ClassVar[float]

    def __init__(self, params: Any, context: Context) -> None: ...

    def open(self, bus: Bus) -> None:
        """Load models, declare subscriptions and queryables; raise ``ValueError`` on bad input."""

    def step(self, received: Received | None) -> None:
        """Handle one message; ``None`` after ``idle_s`` seconds without one."""

    def close(self) -> None:
        """Release what ``open`` took; called once, also after an exception in ``step``."""
