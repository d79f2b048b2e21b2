"""Who came into a scene when, and how each one's frame of reference lies in it."""

import zlib
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.frame import Frame, depth_to_mm
from sceneq_core.ingest.transforms import rigid_defect

HERE = np.eye(4)
"""A frame of reference that is the scene's."""


@dataclass(frozen=True, slots=True)
class Visit:
    """One run of a robot's source.

    Attributes:
        number: in the scene, from 0.
        robot: who came.
        origin: the scene it came from, if that was merged into this one, else empty.
        first_seq: number of the first keyframe in its own recording.
        first_stamp_ns: time of that, nanoseconds.
        fingerprint: of its images (``fingerprint_of``), for recordings without a clock count alike.
        T_world_odom: float64 (4, 4), ``None`` as long as it is not known.
        evidence: what that rests on, in words.
    """

    number: int
    robot: str
    origin: str
    first_seq: int
    first_stamp_ns: int
    fingerprint: int = 0
    T_world_odom: Float64 | None = None
    evidence: str = ""

    @property
    def first(self) -> tuple[str, int, int, int]:
        """What names the first frame."""
        return self.robot, self.first_seq, self.first_stamp_ns, self.fingerprint


def fingerprint_of(frame: Frame) -> int:
    """Return a number that other images, all but surely, do not have."""
    return zlib.crc32(depth_to_mm(frame.depth_m).tobytes(), zlib.crc32(frame.rgb.tobytes()))


class Visits:
    """The visits of one scene, by number."""

    def __init__(self, visits: Iterable[Visit] = ()) -> None:
        self._visits = {visit.number: visit for visit in visits}

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self._visits)

    def all(self) -> list[Visit]:
        """Return them by number."""
        return [visit for _, visit in sorted(self._visits.items())]

    def get(self, number: int) -> Visit | None:
        """Return a visit by its number."""
        return self._visits.get(number)

    def find(self, other: Visit) -> Visit | None:
        """Return the newest visit that began with the same frame: the same source, played again."""
        found = [visit for visit in self.all() if visit.first == other.first]
        return found[-1] if found else None

    def next_number(self, has_frames: bool) -> int:
        """Return the number of the next visit; 0 is taken where frames came before any visit."""
        return max(self._visits, default=0 if has_frames else -1) + 1

    def take(self, visit: Visit) -> None:
        """Note a visit, or what is known better of one.

        Raises:
            ValueError: no rigid motion.
        """
        T_world_odom = visit.T_world_odom
        defect = None if T_world_odom is None else rigid_defect(T_world_odom)
        if defect:
            raise ValueError(f"visit {visit.number}: T_world_odom: {defect}")
        self._visits[visit.number] = visit

    def settled(self, number: int, T_world_odom: Float64, evidence: str) -> Visit:
        """Return visit ``number`` with where its frame of reference lies.

        Raises:
            ValueError: no such visit.
        """
        if number not in self._visits:
            raise ValueError(f"no visit {number}")
        return replace(self._visits[number], T_world_odom=T_world_odom, evidence=evidence)
