"""A map in a Rerun recording: clouds, boxes and captions. Files and the viewer node share it."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from sceneq_core.arrays import Float64, UInt8
from sceneq_core.mapping.delta import OBJECT, STALE, TENTATIVE, Instance
from sceneq_core.mapping.replica import MapReplica
from sceneq_core.picture.colours import instance_colours
from sceneq_nodes._viewer_cloud import CloudLog, by_colour, by_instance, by_superpoint

COLOUR, INSTANCES, SUPERPOINTS = "world/colour", "world/instances", "world/superpoints"
BOXES = "world/boxes"
BOX_RADIUS_M = 0.004
AXES = {
    (0, 1): "RIGHT_HAND_X_UP",
    (0, -1): "RIGHT_HAND_X_DOWN",
    (1, 1): "RIGHT_HAND_Y_UP",
    (1, -1): "RIGHT_HAND_Y_DOWN",
    (2, 1): "RIGHT_HAND_Z_UP",
    (2, -1): "RIGHT_HAND_Z_DOWN",
}
CLOUDS = {COLOUR: by_colour, INSTANCES: by_instance, SUPERPOINTS: by_superpoint}
MAX_POINTS = 500_000


class MapLog:
    """Keeps one recording up to date with one map.

    Args:
        recording: a ``rerun.RecordingStream``.
        clouds: which of ``CLOUDS`` to log.
        max_points: of each cloud; of a larger map some are left out.
    """

    def __init__(
        self,
        recording: Any,
        clouds: Sequence[str] = (COLOUR, INSTANCES),
        max_points: int = MAX_POINTS,
    ) -> None:
        self._recording = recording
        self._up = ""
        self._clouds = [CloudLog(path, CLOUDS[path], max_points) for path in clouds]

    def log(self, replica: MapReplica, captions: Mapping[int, str]) -> int:
        """Log what differs from the last time; return the number of points logged.

        ``captions`` are the words at the boxes by instance id; a number stands where one lacks.
        """
        self._log_up(replica.up_world)
        count = sum(cloud.log(self._recording, replica) for cloud in self._clouds)
        # Boxes of floor and walls enclose everything else; the clouds show them well enough.
        every = [replica.instances[key] for key in sorted(replica.instances)]
        instances = [one for one in every if one.role == OBJECT and one.state != TENTATIVE]
        texts = [_text(one, captions) for one in instances]
        self._recording.log(BOXES, instance_boxes(instances, texts, BOX_RADIUS_M))
        return count

    def forget_oldest(self) -> None:
        """Log the oldest block of every cloud again next time."""
        for cloud in self._clouds:
            cloud.forget_oldest()

    def _log_up(self, up_world: Float64) -> None:
        """Tell the viewer which axis points up, as near as an axis does."""
        axis = int(np.abs(up_world).argmax())
        name = AXES[axis, 1 if up_world[axis] >= 0 else -1]
        if name != self._up and up_world.any():
            import rerun as rr

            self._up = name
            self._recording.log("world", getattr(rr.ViewCoordinates, name), static=True)


def _text(instance: Instance, captions: Mapping[int, str]) -> str:
    text = captions.get(instance.instance_id, str(instance.instance_id))
    return f"{text} ({STALE})" if instance.state == STALE else text


def instance_boxes(
    instances: list[Instance],
    texts: list[str],
    radius_m: float,
    colours: UInt8 | None = None,
) -> Any:
    """Return the oriented boxes as ``rerun.Boxes3D`` in the colours of their instances."""
    import rerun as rr

    T_world_box = np.array([one.T_world_box for one in instances]).reshape(-1, 4, 4)
    return rr.Boxes3D(
        centers=T_world_box[:, :3, 3],
        sizes=np.array([one.box_size_m for one in instances]).reshape(-1, 3),
        quaternions=_xyzw(T_world_box[:, :3, :3]),
        colors=box_colours(instances) if colours is None else colours,
        radii=radius_m,
        labels=texts,
        show_labels=True,
        fill_mode="majorwireframe",
    )


def box_colours(instances: list[Instance]) -> UInt8:
    """Return the full colours of instances, uint8 (N, 3)."""
    ids = np.array([one.instance_id for one in instances], np.int32)
    white = np.full((max(len(ids), 1), 3), 255, np.uint8)
    return instance_colours(ids, white[: len(ids)]) if len(ids) else white[:0]


def _xyzw(R_world_box: Float64) -> Float64:
    """Return unit quaternions (N, 4), x y z w, of rotations (N, 3, 3)."""
    from scipy.spatial.transform import Rotation

    if not len(R_world_box):
        return np.zeros((0, 4))
    xyzw: Float64 = Rotation.from_matrix(R_world_box).as_quat()
    return xyzw
