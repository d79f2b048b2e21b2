"""What ingest, or any SLAM system, writes when poses are known better than before."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

from sceneq_schemas.arrays import Array, ArraySpec


@dataclass(frozen=True, slots=True)
class PoseCorrection:
    """The poses of keyframes as they are known now; keyframes that are not named keep theirs.

    ``keyframe_seq`` and ``T_world_camera`` (metres, colour camera, OpenCV axes) are parallel. Poses
    are absolute, so a message that comes twice, or after a lost one, does no harm. With ``full``
    it names every pose that ever changed in this ``epoch``. It holds from frame ``frame_seq`` on:
    mapping applies it before that frame, or at once when it holds that frame or a later one.
    """

    VERSION: ClassVar[int] = 1
    SCHEMA: ClassVar[str] = "sceneq.correction.v1"
    epoch: int
    seq: int
    full: bool
    frame_seq: int
    stamp_ns: int
    keyframe_seq: Annotated[Array, ArraySpec("<i8", (None,))]
    T_world_camera: Annotated[Array, ArraySpec("<f8", (None, 4, 4))]
