"""One example of every message, the same bytes on every machine."""

from typing import Any

import numpy as np

from sceneq_schemas.correction import PoseCorrection
from sceneq_schemas.feature import Descriptor, FeatureDelta
from sceneq_schemas.frame import Frame, ImageData, Pose
from sceneq_schemas.label import InstanceLabel, LabelDelta
from sceneq_schemas.map import Event, Instance, MapDelta, MapDeltas, Place
from sceneq_schemas.mask import Masks
from sceneq_schemas.page import Page
from sceneq_schemas.place import Place as PlacePicture
from sceneq_schemas.place import PlaceSet
from sceneq_schemas.proposal import ProposalSet
from sceneq_schemas.view import View, ViewDelta, ViewSet

T_WORLD_CAMERA = np.array(
    [[0.0, -1.0, 0.0, 1.5], [1.0, 0.0, 0.0, -0.25], [0.0, 0.0, 1.0, 2.0], [0.0, 0.0, 0.0, 1.0]]
)
K = np.array([[525.0, 0.0, 1.5], [0.0, 525.0, 1.0], [0.0, 0.0, 1.0]])


def ramp(dtype: str, *shape: int) -> Any:
    """Return 0, 1, 2, ... as an array."""
    return np.arange(np.prod(shape, dtype=int)).astype(dtype).reshape(shape)


_EXAMPLES = (
    Frame(
        seq=7,
        stamp_ns=1_700_000_000_000_000_000,
        rgb=ImageData("raw", "|u1", (2, 3, 3), bytes(range(18))),
        depth_mm=ImageData("raw", "<u2", (2, 3), bytes(range(12))),
        K=K,
        T_world_camera=T_WORLD_CAMERA,
        after=5,
    ),
    Pose(seq=8, stamp_ns=-5, T_world_camera=T_WORLD_CAMERA, source="given", keyframe=True),
    PoseCorrection(
        epoch=1_700_000_000,
        seq=1,
        full=True,
        frame_seq=30,
        stamp_ns=1_000,
        keyframe_seq=np.array([10, 20], np.int64),
        T_world_camera=np.stack([T_WORLD_CAMERA, np.eye(4)]),
    ),
    Masks(seq=7, stamp_ns=1_000, label_image=ramp("<u2", 3, 4)),
    ProposalSet(
        stamp_ns=1_000,
        source="mask3d",
        points_world=ramp("<f4", 4, 3),
        mask_id=np.array([0, 0, 1], np.int32),
        point_id=np.array([0, 1, 3], np.int32),
        score=np.array([0.9, 0.4], np.float32),
        label=("chair", "door"),
    ),
    MapDelta(
        epoch=1_700_000_000,
        seq=2,
        full=False,
        frame_seq=7,
        stamp_ns=1_000,
        voxel_size_m=0.02,
        up_world=np.array([0.0, 0.0, 1.0]),
        voxel_id=ramp("<i4", 4),
        voxel_coord=ramp("<i4", 4, 3) - 5,
        points_world=ramp("<f4", 4, 3) / 8,
        rgb=ramp("|u1", 4, 3),
        superpoint_id=ramp("<i4", 4) - 1,
        removed_voxel_id=ramp("<i4", 2),
        instances=(
            Instance(
                instance_id=3,
                state="confirmed",
                merged_into=0,
                parent=1,
                superpoint_id=ramp("<i4", 2),
                voxel_count=4,
                centre_world=np.array([0.5, 0.25, -1.0]),
                aabb_world=ramp("<f8", 2, 3),
                T_world_box=T_WORLD_CAMERA,
                box_size_m=np.array([0.5, 0.25, 0.125]),
                first_seen_ns=10,
                last_seen_ns=1_000,
                state_since_ns=20,
                role="wall",
                places=(Place(np.array([1.0, 2.0, 3.0]), ramp("<f8", 2, 3), 10, 15),),
                supported_by=5,
                inside=6,
                neighbour_id=ramp("<i4", 2) + 8,
            ),
        ),
        events=(Event("merged", 2, 3, 1_000),),
        quarantined="the pose jumps",
        moved_from_id=ramp("<i4", 1),
        moved_to_id=ramp("<i4", 1) + 3,
    ),
    PlaceSet(
        epoch=1_700_000_000,
        seq=3,
        places=(PlacePicture(7, T_WORLD_CAMERA, b"\xff\xd8\xff\xd9", K, ramp("<u2", 2, 3), K),),
    ),
    ViewDelta(
        epoch=1,
        seq=4,
        full=True,
        frame_seq=7,
        stamp_ns=1_000,
        map_epoch=1_700_000_000,
        map_seq=2,
        view_sets=(
            ViewSet(
                instance_id=3,
                views=(
                    View(
                        seq=7,
                        stamp_ns=1_000,
                        visible_px=40,
                        box_xyxy=np.array([1.0, 2.0, 9.0, 5.0], np.float32),
                        mask_shape=(3, 8),
                        mask_bits=b"\xff\x81\xff",
                    ),
                ),
            ),
            ViewSet(instance_id=4, views=()),
        ),
    ),
    FeatureDelta(
        epoch=1,
        seq=5,
        full=False,
        frame_seq=7,
        stamp_ns=1_000,
        model_id="hash-v1",
        descriptors=(
            Descriptor(
                instance_id=3,
                view_seq=np.array([7], np.int64),
                descriptor=np.array([0.6, 0.8], np.float32),
                feature=ramp("<f4", 3),
            ),
        ),
        removed=np.array([4], np.int32),
    ),
    LabelDelta(
        epoch=1_700_000_000,
        seq=6,
        full=False,
        frame_seq=7,
        stamp_ns=1_000,
        model_id="hash-v1",
        label_set="scannet200",
        map_epoch=1_700_000_001,
        labels=(
            InstanceLabel(3, "coffee table", 0.75, True, "encoder"),
            InstanceLabel(5, "aunt mary's mug", 1.0, True, "taught"),
        ),
        removed=np.array([4], np.int32),
    ),
    Page(
        of="1f2e3d4c5b6a7988",
        page=2,
        pages=5,
        size=1_000_000,
        digest="1f2e3d4c5b6a7988" * 4,
        encoding="application/msgpack;sceneq.map.v1",
        data=b"\x28\xb5\x2f\xfd",
    ),
)

_MAP = next(message for message in _EXAMPLES if isinstance(message, MapDelta))
EXAMPLES: tuple[Any, ...] = (*_EXAMPLES, MapDeltas(epoch=_MAP.epoch, seq=9, deltas=(_MAP,)))
