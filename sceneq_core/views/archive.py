"""The keyframes worth keeping: those that views refer to, and the newest."""

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import chain
from typing import Any

from sceneq_core.checks import need_at_least
from sceneq_core.views.keyframe import Keyframe


@dataclass(frozen=True, slots=True)
class ArchiveParams:
    """How much is kept.

    Attributes:
        newest: keyframes kept though no view refers to them yet.
        capacity: keyframes kept at most, about 0.2 MB each at 640x480.
    """

    newest: int = 20
    capacity: int = 400

    def __post_init__(self) -> None:
        need_at_least(self, 1, "newest")
        need_at_least(self, self.newest, "capacity")


class ImageArchive:
    """Keyframes by seq in order of arrival, bounded by what views refer to.

    Attributes:
        dropped_unused: keyframes let go because no view referred to them.
        dropped_used: keyframes let go at ``capacity`` although views referred to them.
    """

    def __init__(self, params: ArchiveParams) -> None:
        self._params = params
        self._keyframes: dict[int, Keyframe] = {}
        self._references: dict[int, tuple[int, ...]] = {}
        self.dropped_unused = 0
        self.dropped_used = 0

    def __len__(self) -> int:
        return len(self._keyframes)

    def __iter__(self) -> Iterator[Keyframe]:
        return iter(self._keyframes.values())

    def __contains__(self, seq: int) -> bool:
        return seq in self._keyframes

    def __getitem__(self, seq: int) -> Keyframe:
        return self._keyframes[seq]

    def jpeg(self, seq: int) -> bytes | None:
        """Return the image of a keyframe, ``None`` when it is not here; safe from any thread."""
        keyframe = self._keyframes.get(seq)
        return keyframe.jpeg if keyframe else None

    def add(self, keyframe: Keyframe) -> None:
        """Keep ``keyframe`` as the newest."""
        self._keyframes[keyframe.seq] = keyframe

    def remove(self, seq: int) -> None:
        """Let go of a keyframe."""
        del self._keyframes[seq]

    def refer(self, instance_id: int, seqs: tuple[int, ...]) -> None:
        """Note which keyframes the views of an instance refer to from now on."""
        if seqs:
            self._references[instance_id] = seqs
        else:
            self._references.pop(instance_id, None)

    def parts(self) -> dict[str, Any]:
        """Return what is kept beside the keyframes, in their order."""
        return {
            "order": list(self._keyframes),
            "references": dict(self._references),
            "dropped": (self.dropped_unused, self.dropped_used),
        }

    def resume(self, keyframes: Mapping[int, Keyframe], parts: Mapping[str, Any]) -> None:
        """Become the archive whose ``parts`` these are, as far as its keyframes are here."""
        self._keyframes = {seq: keyframes[seq] for seq in parts["order"] if seq in keyframes}
        self._references = dict(parts["references"])
        self.dropped_unused, self.dropped_used = parts["dropped"]

    def make_room(self) -> tuple[int, ...]:
        """Let go of what is old and unused, then of what few views use; return the seqs that went.

        Afterwards one more keyframe fits. Of keyframes used equally the oldest goes.
        """
        uses = Counter(chain.from_iterable(self._references.values()))
        old = list(self._keyframes)[: max(len(self) - self._params.newest + 1, 0)]
        unused = [seq for seq in old if not uses[seq]]
        excess = max(len(self) - len(unused) + 1 - self._params.capacity, 0)
        used = sorted((seq for seq in old if uses[seq]), key=uses.__getitem__)[:excess]
        for seq in (*unused, *used):
            self.remove(seq)
        self.dropped_unused += len(unused)
        self.dropped_used += len(used)
        return (*unused, *used)
