"""The scene as a Python object."""

from collections.abc import Iterator, Sequence
from typing import Any, TypeVar

from sceneq_client.answer import Answer, Instance, Naming, View
from sceneq_client.asking import ABSENT_S, json_object, put
from sceneq_client.changes import Change, MapEvents
from sceneq_client.errors import DisconnectedError, NoAnswerError, SceneError
from sceneq_client.standing import Sighting, StandingQuestion
from sceneq_client.subscription import Subscription
from sceneq_nodes._client import Client
from sceneq_schemas.topics import (
    FEATURE_DELTA,
    LABEL_DELTA,
    MAP_DELTA,
    QUERY_ASK,
    QUERY_INSTANCES,
    QUERY_LABEL,
    QUERY_STATUS,
    TEACH_FORGET,
    TEACH_SET,
    Topic,
)

T = TypeVar("T")
PAGE = 200
DEFAULT_ENDPOINT = "tcp/127.0.0.1:7447"


class SceneQ:
    """A connection to one scene, to be used in a ``with`` block; safe to share between threads.

    When the router or a node goes away the connection comes back by itself: a question that is
    asked meanwhile is put again until it is answered or ``timeout_s`` is over. With access rules,
    the credentials are those that the environment names (docs/security.md).
    """

    def __init__(
        self, endpoint: str = DEFAULT_ENDPOINT, scene: str | None = None, timeout_s: float = 10.0
    ) -> None:
        """Connect to the router at ``endpoint``; without a ``scene``, to the only one it knows.

        Raises:
            DisconnectedError: no router there.
            NoAnswerError: no scene answers.
            SceneError: several scenes answer, or the credentials cannot be used.
        """
        try:
            self._client = Client(endpoint, timeout_s)
        except ConnectionError as error:
            raise DisconnectedError(str(error)) from error
        except ValueError as error:
            raise SceneError(str(error)) from error
        self._timeout_s = timeout_s
        self._open: list[Subscription[Any]] = []
        self.scene = scene or self._only_scene()

    def __enter__(self) -> "SceneQ":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End all subscriptions and leave the network."""
        for subscription in self._open:
            subscription.close()
        self._client.close()

    def ask(
        self,
        question: str,
        k: int = 5,
        mode: str | None = None,
        deadline_ms: int | None = None,
        timeout_s: float | None = None,
    ) -> Answer:
        """Return the answer to ``question`` with its ``k`` best instances.

        ``mode`` "fast" never asks the reasoner, "reason" always does; after ``deadline_ms`` the
        scene answers with what it has.

        Raises:
            NoAnswerError, BusyError, RefusedError: see ``sceneq_client.errors``.
        """
        request = _given(q=question, k=k, mode=mode, deadline_ms=deadline_ms)
        topic = QUERY_INSTANCES if mode == "fast" else QUERY_ASK
        if mode == "fast":
            del request["mode"]
        return _read(Answer, self._put(topic, request, timeout_s))

    def label(
        self,
        instance_id: int,
        labels: Sequence[str] | None = None,
        mode: str | None = None,
        timeout_s: float | None = None,
    ) -> Naming:
        """Return what an instance is called, of ``labels`` if given; raise as ``ask``."""
        request = _given(id=instance_id, labels=list(labels) if labels else None, mode=mode)
        return _read(Naming, self._put(QUERY_LABEL, request, timeout_s))

    def instances(self, timeout_s: float | None = None) -> Iterator[Instance]:
        """Yield every instance of the map by id; raise as ``ask``."""
        after = 0
        while page := self._page(after, timeout_s):
            yield from page
            after = page[-1].id

    def picture(self, view: View, timeout_s: float | None = None) -> bytes:
        """Return the JPEG of a keyframe; raise ``NoAnswerError`` when it is gone."""
        replies, _ = self._client.get(view.key, timeout_s=timeout_s or self._timeout_s)
        if not replies:
            raise NoAnswerError(f"nobody has the picture {view.key}")
        return replies[-1][1].payload

    def status(self, timeout_s: float | None = None) -> dict[str, Any]:
        """Return how the scene and its nodes are; raise as ``ask``."""
        return self._put(QUERY_STATUS, {}, timeout_s)

    def teach(self, instance_id: int, name: str, timeout_s: float | None = None) -> dict[str, Any]:
        """Give an instance a name that sticks to it; raise as ``ask``."""
        return self._put(TEACH_SET, {"id": instance_id, "name": name}, timeout_s)

    def forget(self, instance_id: int, timeout_s: float | None = None) -> dict[str, Any]:
        """Take a taught name back; raise as ``ask``."""
        return self._put(TEACH_FORGET, {"id": instance_id}, timeout_s)

    def subscribe(self) -> Subscription[Change]:
        """Return what happens in the map from now on."""
        subscription: Subscription[Change] = Subscription()
        hear = MapEvents(subscription.put).hear
        subscription.on_close(self._client.subscribe(MAP_DELTA.selector(scene=self.scene), hear))
        return self._kept(subscription)

    def watch(
        self, question: str, min_p: float = 0.5, pause_s: float = 0.5, k: int = 20
    ) -> Subscription[Sighting]:
        """Return the instances that answer ``question``, each once while it stays.

        Told are those there now and all that come, when their ``p`` reaches ``min_p``. The
        question is asked on the fast path whenever the map changed, at most every ``pause_s``.
        """
        subscription: Subscription[Sighting] = Subscription()
        standing = StandingQuestion(
            question,
            lambda text: self.ask(text, k=k, mode="fast"),
            subscription.put,
            pause_s,
            min_p,
        )
        for topic in (MAP_DELTA, FEATURE_DELTA, LABEL_DELTA):
            selector = topic.selector(scene=self.scene)
            subscription.on_close(self._client.subscribe(selector, lambda *_: standing.changed()))
        subscription.on_close(standing.close)
        standing.start()
        return self._kept(subscription)

    def _kept(self, subscription: Subscription[T]) -> Subscription[T]:
        self._open.append(subscription)
        return subscription

    def _page(self, after: int, timeout_s: float | None) -> list[Instance]:
        told = self._put(QUERY_INSTANCES, {"k": PAGE, "after": after}, timeout_s)
        return [_read(Instance, {"p": 0.0, **raw}) for raw in told["instances"]]

    def _put(
        self, topic: Topic, request: dict[str, Any], timeout_s: float | None
    ) -> dict[str, Any]:
        most_s = timeout_s or self._timeout_s
        # Whoever names a time means all of it, also while nobody is there to answer.
        return put(self._client, topic, self.scene, request, most_s, timeout_s or ABSENT_S)

    def _only_scene(self) -> str:
        replies, _ = self._client.get(QUERY_STATUS.selector(), timeout_s=self._timeout_s)
        scenes = sorted({str(json_object(reply)["scene"]) for _, reply in replies})
        if len(scenes) == 1:
            return scenes[0]
        self._client.close()
        if not scenes:
            raise NoAnswerError("no scene answers (start one: sceneq up --source FOLDER)")
        raise SceneError(f"several scenes answer: {', '.join(scenes)} (say which)")


def _given(**fields: Any) -> dict[str, Any]:
    return {name: value for name, value in fields.items() if value is not None}


def _read(kind: type[T], raw: Any) -> T:
    try:
        return kind.read(raw)  # type: ignore[attr-defined,no-any-return]
    except (KeyError, TypeError, ValueError) as error:
        raise SceneError(f"the answer is not one of ours: {error!r}") from error
