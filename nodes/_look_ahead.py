"""Looks at instances before it is their turn, on a core that has nothing else to do."""

from collections.abc import Callable, Iterable
from concurrent.futures import Executor, Future

from sceneq_core.views.view import ViewSet

MOST = 2
"""Looks under way or waiting for a thread; a third would be at views that may change till then."""


class LookAhead:
    """Lets ``look`` be done early, for what it remembers: what it returns or raises is left alone.

    The same look is done again in its turn; then it costs nothing, or fails where somebody sees it.
    """

    def __init__(self, workers: Executor, look: Callable[[ViewSet], object]) -> None:
        self._workers = workers
        self._look = look
        self._looked_at: dict[int, ViewSet] = {}
        self._under_way: list[Future[object]] = []

    def go_on(self, waiting: Iterable[ViewSet]) -> None:
        """Look at the next of ``waiting`` that was not looked at as it is, if there is time."""
        self._under_way = [look for look in self._under_way if not look.done()]
        if len(self._under_way) >= MOST:
            return
        for view_set in waiting:
            if self._looked_at.get(view_set.instance_id) is not view_set:
                self._looked_at[view_set.instance_id] = view_set
                self._under_way.append(self._workers.submit(self._look, view_set))
                return
