"""Things that vanished here and came back there: the same one, or not known to be?"""

from dataclasses import dataclass

from sceneq_core.checks import need_at_least, need_between
from sceneq_core.mapping.delta import Instance
from sceneq_core.mapping.signature import Signature, likeness


@dataclass(frozen=True, slots=True)
class RecognitionParams:
    """When a new instance is one that vanished.

    Both must be alike by ``min_likeness``, and every rival of either less than ``max_rival`` times
    as much: of two equal chairs none is recognised. The new one must have been known for
    ``settle_s`` (what is seen of it at first may be a small part), and what vanished is remembered
    for ``recall_s``.
    """

    min_likeness: float = 0.6
    max_rival: float = 0.8
    settle_s: float = 0.5
    recall_s: float = 1800.0

    def __post_init__(self) -> None:
        need_between(self, 0, 1, "min_likeness", "max_rival")
        need_at_least(self, 0, "settle_s", "recall_s")


@dataclass(frozen=True, slots=True)
class Appearance:
    """What an instance looks like and from when its surface is, nanoseconds."""

    signature: Signature
    born_ns: int


@dataclass(frozen=True, slots=True)
class Vanished:
    """An instance as it last was, since when it was there, and when it was found to be gone."""

    instance: Instance
    signature: Signature
    placed_ns: int
    gone_ns: int


class Recognition:
    """Compares what is there with what vanished; the order in which the two are noticed is open.

    A thing cannot be in two places: what was there before the other was last seen is not it.
    """

    def __init__(self, params: RecognitionParams) -> None:
        self._params = params
        self._present: dict[int, Appearance] = {}
        self._vanished: dict[int, Vanished] = {}
        self._likeness: dict[tuple[int, int], float] = {}

    def knows(self, instance_id: int) -> bool:
        """Return whether the looks of a present instance are known."""
        return instance_id in self._present

    def see(self, instance_id: int, appearance: Appearance) -> None:
        """Take over what a present instance looks like."""
        self._present[instance_id] = appearance
        for vanished_id, vanished in self._vanished.items():
            self._compare(instance_id, vanished_id, appearance, vanished)

    def vanish(self, instance: Instance, placed_ns: int, now_ns: int) -> None:
        """Remember a present instance that is gone from where it was since ``placed_ns``."""
        key = instance.instance_id
        appearance = self._present.get(key)
        self.forget(key)
        if appearance is None:
            return
        vanished = Vanished(instance, appearance.signature, placed_ns, now_ns)
        self._vanished[key] = vanished
        for present_id, present in self._present.items():
            self._compare(present_id, key, present, vanished)

    def forget(self, instance_id: int) -> None:
        """Compare an instance no more: it was merged, or recognised."""
        self._present.pop(instance_id, None)
        self._vanished.pop(instance_id, None)
        self._likeness = {k: v for k, v in self._likeness.items() if instance_id not in k}

    def recognise(self, instance_id: int, vanished_id: int) -> None:
        """Go on with a present instance under the id of the vanished one."""
        appearance = self._present[instance_id]
        self.forget(instance_id)
        self.forget(vanished_id)
        self.see(vanished_id, appearance)

    def decide(self, now_ns: int) -> list[tuple[int, Vanished]]:
        """Return the present instances that are vanished ones, one to one, by id."""
        for key in [k for k, v in self._vanished.items() if self._too_old(v, now_ns)]:
            self.forget(key)
        settled_ns = now_ns - int(self._params.settle_s * 1e9)
        return [
            (present_id, self._vanished[vanished_id])
            for present_id, vanished_id in sorted(self._likeness)
            if self._present[present_id].born_ns <= settled_ns
            and self._unrivalled(present_id, vanished_id)
        ]

    def _too_old(self, vanished: Vanished, now_ns: int) -> bool:
        return now_ns - vanished.gone_ns > self._params.recall_s * 1e9

    def _compare(
        self, present_id: int, vanished_id: int, present: Appearance, vanished: Vanished
    ) -> None:
        if present.born_ns >= vanished.instance.last_seen_ns:
            alike = likeness(present.signature, vanished.signature)
            self._likeness[present_id, vanished_id] = alike

    def _unrivalled(self, present_id: int, vanished_id: int) -> bool:
        best = self._likeness[present_id, vanished_id]
        rivals = [
            value
            for (present, vanished), value in self._likeness.items()
            if (present == present_id) != (vanished == vanished_id)
        ]
        limit = self._params.max_rival * best
        return best >= self._params.min_likeness and max(rivals, default=0.0) < limit
