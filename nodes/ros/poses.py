"""The poses that a robot sends, by tf or on a topic of their own, in one tree of frames."""

from typing import Any

from sceneq_core.arrays import Float64
from sceneq_core.ingest.frame_tree import (
    NS_PER_S,
    ExtrapolationError,
    FrameError,
    FrameTree,
    FrameTreeParams,
    StampedTransform,
)
from sceneq_nodes.ros.params import ODOMETRY, PoseParams
from sceneq_nodes.ros.stamped_poses import odometry_transform, pose_transform, tf_transforms
from sceneq_nodes.ros.troubles import Troubles


class Poses:
    """Keeps what comes and answers where a frame was."""

    def __init__(self, params: PoseParams, troubles: Troubles) -> None:
        self._params = params
        self._troubles = troubles
        self._world = params.world_frame if params.kind == "tf" else ""
        self._posed = ""
        self.tree = FrameTree(FrameTreeParams(keep_s=max(10.0, 5 * params.wait_s)))

    def take_tf(self, message: Any, is_static: bool) -> None:
        """Learn a tf2_msgs/TFMessage; what would not be a tree is a trouble."""
        for transform in tf_transforms(message, is_static):
            # Whose pose comes on a topic is often told by tf as well: once is enough.
            if transform.child != self._posed:
                self._add(transform)

    def take_pose(self, message: Any, colour_frame: str) -> None:
        """Learn a message of the pose topic."""
        child = self._params.camera_frame or colour_frame
        if self._params.type == ODOMETRY:
            transform = odometry_transform(message, child)
        elif child:
            transform = pose_transform(message, child)
        else:
            return  # of a camera whose name the first image will tell
        self._world, self._posed = transform.parent, transform.child
        self._add(transform)

    def lookup(self, frame: str, stamp_ns: int, newest_ns: int) -> Float64 | None:
        """Return T_world_frame (4, 4), ``None`` while it may still come.

        Raises:
            FrameError: it will not come any more.
        """
        try:
            if not self._world:
                raise ExtrapolationError(f"nothing on {self._params.topic} so far", True)
            return self.tree.lookup(self._world, frame, stamp_ns)
        except FrameError as error:
            # Motion of the past will not come any more; frames nobody mentioned yet may.
            is_past = isinstance(error, ExtrapolationError) and not error.is_ahead
            if is_past or newest_ns - stamp_ns > self._params.wait_s * NS_PER_S:
                raise
            return None

    def set_back(self, stamp_ns: int) -> None:
        """Start anew after the clock was set back; static transforms still hold."""
        self.tree.set_back(stamp_ns)

    def _add(self, transform: StampedTransform) -> None:
        try:
            self.tree.add(transform)
        except ValueError as error:
            self._troubles.note("bad_transform", str(error))
