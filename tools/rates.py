"""How fast counters grow."""

from collections.abc import Mapping


class Rates:
    """Remembers what every counter was the last time it was asked about."""

    def __init__(self) -> None:
        self._before: dict[str, tuple[float, Mapping[str, int]]] = {}

    def of(self, name: str, counts: Mapping[str, int], now_s: float) -> dict[str, float]:
        """Return by how much a second the ``counts`` of ``name`` grew since the last call.

        Empty the first time, and after a counter has become less: its process has started again.
        """
        then_s, before = self._before.get(name, (now_s, counts))
        self._before[name] = (now_s, dict(counts))
        grown = {one: count - before.get(one, 0) for one, count in counts.items()}
        if now_s <= then_s or min(grown.values(), default=0) < 0:
            return {}
        return {one: more / (now_s - then_s) for one, more in grown.items()}
