"""The view sets as readers know them: numbers every change, answers for the whole."""

from collections.abc import Iterable
from dataclasses import replace
from threading import Lock

from sceneq_nodes._bus import Reply, Request
from sceneq_nodes._changes import Changes
from sceneq_nodes._recent_deltas import wanted_deltas
from sceneq_nodes._wire import to_bytes
from sceneq_schemas.topics import VIEW_JOURNAL, VIEW_SNAPSHOT
from sceneq_schemas.view import ViewDelta, ViewSet


class ViewJournal:
    """Written by the node, read from any thread.

    ``epoch`` names this run of the writer; ``seq`` counts its deltas from 1.
    """

    def __init__(self, epoch: int) -> None:
        self._lock = Lock()
        self._view_sets: dict[int, ViewSet] = {}
        self._changes = Changes()
        self._last = ViewDelta(
            epoch=epoch,
            seq=0,
            full=True,
            frame_seq=-1,
            stamp_ns=0,
            map_epoch=0,
            map_seq=0,
            view_sets=(),
        )

    def resume(
        self,
        seq: int,
        view_sets: Iterable[ViewSet],
        *,
        frame_seq: int,
        stamp_ns: int,
        map_epoch: int,
        map_seq: int,
    ) -> None:
        """Go on with the view sets of an earlier run, which wrote no delta beyond ``seq``."""
        with self._lock:
            self._view_sets = {one.instance_id: one for one in view_sets}
            self._changes = Changes(seq)
            self._last = replace(
                self._last,
                seq=seq,
                frame_seq=frame_seq,
                stamp_ns=stamp_ns,
                map_epoch=map_epoch,
                map_seq=map_seq,
            )

    @property
    def epoch(self) -> int:
        """The name of this writer's state."""
        return self._last.epoch

    @property
    def seq(self) -> int:
        """The number of the last delta."""
        return self._last.seq

    @property
    def frame_seq(self) -> int:
        """The newest keyframe written about, -1 before the first."""
        return self._last.frame_seq

    def write(self, changed: Iterable[ViewSet], **where: int) -> ViewDelta:
        """Return the next delta; ``where`` are its keyframe and map revision if they moved on.

        Of a new map every view set is told: its readers forget what they know of the old one.
        """
        with self._lock:
            before, sets = self._last, tuple(changed)
            for view_set in sets:
                self._keep(view_set)
            self._last = replace(before, seq=before.seq + 1, full=False, view_sets=sets, **where)
            if self._last.map_epoch != before.map_epoch:
                self._last = replace(self._last, full=True, view_sets=self._every())
                self._changes = Changes(self._last.seq)
            self._changes.note(self._last.seq, (one.instance_id for one in sets))
            return self._last

    def snapshot(self) -> ViewDelta:
        """Return every view set as of the last delta."""
        with self._lock:
            return replace(self._last, full=True, view_sets=self._every())

    def answer(self, request: Request) -> Reply:
        """Answer a request for the snapshot."""
        return Reply(to_bytes(VIEW_SNAPSHOT, self.snapshot()), VIEW_SNAPSHOT.encoding)

    def answer_changes(self, request: Request) -> Reply | None:
        """Answer with what changed after a delta, or with nothing when that is not known."""
        epoch, after = wanted_deltas(request)
        with self._lock:
            ids = self._changes.after(after)
            if epoch != self._last.epoch or ids is None:
                return None
            sets = tuple(self._view_sets.get(i, ViewSet(i, ())) for i in ids)
            changed = replace(self._last, full=False, view_sets=sets)
        return Reply(to_bytes(VIEW_JOURNAL, changed), VIEW_JOURNAL.encoding)

    def _every(self) -> tuple[ViewSet, ...]:
        return tuple(self._view_sets[i] for i in sorted(self._view_sets))

    def _keep(self, view_set: ViewSet) -> None:
        if view_set.views:
            self._view_sets[view_set.instance_id] = view_set
        else:
            self._view_sets.pop(view_set.instance_id, None)
