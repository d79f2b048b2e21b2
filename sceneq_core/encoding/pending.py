"""Which instance to describe next when there is not time for all of them."""

from collections.abc import Iterator
from heapq import nsmallest

from sceneq_core.views.view import View, ViewSet

ViewKey = tuple[int, int, bytes]


class Pending:
    """View sets that wait to be described: at most one for each instance, the latest.

    Never described instances come first, with their best view only: one look makes an instance
    answerable, the others refine it later. Then the one of which most views are new; equals in
    the order of their ids.
    """

    def __init__(self) -> None:
        self._waiting: dict[int, ViewSet] = {}
        self._described: dict[int, frozenset[ViewKey]] = {}

    def __len__(self) -> int:
        return len(self._waiting)

    def put(self, view_set: ViewSet) -> None:
        """Let ``view_set`` wait in place of an older one of its instance."""
        self._waiting.pop(view_set.instance_id, None)
        self._waiting[view_set.instance_id] = view_set

    def __iter__(self) -> Iterator[ViewSet]:
        """Yield what waits, first what has waited longest as it is."""
        return iter(self._waiting.values())

    def take(self) -> ViewSet | None:
        """Return the most urgent view set, or its best view while the whole set waits on."""
        return next(iter(self.take_some(1)), None)

    def take_some(self, most: int) -> list[ViewSet]:
        """Return what ``take`` would for each of the ``most`` most urgent instances."""
        urgent = nsmallest(most, self._waiting, key=self._urgency)
        return [self._take(instance_id) for instance_id in urgent]

    def _take(self, instance_id: int) -> ViewSet:
        view_set = self._waiting[instance_id]
        if instance_id not in self._described and len(view_set.views) > 1:
            return ViewSet(instance_id, view_set.views[:1])
        return self._waiting.pop(instance_id)

    def give_back(self, view_set: ViewSet) -> None:
        """Let a view set that could not be described wait again, unless a fuller one does."""
        self._waiting.setdefault(view_set.instance_id, view_set)

    def settle(self, view_set: ViewSet) -> None:
        """Remember that ``view_set`` was described."""
        self._described[view_set.instance_id] = frozenset(_keys(view_set))

    def forget(self, instance_id: int) -> None:
        """Drop an instance that is gone."""
        self._waiting.pop(instance_id, None)
        self._described.pop(instance_id, None)

    def _urgency(self, instance_id: int) -> tuple[bool, int, int]:
        described = self._described.get(instance_id)
        new = sum(
            described is None or key not in described for key in _keys(self._waiting[instance_id])
        )
        return described is not None, -new, instance_id


def _keys(view_set: ViewSet) -> Iterator[ViewKey]:
    return (view_key(view) for view in view_set.views)


def view_key(view: View) -> ViewKey:
    """Return what tells one look at an object from another: keyframe and box."""
    return view.seq, view.stamp_ns, view.box_xyxy.tobytes()
