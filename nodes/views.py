"""Names the keyframes that show each instance best, and keeps the pictures to prove it.

Reads   frames and map deltas, joined by ``seq``: a keyframe is looked at once the map holds it.
Writes  one view delta per keyframe looked at, also when no view set changed: it tells ingest how
        far the graph has come. A keyframe sent again is acknowledged again. The first delta after
        a restart of the map is full: ids mean other things from there on.
Serves  sceneq/view/<scene>/@snapshot/v1, @journal/v1?epoch=E;after=SEQ (what changed since), and
        @image/v1 (JPEG of a keyframe, ``?seq=``, ``;box=``).
Rate    as the map changes, about 3 Hz; STATE delivery, gaps are healed from the snapshot.
Bad     frames that the map never takes in are let go (``frames_unmatched``), frames that do not
        decode are acknowledged and skipped (``frames_bad``), like those that the map keeps out
        (``frames_kept_out``); a delta that contradicts the map too (``map_delta_bad``). A disk that
        fails counts as ``store_failed``; with a store (docs/durability.md) a new process goes on.
"""

import logging
from collections import deque
from dataclasses import dataclass, field
from functools import partial
from typing import Any, ClassVar

from sceneq_core.views.archive import ArchiveParams
from sceneq_core.views.choice import ChoiceParams
from sceneq_core.views.selector import ViewParams, ViewSelector
from sceneq_core.views.view import ViewSet
from sceneq_core.visits import is_same_visit
from sceneq_nodes._bus import Bus, Context, Received
from sceneq_nodes._convert import map_delta_from_message, view_set_message
from sceneq_nodes._epoch import first_seq, new_epoch
from sceneq_nodes._follow import Follower
from sceneq_nodes._images import frame_from_message
from sceneq_nodes._order import may_come, says_nothing
from sceneq_nodes._pages import paged
from sceneq_nodes._seen_frames import SeenFrames
from sceneq_nodes._view_image import answer_image
from sceneq_nodes._view_journal import ViewJournal
from sceneq_nodes._view_store import open_view_store
from sceneq_schemas.errors import DecodeError
from sceneq_schemas.frame import Frame
from sceneq_schemas.map import MapDelta
from sceneq_schemas.topics import (
    FRAME,
    MAP_DELTA,
    MAP_JOURNAL,
    MAP_SNAPSHOT,
    VIEW_DELTA,
    VIEW_IMAGE,
    VIEW_JOURNAL,
    VIEW_SNAPSHOT,
)

log = logging.getLogger(__name__)

PATIENCE_STEPS, START_STEPS = 40, 120
"""Changes of the map wait so many idle steps, of ``idle_s``, for a frame that is sent again; more
before the first one, for a source that starts when everything does."""
REMEMBERED = 64
"""So many keyframes, the last ones, are known to be in the map when they come late."""


@dataclass(frozen=True, slots=True)
class ViewsParams:
    """How views are ranked, how many images are kept, how many frames wait for their map.

    ``waiting`` is more than segmentation and mapping hold between them when they fall behind: else
    every frame would be let go just before the map takes it in, and nothing be seen any more.
    """

    choice: ChoiceParams = field(default_factory=ChoiceParams)
    archive: ArchiveParams = field(default_factory=ArchiveParams)
    waiting: int = 40
    robots: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if self.waiting < 1:
            raise ValueError(f"waiting: must be at least 1, got {self.waiting}")


class Views:
    """Drives a ``ViewSelector`` with the frames and the map of one scene."""

    Params: ClassVar[type] = ViewsParams
    idle_s: ClassVar[float] = 0.5

    def __init__(self, params: ViewsParams, context: Context) -> None:
        self._params = params
        self._context = context
        self._selector = ViewSelector(ViewParams(params.choice, params.archive))
        self._waiting: dict[int, Frame] = {}
        self._seen, self._newest = SeenFrames(), (-1, 0)
        self._unsent: dict[int, ViewSet] = {}
        self._mapped: deque[int] = deque(maxlen=REMEMBERED)
        self._quarantined: deque[int] = deque(maxlen=REMEMBERED)
        self._marked, self._idle_steps, self._patience = 0, 0, START_STEPS
        self._held: deque[MapDelta] = deque()

    def open(self, bus: Bus) -> None:
        """Subscribe to frames and the map, serve the snapshot and the pictures."""
        context, self._bus = self._context, bus
        parts = self._selector, self._seen, self._parts
        self._store = open_view_store(context.store, *parts, bus.count)
        kept = self._store.resume() if self._store else {}
        self._map_epoch, self._map_seq = kept.get("map", (0, 0))
        self._map = Follower(
            *(bus, MAP_DELTA, MAP_SNAPSHOT, self._follow),
            journal_topic=MAP_JOURNAL,
            merged=False,
            have=(self._map_epoch, self._map_seq) if self._store else None,
            scene=context.scene,
        )
        self._begin_run(kept)
        for robot in (context.robot, *self._params.robots):
            bus.subscribe(FRAME, depth=self._params.waiting, robot=robot, sensor=context.sensor)
        bus.serve(VIEW_SNAPSHOT, paged(self._journal.answer), scene=context.scene)
        bus.serve(VIEW_JOURNAL, paged(self._journal.answer_changes), scene=context.scene)
        pictures = partial(answer_image, image=self._selector.image)
        bus.serve(VIEW_IMAGE, pictures, scene=context.scene)
        self._map.open()

    def step(self, received: Received | None) -> None:
        """Take in a frame or a change of the map; look at the keyframes that the map now holds.

        The first silence is marked by a delta: else the loss of the last one shows to nobody.
        """
        if received is None:
            self._map.tick()
        elif received.topic is FRAME:
            self._wait(received.message)
        else:
            self._map.offer(received.message)
        self._advance(patient=received is not None or self._idle_steps < self._patience)
        self._idle_steps = self._idle_steps + 1 if received is None and self._held else 0
        if received is None:
            self._publish_changes(always=self._journal.seq != self._marked)
            self._marked = self._journal.seq

    def close(self) -> None:
        """Let go of the store."""
        if self._store:
            self._store.close()

    def _parts(self) -> dict[str, Any]:
        """Return what is to come back after the process has ended, beside the selector's."""
        return {
            "epoch": self._journal.epoch,
            "run": self._run,
            "map": (self._map_epoch, self._map_seq),
            "is_lossless": self._is_lossless,
            "newest": self._newest,
            "mapped": list(self._mapped),
            "quarantined": list(self._quarantined),
        }

    def _begin_run(self, kept: dict[str, Any]) -> None:
        """Go on where the last run ended, or begin; what cannot be noted begins under a new name.

        Else the next run would number its deltas as this one does.
        """
        self._run = kept.get("run", -1) + 1
        self._journal = ViewJournal(kept.get("epoch") or new_epoch())
        self._mapped.extend(kept.get("mapped", ()))
        self._quarantined.extend(kept.get("quarantined", ()))
        self._newest = kept.get("newest", self._newest)
        self._is_lossless = kept.get("is_lossless", self._store is not None)
        if self._store:
            self._store.keep()
            if self._store.is_behind:
                self._journal, self._run = ViewJournal(new_epoch()), 0
        if kept:
            view_sets = map(view_set_message, self._selector.view_sets())
            self._journal.resume(first_seq(self._run), view_sets, **self._where())
        self._report()

    def _where(self) -> dict[str, int]:
        """Return the newest keyframe and the revision of the map that what is told belongs to."""
        seq, stamp_ns = self._newest
        revision = {"map_epoch": self._map_epoch, "map_seq": self._map_seq}
        return {"frame_seq": seq, "stamp_ns": stamp_ns, **revision}

    def _follow(self, delta: MapDelta) -> None:
        """Queue a change of the map; a whole map that follows on none makes all others needless."""
        last = self._held[-1].seq if self._held else self._map_seq
        if delta.full and (delta.epoch, delta.seq - 1) != (self._map_epoch, last):
            self._held.clear()
        self._held.append(delta)
        self._advance(patient=True)

    def _advance(self, patient: bool) -> None:
        """Take over the changes of the map, each before the frame it names is looked at.

        A frame that was lost on its way comes again where nothing is lost: then, while
        ``patient``, later changes wait for it. So every keyframe is looked at in the map of its
        time, whoever was killed meanwhile. After each change it is chosen again, not when there
        is time for it: what is chosen depends on what was chosen before.
        """
        self._join()
        while self._held and not (patient and self._is_missing(self._held[0])):
            self._take_over(self._held.popleft())
            self._join()
            self._choose()

    def _is_missing(self, delta: MapDelta) -> bool:
        told = delta.frame_seq in self._mapped and says_nothing(delta)
        if delta.full or told or self._map_epoch not in (0, delta.epoch) or not self._is_lossless:
            return False
        newest = self._seen.newest(delta.frame_seq)
        return delta.frame_seq > newest and delta.frame_seq not in self._waiting

    def _take_over(self, delta: MapDelta) -> None:
        """Apply a change; a whole map holds the older frames that wait as well."""
        try:
            self._selector.follow(map_delta_from_message(delta))
        except ValueError as error:
            self._bus.count("map_delta_bad")
            log.warning("map %d:%d: %s", delta.epoch, delta.seq, error)
            return
        if self._store:
            self._store.follow(delta)
        if delta.epoch != self._map_epoch:
            self._mapped.clear()
            self._seen.clear()  # to be acknowledged only when the new map holds them
        if delta.quarantined:
            self._quarantined.append(delta.frame_seq)
        newest = delta.frame_seq if delta.full and delta.seq > 1 else -1
        older = [seq for seq in self._waiting if seq < newest and is_same_visit(seq, newest)]
        self._mapped.extend((*older, delta.frame_seq))
        self._map_epoch, self._map_seq = delta.epoch, delta.seq

    def _wait(self, frame: Frame) -> None:
        """Keep ``frame`` until the map holds it; acknowledge one that was looked at before."""
        if self._seen.stamp_of(frame.seq) == frame.stamp_ns:
            self._newest = (frame.seq, frame.stamp_ns)
            self._publish_changes(always=True)
            return
        self._is_lossless, self._patience = frame.after >= 0, PATIENCE_STEPS
        self._waiting[frame.seq] = frame
        if len(self._waiting) > self._params.waiting:
            oldest = next(iter(self._waiting))
            del self._waiting[oldest]
            self._bus.count("frames_unmatched")
            log.warning("frame %d: skipped, the map has not taken it in", oldest)

    def _join(self) -> None:
        """Look at the keyframes that the map holds, none before the one it is to come after."""
        for seq in sorted(self._waiting.keys() & set(self._mapped)):
            if may_come(self._waiting[seq], self._seen, self._seen.oldest(seq)):
                self._observe(self._waiting.pop(seq))

    def _observe(self, message: Frame) -> None:
        if message.seq in self._quarantined:
            self._bus.count("frames_kept_out")
        else:
            self._look(message)
        self._newest = (message.seq, message.stamp_ns)
        self._seen.add(*self._newest)
        self._publish_changes(always=True)

    def _look(self, message: Frame) -> None:
        try:
            self._selector.see(frame_from_message(message))
        except DecodeError as error:
            self._bus.count("frames_bad")
            log.warning("frame %d: skipped, %s", message.seq, error)
        else:
            self._bus.count("frames_observed")

    def _choose(self) -> None:
        self._unsent |= {view_set.instance_id: view_set for view_set in self._selector.changes()}

    def _publish_changes(self, always: bool = False) -> None:
        self._choose()
        changed = [view_set_message(self._unsent[i]) for i in sorted(self._unsent)]
        if not (changed or always):
            return
        self._unsent.clear()
        if self._store:
            self._store.keep()
        delta = self._journal.write(changed, **self._where())
        self._bus.publish(VIEW_DELTA, delta, scene=self._context.scene)
        self._report()

    def _report(self) -> None:
        archive = self._selector.archive
        self._bus.report(
            views=f"{self._journal.epoch}:{self._journal.seq}",
            instances_with_views=len(self._selector.view_sets()),
            keyframes=len(archive),
            keyframes_dropped_unused=archive.dropped_unused,
            keyframes_dropped_used=archive.dropped_used,
        )
