"""When the answer to where a frame of reference lies is good enough to go by."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.checks import need_at_least, need_positive
from sceneq_core.ingest.transforms import angle_deg, transform
from sceneq_core.places.relocaliser import Relocation


@dataclass(frozen=True, slots=True)
class SettlingParams:
    """An answer is gone by once one more keyframe moves the camera by ``steady_m`` and
    ``steady_deg`` at most: half a voxel, also of what is seen at two metres.

    After ``patience`` more keyframes it is taken as it is: what is recognised may be over.
    """

    steady_m: float = 0.01
    steady_deg: float = 0.25
    patience: int = 6

    def __post_init__(self) -> None:
        need_positive(self, "steady_m", "steady_deg")
        need_at_least(self, 1, "patience")


class Settling:
    """Waits until the answer stands still, for frames are fused by it once and for all.

    The first keyframes that recognise anything see it from afar, at the edge of the picture; what
    they agree on is right and not exact. Those that come next see it better.

    Attributes:
        sure: the newest answer, ``None`` as long as there is none.
    """

    def __init__(self, params: SettlingParams) -> None:
        self._params = params
        self._since = 0
        self.sure: Relocation | None = None

    def take(self, found: Relocation | None, camera_odom: Float64) -> Relocation | None:
        """Take the answer after one more keyframe, whose camera was at ``camera_odom`` (3,).

        Returns it when it may be gone by.
        """
        before, self.sure = self.sure, found
        if found is None or before is None:
            self._since = 0
            return None
        self._since += 1
        is_steady = found.features > before.features and self._is_near(before, found, camera_odom)
        return found if is_steady or self._since >= self._params.patience else None

    def _is_near(self, one: Relocation, other: Relocation, camera_odom: Float64) -> bool:
        if angle_deg(one.T_world_odom, other.T_world_odom) > self._params.steady_deg:
            return False
        apart = transform(one.T_world_odom, camera_odom) - transform(
            other.T_world_odom, camera_odom
        )
        return float(np.linalg.norm(apart)) <= self._params.steady_m
