"""Which frames go into the map."""

from dataclasses import dataclass
from typing import ClassVar, Protocol

from sceneq_core.arrays import Float64
from sceneq_core.checks import need_at_least, need_positive
from sceneq_core.ingest.transforms import angle_deg, distance_m


class KeyframePolicy(Protocol):
    """Chooses keyframes; the first frame is always due."""

    def is_due(self, T_world_camera: Float64, stamp_ns: int) -> bool:
        """Tell whether this next frame of the stream should become a keyframe."""

    def took(self, T_world_camera: Float64, stamp_ns: int) -> None:
        """Learn that it did: a due frame whose images are bad is followed up by the next one."""


@dataclass(frozen=True, slots=True)
class EveryNthParams:
    """``every``: source frames from one keyframe to the next."""

    every: int = 10

    def __post_init__(self) -> None:
        need_at_least(self, 1, "every")


class EveryNth:
    """A keyframe every ``every`` source frames."""

    Params: ClassVar[type] = EveryNthParams
    kind: ClassVar[str] = "every"

    def __init__(self, params: EveryNthParams) -> None:
        self.params = params
        self._since_last = params.every - 1

    def is_due(self, T_world_camera: Float64, stamp_ns: int) -> bool:
        """Count the frame; true when enough have passed since the last keyframe."""
        self._since_last += 1
        return self._since_last >= self.params.every

    def took(self, T_world_camera: Float64, stamp_ns: int) -> None:
        """Start counting anew."""
        self._since_last = 0


@dataclass(frozen=True, slots=True)
class IntervalParams:
    """``period_s``: seconds of capture time from one keyframe to the next, on average."""

    period_s: float = 0.3

    def __post_init__(self) -> None:
        need_positive(self, "period_s")


class Interval:
    """A keyframe every ``period_s``, whatever the frame rate of the camera.

    Of the frames round each due time the nearest is taken, so that a camera at half the rate gives
    as many keyframes. A frame that comes after a pause, or by a clock that was set back, is due and
    starts anew.
    """

    Params: ClassVar[type] = IntervalParams
    kind: ClassVar[str] = "interval"

    def __init__(self, params: IntervalParams) -> None:
        self.params = params
        self._period_ns = round(params.period_s * 1e9)
        self._due_ns: int | None = None
        self._seen_ns: int | None = None

    def is_due(self, T_world_camera: Float64, stamp_ns: int) -> bool:
        """Tell whether the next frame will be further from the due time than this one."""
        step_ns = 0 if self._seen_ns is None else stamp_ns - self._seen_ns
        self._seen_ns = stamp_ns
        if self._due_ns is None or step_ns < 0:
            return True
        return 2 * (self._due_ns - stamp_ns) <= min(step_ns, self._period_ns)

    def took(self, T_world_camera: Float64, stamp_ns: int) -> None:
        """Set the next due time: a period after the last one, if this frame was near it."""
        due_ns = self._due_ns
        is_near = due_ns is not None and 2 * abs(stamp_ns - due_ns) <= self._period_ns
        self._due_ns = (due_ns if is_near and due_ns is not None else stamp_ns) + self._period_ns


@dataclass(frozen=True, slots=True)
class MotionParams:
    """``translation_m`` metres or ``rotation_deg`` degrees, whichever is reached first."""

    translation_m: float = 0.10
    rotation_deg: float = 10.0

    def __post_init__(self) -> None:
        need_positive(self, "translation_m", "rotation_deg")


class Motion:
    """A keyframe whenever the camera has moved or turned enough since the last one."""

    Params: ClassVar[type] = MotionParams
    kind: ClassVar[str] = "motion"

    def __init__(self, params: MotionParams) -> None:
        self.params = params
        self._T_world_last: Float64 | None = None

    def is_due(self, T_world_camera: Float64, stamp_ns: int) -> bool:
        """Tell whether the pose differs enough from the last keyframe's."""
        last = self._T_world_last
        return (
            last is None
            or distance_m(last, T_world_camera) >= self.params.translation_m
            or angle_deg(last, T_world_camera) >= self.params.rotation_deg
        )

    def took(self, T_world_camera: Float64, stamp_ns: int) -> None:
        """Measure from this pose on."""
        self._T_world_last = T_world_camera
