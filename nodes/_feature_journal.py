"""The descriptors as readers know them: numbers every change, answers for the whole."""

from collections.abc import Iterable
from dataclasses import replace
from threading import Lock

import numpy as np

from sceneq_nodes._bus import Reply, Request
from sceneq_nodes._changes import Changes
from sceneq_nodes._recent_deltas import wanted_deltas
from sceneq_nodes._wire import to_bytes
from sceneq_schemas.feature import Descriptor, FeatureDelta
from sceneq_schemas.topics import FEATURE_JOURNAL, FEATURE_SNAPSHOT


class FeatureJournal:
    """Written by the node, read from any thread.

    ``epoch`` names this run of the writer; ``seq`` counts its deltas from 1.
    """

    def __init__(self, epoch: int, model_id: str) -> None:
        self._lock = Lock()
        self._descriptors: dict[int, Descriptor] = {}
        self._changes = Changes()
        self._last = FeatureDelta(
            epoch=epoch,
            seq=0,
            full=True,
            frame_seq=-1,
            stamp_ns=0,
            model_id=model_id,
            descriptors=(),
            removed=np.zeros(0, np.int32),
        )

    def resume(self, seq: int, descriptors: Iterable[Descriptor], map_epoch: int) -> None:
        """Go on with the descriptors of an earlier run, which wrote no delta beyond ``seq``."""
        with self._lock:
            self._descriptors = {one.instance_id: one for one in descriptors}
            self._changes = Changes(seq)
            self._last = replace(self._last, seq=seq, map_epoch=map_epoch)

    @property
    def epoch(self) -> int:
        """The name of this writer's state."""
        return self._last.epoch

    @property
    def seq(self) -> int:
        """The number of the last delta."""
        return self._last.seq

    def __len__(self) -> int:
        return len(self._descriptors)

    def ids(self) -> set[int]:
        """Return the instances that are described."""
        with self._lock:
            return set(self._descriptors)

    def __contains__(self, instance_id: int) -> bool:
        return instance_id in self._descriptors

    def write(
        self,
        changed: Iterable[Descriptor],
        removed: Iterable[int],
        *,
        frame_seq: int,
        stamp_ns: int,
        map_epoch: int,
    ) -> FeatureDelta:
        """Return the next delta; ``frame_seq`` is the newest keyframe its views were chosen of.

        The first of another ``map_epoch`` is full: nothing of the old map holds there.
        """
        with self._lock:
            other_map = map_epoch != self._last.map_epoch
            if other_map:
                self._descriptors.clear()
            self._last = replace(
                self._last,
                seq=self._last.seq + 1,
                full=other_map,
                frame_seq=frame_seq,
                stamp_ns=stamp_ns,
                descriptors=tuple(changed),
                removed=np.array(sorted(removed), np.int32),
                map_epoch=map_epoch,
            )
            for instance_id in self._last.removed.tolist():
                self._descriptors.pop(instance_id, None)
            self._descriptors |= {one.instance_id: one for one in self._last.descriptors}
            if other_map:
                self._changes = Changes(self._last.seq)
            changed_ids = [one.instance_id for one in self._last.descriptors]
            self._changes.note(self._last.seq, [*changed_ids, *self._last.removed.tolist()])
            return self._last

    def snapshot(self) -> FeatureDelta:
        """Return every descriptor as of the last delta."""
        with self._lock:
            whole = tuple(self._descriptors[i] for i in sorted(self._descriptors))
            return replace(self._last, full=True, descriptors=whole, removed=np.zeros(0, np.int32))

    def answer(self, request: Request) -> Reply:
        """Answer a request for the snapshot."""
        return Reply(to_bytes(FEATURE_SNAPSHOT, self.snapshot()), FEATURE_SNAPSHOT.encoding)

    def answer_changes(self, request: Request) -> Reply | None:
        """Answer with what changed after a delta, or with nothing when that is not known."""
        epoch, after = wanted_deltas(request)
        with self._lock:
            ids = self._changes.after(after)
            if epoch != self._last.epoch or ids is None:
                return None
            known = tuple(self._descriptors[i] for i in ids if i in self._descriptors)
            gone = np.array([i for i in ids if i not in self._descriptors], np.int32)
            changed = replace(self._last, full=False, descriptors=known, removed=gone)
        return Reply(to_bytes(FEATURE_JOURNAL, changed), FEATURE_JOURNAL.encoding)
