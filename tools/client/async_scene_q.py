"""The same for ``asyncio``: what waits, waits on a thread."""

import asyncio
from collections.abc import AsyncIterator, Sequence
from typing import Any, TypeVar

from sceneq_client.answer import Answer, Instance, Naming, View
from sceneq_client.changes import Change
from sceneq_client.scene_q import DEFAULT_ENDPOINT, SceneQ
from sceneq_client.standing import Sighting
from sceneq_client.subscription import Subscription

T = TypeVar("T")
LOOK_S = 0.2
"""How long a thread waits for an event before it sees whether anybody still wants it."""


class AsyncSceneQ:
    """``SceneQ`` with coroutines; use it in an ``async with`` block."""

    def __init__(
        self, endpoint: str = DEFAULT_ENDPOINT, scene: str | None = None, timeout_s: float = 10.0
    ) -> None:
        """Remember where to connect; ``async with`` connects, and raises as ``SceneQ`` does."""
        self._where = (endpoint, scene, timeout_s)
        self._scene: SceneQ | None = None

    async def __aenter__(self) -> "AsyncSceneQ":
        self._scene = await asyncio.to_thread(SceneQ, *self._where)
        return self

    async def __aexit__(self, *_: object) -> None:
        await asyncio.to_thread(self.sync.close)

    @property
    def sync(self) -> SceneQ:
        """The connection itself; raise ``RuntimeError`` outside of the ``async with`` block."""
        if self._scene is None:
            raise RuntimeError("use AsyncSceneQ in an 'async with' block")
        return self._scene

    async def ask(self, question: str, **options: Any) -> Answer:
        """Return the answer to ``question``; options and errors as of ``SceneQ.ask``."""
        return await asyncio.to_thread(self.sync.ask, question, **options)

    async def label(
        self, instance_id: int, labels: Sequence[str] | None = None, **options: Any
    ) -> Naming:
        """Return what an instance is called; options and errors as of ``SceneQ.label``."""
        return await asyncio.to_thread(self.sync.label, instance_id, labels, **options)

    async def instances(self) -> list[Instance]:
        """Return every instance of the map by id."""
        return await asyncio.to_thread(lambda: list(self.sync.instances()))

    async def picture(self, view: View) -> bytes:
        """Return the JPEG of a keyframe; raise ``NoAnswerError`` when it is gone."""
        return await asyncio.to_thread(self.sync.picture, view)

    async def changes(self) -> AsyncIterator[Change]:
        """Yield what happens in the map from now on."""
        async for change in _each(self.sync.subscribe()):
            yield change

    async def watch(self, question: str, **options: Any) -> AsyncIterator[Sighting]:
        """Yield what answers a standing question; options as of ``SceneQ.watch``."""
        async for sighting in _each(self.sync.watch(question, **options)):
            yield sighting


async def _each(subscription: Subscription[T]) -> AsyncIterator[T]:
    try:
        while not subscription.closed:
            event = await asyncio.to_thread(subscription.get, LOOK_S)
            if event is not None:
                yield event
    finally:
        await asyncio.to_thread(subscription.close)
