"""Keeps a copy of a scene's map, views and descriptors on another machine, and says if it is one.

Reads   map, view and descriptor deltas of the scene (state: gaps are healed by asking), or, with
        ``pull``, what changed every few seconds: less data, later, at a rate that leaves room.
Writes  nothing; its health tells ``map``, ``views``, ``features`` as epoch:seq and a digest each.
        Mirrors of one scene on any machine tell equal digests when they hold the same.
Rate    as the scene changes; digests are made when nothing comes any more, or every ``digest_s``.
Bad     a delta that fits no map is counted (``map_delta_bad``) and left out.
"""

import json
import logging
import time
from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar

from sceneq_nodes._bus import Bus, Context, QueryError, Received
from sceneq_nodes._follow import Follower, Pull
from sceneq_nodes._mirrored import MirroredFeatures, MirroredMap, MirroredViews
from sceneq_schemas import topics
from sceneq_schemas.topics import Topic

log = logging.getLogger(__name__)

MODEL_RETRY_S = 2.0
FOLLOWED: dict[str, tuple[Topic, Topic, Topic]] = {
    "map": (topics.MAP_DELTA, topics.MAP_SNAPSHOT, topics.MAP_JOURNAL),
    "views": (topics.VIEW_DELTA, topics.VIEW_SNAPSHOT, topics.VIEW_JOURNAL),
    "features": (topics.FEATURE_DELTA, topics.FEATURE_SNAPSHOT, topics.FEATURE_JOURNAL),
}


@dataclass(frozen=True, slots=True)
class MirrorParams:
    """``model``: whose descriptors, "" = that of the front door. ``pull``: for a thin link;
    default: every change at once. ``digest_s``: seconds between digests while changes come.
    """

    model: str = ""
    pull: Pull | None = None
    digest_s: float = 10.0

    def __post_init__(self) -> None:
        if not self.digest_s > 0:
            raise ValueError(f"digest_s: expected more than 0, got {self.digest_s}")


class Mirror:
    """Follows one scene."""

    Params: ClassVar[type] = MirrorParams
    idle_s: ClassVar[float] = 0.5

    def __init__(self, params: MirrorParams, context: Context) -> None:
        self._params = params
        self._context = context
        self._copies: dict[str, MirroredMap | MirroredViews | MirroredFeatures] = {
            "map": MirroredMap(),
            "views": MirroredViews(),
            "features": MirroredFeatures(),
        }
        self._followers: dict[str, Follower] = {}
        self._told: dict[str, tuple[int | None, int]] = {}
        self._model = params.model
        self._next_look_s = 0.0
        self._next_digest_s = 0.0

    def open(self, bus: Bus) -> None:
        """Follow the map and the views; the descriptors once their model is known."""
        self._bus = bus
        for name in ("map", "views"):
            self._follow(name)
        self._look_for_model()

    def step(self, received: Received | None) -> None:
        """Take over a change, or catch up."""
        if received is None:
            self._look_for_model()
        else:
            self._follower_of(received.topic).offer(received.message)
        for follower in list(self._followers.values()):
            follower.tick()
        if received is None or time.monotonic() >= self._next_digest_s:
            self._report()

    def close(self) -> None:
        """Nothing to release."""

    def _follow(self, name: str, **ids: Any) -> None:
        delta, snapshot, journal = FOLLOWED[name]
        follower = Follower(
            *(self._bus, delta, snapshot, partial(self._apply, name)),
            journal_topic=journal,
            pull=self._params.pull,
            scene=self._context.scene,
            **ids,
        )
        self._followers[name] = follower
        follower.open()

    def _follower_of(self, topic: Topic) -> Follower:
        return next(f for name, f in self._followers.items() if FOLLOWED[name][0] is topic)

    def _apply(self, name: str, delta: Any) -> None:
        try:
            self._copies[name].apply(delta)
        except ValueError as error:
            self._bus.count("map_delta_bad")
            log.warning("%s %d:%d: %s", name, delta.epoch, delta.seq, error)

    def _look_for_model(self) -> None:
        """Ask the front door whose descriptors it answers from, until it says."""
        if "features" in self._followers or time.monotonic() < self._next_look_s:
            return
        self._next_look_s = time.monotonic() + MODEL_RETRY_S
        self._model = self._model or self._asked_model()
        if self._model:
            self._follow("features", model=self._model)

    def _asked_model(self) -> str:
        try:
            replies = self._bus.ask(topics.QUERY_STATUS, scene=self._context.scene)
            return str(json.loads(replies[0].payload)["model"]) if replies else ""
        except (QueryError, ValueError, KeyError) as error:
            log.info("the front door does not tell its model: %s", error)
            return ""

    def _report(self) -> None:
        """Tell how far each copy is, and the digest of those that have changed."""
        self._next_digest_s = time.monotonic() + self._params.digest_s
        for name, follower in self._followers.items():
            state = (follower.epoch, follower.seq)
            if follower.epoch is not None and self._told.get(name) != state:
                self._told[name] = state
                copy = self._copies[name]
                said = {name: f"{state[0]}:{state[1]}", f"{name}_digest": copy.digest()}
                self._bus.report(**said, **copy.counts())
        self._bus.report(synced=int(all(f.synced for f in self._followers.values())))
