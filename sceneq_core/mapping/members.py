"""What a group of superpoints consists of."""

from dataclasses import dataclass

from sceneq_core.arrays import Float32, Int32, UInt8


@dataclass(frozen=True, slots=True)
class Members:
    """What a group consists of now.

    ``superpoint_id`` int32 sorted; of its voxels, in parallel rows, ``voxel_id`` int32,
    ``points_world`` float32 (N, 3) metres and ``rgb`` uint8 (N, 3).
    """

    superpoint_id: Int32
    voxel_id: Int32
    points_world: Float32
    rgb: UInt8
