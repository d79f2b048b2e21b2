"""Which superpoints lie side by side, in all keyframes so far, and which are in view."""

import numpy as np

from sceneq_core.arrays import Bool, Int32
from sceneq_core.mapping.borders import LOW, SHIFT, Borders
from sceneq_core.mapping.colours import Palette
from sceneq_core.mapping.contacts import Contacts
from sceneq_core.mapping.kinships import Kinships
from sceneq_core.mapping.rows import marked, sorted_keys
from sceneq_core.mapping.superpoints import SuperpointChange
from sceneq_core.mapping.tally import Tally
from sceneq_core.mapping.visibility import Visible


class Neighbourhood:
    """The contacts and colours of all superpoints, each pair under both of them, and the view.

    Only superpoints that live have contacts: the size of the surface bounds the table.
    """

    def __init__(self) -> None:
        self._length = Tally()
        self._unbent = Tally()
        self._palette = Palette()
        self._moved = np.zeros(0, np.int32)
        self.in_view = np.zeros(0, np.int32)
        self.kinships = Kinships()

    def follow(self, change: SuperpointChange, visible: Visible, group: Int32) -> Int32:
        """Take in a keyframe; return the superpoints in view and those that just left it.

        ``group`` int32 (S,) are the groups of the superpoints, -1 = none.
        """
        self._forget(change.gone_id)
        self._palette.forget(np.concatenate((change.gone_id, change.new_id)))
        self._add(visible.contacts)
        self._palette.see(visible.colours)
        seen = visible.superpoint_id, visible.colours.superpoint_id
        touched = np.concatenate((*seen, visible.contacts.first, visible.contacts.second))
        self.kinships.forget(group[touched])
        before, self.in_view = self.in_view, visible.superpoint_id
        count = int(max(before.max(initial=-1), self.in_view.max(initial=-1))) + 1
        concerned = marked(before, count)
        concerned[change.gone_id[change.gone_id < count]] = False
        concerned[self.in_view] = True
        return np.flatnonzero(concerned).astype(np.int32)

    def borders(self, group: Int32) -> Borders:
        """Return the borders of the groups that superpoints are in, ``group`` int32 (S,)."""
        return Borders(self._length, self._unbent, self._palette, self.in_view, group)

    def move(self, superpoint_id: Int32, before: Int32, group: Int32) -> None:
        """Note that superpoints are in other groups than before."""
        self.kinships.forget(np.concatenate((before, group)))
        self._moved = sorted_keys(self._moved, superpoint_id)

    def calm(self) -> None:
        """Forget what moved: what borders on it is being looked at."""
        self._moved = self._moved[:0]

    def disturbed(self) -> Int32:
        """Return the superpoints out of view that border on what moved to other groups."""
        if not len(self._moved):
            return self._moved
        entry = self._length.under(self._moved.astype(np.int64), SHIFT)
        near = self._mark(self.in_view)
        near[self._length.key.take(entry) & LOW] = True
        near[self.in_view] = False
        return np.flatnonzero(near).astype(np.int32)

    def _add(self, contacts: Contacts) -> None:
        first, second = contacts.first.astype(np.int64), contacts.second.astype(np.int64)
        key = np.concatenate((first << SHIFT | second, second << SHIFT | first))
        self._length.add(key, np.tile(contacts.length, 2))
        self._unbent.add(key, np.tile(contacts.unbent, 2))

    def _forget(self, superpoint_id: Int32) -> None:
        gone = np.sort(superpoint_id).astype(np.int64)
        for tally in (self._length, self._unbent):
            tally.drop_pairs(gone, SHIFT)

    def _mark(self, superpoint_id: Int32) -> Bool:
        """Mark superpoints in a row that is long enough for all that have contacts."""
        known = int(self._length.key[-1] >> SHIFT) if len(self._length.key) else 0
        return marked(superpoint_id, max(known, int(superpoint_id.max(initial=-1))) + 1)
