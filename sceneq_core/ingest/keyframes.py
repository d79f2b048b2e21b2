"""Which frames go into the map."""

from dataclasses import dataclass
from typing import ClassVar, Protocol

from sceneq_core.arrays import Float64
from sceneq_core.ingest.transforms import angle_deg, distance_m


class KeyframePolicy(Protocol):
    """Chooses keyframes; the first frame is always due."""

    def is_due(self, T_world_camera: Float64) -> bool:
        """Tell whether this next frame of the stream should become a keyframe."""

    def took(self, T_world_camera: Float64) -> None:
        """Learn that it did: a due frame whose images are bad is followed up by the next one."""


class EveryNth:
    """A keyframe every ``every`` source frames."""

    @dataclass(frozen=True, slots=True)
    class Params:
        """``every``: source frames from one keyframe to the next."""

        every: int = 10

        def __post_init__(self) -> None:
            if self.every < 1:
                raise ValueError(f"every: expected 1 or more, got {self.every}")

    kind: ClassVar[str] = "every"

    def __init__(self, params: Params) -> None:
        self.params = params
        self._since_last = params.every - 1

    def is_due(self, T_world_camera: Float64) -> bool:
        """Count the frame; true when enough have passed since the last keyframe."""
        self._since_last += 1
        return self._since_last >= self.params.every

    def took(self, T_world_camera: Float64) -> None:
        """Start counting anew."""
        self._since_last = 0


class Motion:
    """A keyframe whenever the camera has moved or turned enough since the last one."""

    @dataclass(frozen=True, slots=True)
    class Params:
        """``translation_m`` metres or ``rotation_deg`` degrees, whichever is reached first."""

        translation_m: float = 0.10
        rotation_deg: float = 10.0

        def __post_init__(self) -> None:
            for name in ("translation_m", "rotation_deg"):
                if not getattr(self, name) > 0:
                    raise ValueError(f"{name}: expected more than 0, got {getattr(self, name)}")

    kind: ClassVar[str] = "motion"

    def __init__(self, params: Params) -> None:
        self.params = params
        self._T_world_last: Float64 | None = None

    def is_due(self, T_world_camera: Float64) -> bool:
        """Tell whether the pose differs enough from the last keyframe's."""
        last = self._T_world_last
        return (
            last is None
            or distance_m(last, T_world_camera) >= self.params.translation_m
            or angle_deg(last, T_world_camera) >= self.params.rotation_deg
        )

    def took(self, T_world_camera: Float64) -> None:
        """Measure from this pose on."""
        self._T_world_last = T_world_camera
