"""The places of a map: one of each part of the way, however often it was gone."""

from collections.abc import Iterator
from dataclasses import dataclass, field

from sceneq_core.checks import need_at_least, need_positive
from sceneq_core.frame import Frame
from sceneq_core.ingest.transforms import angle_deg, distance_m
from sceneq_core.mapping.correction import Correction
from sceneq_core.places.place import Place, PlaceParams, place_of


@dataclass(frozen=True, slots=True)
class GazetteerParams:
    """A keyframe is a place of its own ``apart_m`` or ``apart_deg`` from all others.

    Features are known again over about such a step. ``most`` places are kept; beyond that the one
    nearest to another gives way.
    """

    apart_m: float = 0.4
    apart_deg: float = 20.0
    most: int = 400
    place: PlaceParams = field(default_factory=PlaceParams)

    def __post_init__(self) -> None:
        need_positive(self, "apart_m", "apart_deg")
        need_at_least(self, 2, "most")


class Gazetteer:
    """Keeps places. Same keyframes, same order: same places.

    Attributes:
        revision: changes whenever a place does.
    """

    def __init__(self, params: GazetteerParams) -> None:
        self._params = params
        self._places: dict[int, Place] = {}
        self.revision = 0

    def __len__(self) -> int:
        """Return the number of places."""
        return len(self._places)

    def __iter__(self) -> Iterator[Place]:
        """Yield the places, oldest first."""
        return iter(self._places.values())

    def visit(self, frame: Frame) -> None:
        """Make a keyframe of the map a place, if there is none yet where it was taken."""
        if any(self._nearness(frame, place) < 1.0 for place in self):
            return
        self._places[frame.seq] = place_of(frame, self._params.place)
        self.revision += 1
        if len(self._places) > self._params.most:
            del self._places[self._most_needless()]

    def correct(self, correction: Correction) -> None:
        """Move the places of keyframes whose poses are known better now."""
        poses = zip(correction.seq.tolist(), correction.T_world_camera, strict=True)
        moved = {seq: pose for seq, pose in poses if seq in self._places}
        self._places |= {seq: self._places[seq].at(pose) for seq, pose in moved.items()}
        self.revision += bool(moved)

    def _nearness(self, one: Frame | Place, other: Frame | Place) -> float:
        """Return how far two poses are apart; from 1 on they are two places."""
        T_one, T_other = one.T_world_camera, other.T_world_camera
        apart = distance_m(T_one, T_other) / self._params.apart_m
        return max(apart, angle_deg(T_one, T_other) / self._params.apart_deg)

    def _most_needless(self) -> int:
        """Return the younger of the two places that are nearest to each other."""
        places = list(self)
        pairs = (
            (self._nearness(one, other), -other.seq)
            for i, one in enumerate(places)
            for other in places[i + 1 :]
        )
        return -min(pairs)[1]
