"""Describes every instance by the crops of its best views.

Reads   sceneq/view/<scene>/delta/v1 (state, healed from its snapshot); pictures of keyframes from
        sceneq/view/<scene>/@image/v1.
Writes  sceneq/feat/<scene>/<model>/delta/v1, one instance at a time: epoch = start time in ms.
Serves  sceneq/feat/<scene>/<model>/@snapshot/v1: all descriptors as one message;
        .../@journal/v1?epoch=E;after=SEQ: what changed since.
Rate    as fast as the encoder, at lower priority than the mapping: first every instance by its
        best view, then by all. At most one view set waits for each instance, the latest; the
        last descriptor depends on the last view set only.
Bad     a view without picture is skipped (``images_gone``, ``images_bad``), an instance without
        any keeps its old descriptor (``instances_unseen``); a view set that does not decode is
        skipped (``view_sets_bad``). While nobody answers for pictures the instances wait.
"""

import logging
import os
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import partial
from typing import Any, ClassVar

import numpy as np

from sceneq_core.encoding.describe import DescribeParams, Describer, Description
from sceneq_core.encoding.encoder import Encoder
from sceneq_core.encoding.pending import Pending
from sceneq_core.views.view import ViewSet
from sceneq_nodes._backends import build
from sceneq_nodes._bus import Bus, Context, Received
from sceneq_nodes._convert import view_set_from_message, view_set_message
from sceneq_nodes._epoch import first_seq, new_epoch
from sceneq_nodes._feature_journal import FeatureJournal
from sceneq_nodes._feature_store import digest_of, open_feature_store
from sceneq_nodes._follow import Follower
from sceneq_nodes._keyframes import Keyframes, UnreachableError
from sceneq_nodes._look_ahead import LookAhead
from sceneq_nodes._pages import paged
from sceneq_schemas.errors import DecodeError
from sceneq_schemas.feature import Descriptor
from sceneq_schemas.topics import (
    FEATURE_DELTA,
    FEATURE_JOURNAL,
    FEATURE_SNAPSHOT,
    VIEW_DELTA,
    VIEW_JOURNAL,
    VIEW_SNAPSHOT,
)
from sceneq_schemas.view import ViewDelta
from sceneq_schemas.view import ViewSet as ViewSetMessage

log = logging.getLogger(__name__)

PATIENCE_S = 1.0
"""How long to wait before asking again for pictures that nobody answered for."""


@dataclass(frozen=True, slots=True)
class EncodingParams:
    """``encoder``: kind and parameters of the backend; ``pictures`` to remember; ``turn_s``: how
    long to describe instances before looking for messages again, seconds; ``nice``: how much this
    process yields to the others (0 to 19), so that the mapping keeps up; ``at_once``: how many
    instances are described at a time, on as many cores; with more than 1 crops are also encoded
    while messages come, as a core is free then.
    """

    encoder: dict[str, Any] = field(default_factory=lambda: {"kind": "conse"})
    describe: DescribeParams = field(default_factory=DescribeParams)
    pictures: int = 32
    turn_s: float = 0.1
    nice: int = 2
    at_once: int = 1

    def __post_init__(self) -> None:
        if not 1 <= self.at_once <= 64:
            raise ValueError(f"at_once: {self.at_once} is not in [1, 64]")
        if self.pictures < 1:
            raise ValueError(f"pictures: must be at least 1, got {self.pictures}")
        if not 0 <= self.turn_s <= 10:
            raise ValueError(f"turn_s: {self.turn_s} is not in [0, 10]")
        if not 0 <= self.nice <= 19:
            raise ValueError(f"nice: {self.nice} is not in [0, 19]")


class Encoding:
    """Follows the view sets of one scene and describes instances whenever it is idle."""

    Params: ClassVar[type] = EncodingParams
    idle_s: ClassVar[float] = 0.02

    def __init__(self, params: EncodingParams, context: Context) -> None:
        self._params = params
        self._context = context
        self._pending = Pending()
        self._made_of: dict[int, bytes] = {}
        self._latest = (-1, 0)
        self._map_epoch = 0
        self._resume_s = 0.0
        self._marked = 0

    def open(self, bus: Bus) -> None:
        """Build the encoder, serve the descriptors and follow the view sets."""
        _yield_to_others(self._params.nice)
        self._bus, scene = bus, self._context.scene
        encoder: Encoder = build("encoder", self._params.encoder, ("encoder",))
        self._model = encoder.model_id
        self._describer = Describer(encoder, self._params.describe)
        self._keyframes = Keyframes(bus, scene, self._params.pictures)
        self._workers = ThreadPoolExecutor(self._params.at_once, "describe")
        self._ahead = LookAhead(self._workers, self._look_ahead)
        self._store = open_feature_store(self._context.store, self._model, bus.count)
        kept = self._store.resume() if self._store else {}
        self._begin_run(kept)
        bus.serve(FEATURE_SNAPSHOT, paged(self._journal.answer), scene=scene, model=self._model)
        changes = paged(self._journal.answer_changes)
        bus.serve(FEATURE_JOURNAL, changes, scene=scene, model=self._model)
        self._views = Follower(
            *(bus, VIEW_DELTA, VIEW_SNAPSHOT, self._follow),
            journal_topic=VIEW_JOURNAL,
            have=(kept["view_epoch"], 0) if kept.get("view_epoch") else None,
            scene=scene,
        )
        self._views.open()

    def step(self, received: Received | None) -> None:
        """Take over changed view sets; when there are none, describe the next instance."""
        if received is not None:
            self._views.offer(received.message)
            self._bus.report(views=self._views.at)
            if self._params.at_once > 1:
                self._ahead.go_on(self._pending)
            return
        self._views.tick()
        self._bus.report(views=self._views.at)
        deadline_s = time.monotonic() + self._params.turn_s
        while self._pending and self._resume_s <= time.monotonic() <= deadline_s:
            self._describe_next()
        if not self._pending and self._journal.seq != self._marked:
            # Nothing follows: without a mark, the loss of the last delta would show to nobody.
            self._publish([], [])
            self._marked = self._journal.seq

    def close(self) -> None:
        """Let go of the threads and the store."""
        self._workers.shutdown(cancel_futures=True)
        if self._store:
            self._store.close()

    def _begin_run(self, kept: dict[str, Any]) -> None:
        """Go on with the descriptors of the last run, or begin; what cannot be noted begins under
        a new name, else the next run would number its deltas as this one does.
        """
        self._run = kept.get("run", -1) + 1
        self._journal = FeatureJournal(kept.get("epoch") or new_epoch(), self._model)
        if not (self._store and kept):
            return
        self._map_epoch, self._latest = kept["map_epoch"], kept["latest"]
        self._made_of = dict(self._store.kept.made_of)
        self._store.note({**kept, "run": self._run})
        if self._store.is_behind:
            self._journal, self._run = FeatureJournal(new_epoch(), self._model), 0
        descriptors = self._store.kept.descriptors.values()
        self._journal.resume(first_seq(self._run), descriptors, self._map_epoch)

    def _follow(self, delta: ViewDelta) -> None:
        """Take over changed view sets; what is not mentioned stays, unless it must be gone.

        A views node that begins anew has yet to see most instances: that is no reason to forget
        what they look like. Another map is: its ids mean other things; and so is a whole that
        the same node tells, which leaves out only what is gone.
        """
        if not delta.map_epoch:
            return  # it knows no map yet
        self._latest = (delta.frame_seq, delta.stamp_ns)
        known_map = self._map_epoch
        if delta.map_epoch != self._map_epoch:
            self._map_epoch, self._pending = delta.map_epoch, Pending()
            self._made_of.clear()
        gone = {one.instance_id for one in delta.view_sets if not one.views}
        if delta.full and (delta.epoch, delta.map_epoch) == (self._views.epoch, known_map):
            gone |= self._journal.ids() - {one.instance_id for one in delta.view_sets}
        for instance_id in gone:
            self._pending.forget(instance_id)
            self._made_of.pop(instance_id, None)
        for message in delta.view_sets:
            if message.views:
                self._wait(message)
        if removed := [instance_id for instance_id in gone if instance_id in self._journal]:
            self._publish([], removed)
        self._report()

    def _wait(self, message: ViewSetMessage) -> None:
        try:
            view_set = view_set_from_message(message)
            if self._made_of.get(message.instance_id) == digest_of(message):
                self._pending.settle(view_set)
            else:
                self._pending.put(view_set)
        except DecodeError as error:
            self._bus.count("view_sets_bad")
            log.warning("views of instance %d skipped: %s", message.instance_id, error)

    def _describe_next(self) -> None:
        """Describe the most urgent instances; what is published does not depend on their speed."""
        taken = self._pending.take_some(self._params.at_once)
        many = len(taken) > 1
        found = self._workers.map(self._look, taken) if many else map(self._look, taken)
        for view_set, description in zip(taken, found, strict=True):
            if isinstance(description, UnreachableError):
                self._wait_for_pictures(view_set, description)
            else:
                self._tell(view_set, description)
        self._report()

    def _look(self, view_set: ViewSet) -> Description | UnreachableError | None:
        try:
            return self._describer.describe(view_set, self._keyframes.image)
        except UnreachableError as error:
            return error

    def _look_ahead(self, view_set: ViewSet) -> Description | None:
        return self._describer.describe(view_set, partial(self._keyframes.image, counted=False))

    def _wait_for_pictures(self, view_set: ViewSet, error: UnreachableError) -> None:
        self._bus.count("pictures_unreachable")
        log.warning("instance %d waits: %s", view_set.instance_id, error)
        self._pending.give_back(view_set)
        self._resume_s = time.monotonic() + PATIENCE_S

    def _tell(self, view_set: ViewSet, description: Description | None) -> None:
        self._pending.settle(view_set)
        if description is None:
            self._bus.count("instances_unseen")
            return
        self._bus.count("instances_described")
        self._made_of[view_set.instance_id] = digest_of(view_set_message(view_set))
        descriptor = Descriptor(
            instance_id=view_set.instance_id,
            view_seq=np.array(description.view_seq, np.int64),
            descriptor=description.descriptor,
            feature=description.feature,
        )
        self._publish([descriptor], [])

    def _publish(self, changed: list[Descriptor], removed: list[int]) -> None:
        frame_seq, stamp_ns = self._latest
        delta = self._journal.write(
            changed, removed, frame_seq=frame_seq, stamp_ns=stamp_ns, map_epoch=self._map_epoch
        )
        if self._store:
            made_of = {one.instance_id: self._made_of[one.instance_id] for one in changed}
            self._store.keep(delta, made_of, self._beside())
        self._bus.publish(FEATURE_DELTA, delta, scene=self._context.scene, model=self._model)
        self._bus.report(features=f"{delta.epoch}:{delta.seq}")

    def _beside(self) -> dict[str, Any]:
        """Return what is to come back after the process has ended, beside the descriptors."""
        return {
            "epoch": self._journal.epoch,
            "run": self._run,
            "map_epoch": self._map_epoch,
            "latest": self._latest,
            "view_epoch": self._views.epoch,
        }

    def _report(self) -> None:
        self._bus.report(described=len(self._journal), pending=len(self._pending))


def _yield_to_others(nice: int) -> None:
    """Lower the priority of this process to ``nice``, once, however often it is called."""
    current = os.getpriority(os.PRIO_PROCESS, 0)
    os.setpriority(os.PRIO_PROCESS, 0, max(current, nice))
