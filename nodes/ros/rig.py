"""The two cameras of a frame, settled from calibration, frame names and transforms."""

from dataclasses import dataclass, replace

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.ingest.frame_tree import FrameError, FrameTree
from sceneq_core.ingest.source import Camera
from sceneq_core.ingest.undistortion import Lens, Undistortion
from sceneq_nodes.ros.params import Ros2Params


@dataclass(frozen=True, slots=True, eq=False)
class Rig:
    """Two cameras that do not change any more; ``T_color_depth`` (4, 4) as in a ``Source``.

    With a LiDAR, whose scans become depth in the colour camera, both are that one.
    """

    colour: Lens
    depth: Lens
    T_color_depth: Float64
    undistort_colour: Undistortion
    undistort_depth: Undistortion
    T_camera_lidar: Float64 | None = None

    @property
    def color_camera(self) -> Camera:
        """The colour camera without its distortion."""
        return Camera(self.colour.K, self.colour.size)

    @property
    def depth_camera(self) -> Camera:
        """The depth camera without its distortion."""
        return Camera(self.depth.K, self.depth.size)


class UnsettledError(ValueError):
    """Something is missing: ``kind`` of trouble."""

    def __init__(self, kind: str, message: str) -> None:
        super().__init__(message)
        self.kind = kind


@dataclass(frozen=True, slots=True)
class FirstFrame:
    """What the first synchronised images say of themselves; of a size unknown before decoding None.

    ``colour_frame`` and ``depth_frame`` are the names of the frames they were taken in.
    """

    stamp_ns: int
    colour_frame: str
    depth_frame: str
    depth_size: tuple[int, int] | None


def settle(params: Ros2Params, lenses: dict[str, Lens], tree: FrameTree, first: FirstFrame) -> Rig:
    """Return the rig; raise ``UnsettledError`` that says what it still needs."""
    colour = lenses.get("colour_info")
    if colour is None:
        topic = params.colour_info
        raise UnsettledError("no_camera_info", f"no usable CameraInfo on {topic} so far")
    if params.points_topic:
        return replace(_rig(colour, colour, np.eye(4)), T_camera_lidar=_extrinsics(tree, first))
    if _is_registered(params, first) and first.depth_size in (None, colour.size):
        return _rig(colour, colour, np.eye(4))
    depth = lenses.get("depth_info")
    if depth is None:
        topic = params.depth_info
        raise UnsettledError("no_camera_info", f"no usable CameraInfo of depth on {topic} so far")
    if _is_registered(params, first):
        return _rig(colour, depth, np.eye(4))
    try:
        T_color_depth = tree.lookup(first.colour_frame, first.depth_frame, first.stamp_ns)
    except FrameError as error:
        raise UnsettledError(
            "unregistered_depth",
            f"depth is in frame '{first.depth_frame}', colour in '{first.colour_frame}', and tf "
            f"does not say how they lie ({error}); take an aligned depth topic, publish tf_static, "
            "or say 'depth_registered: yes' if it is aligned",
        ) from error
    return _rig(colour, depth, T_color_depth)


def _extrinsics(tree: FrameTree, first: FirstFrame) -> Float64:
    try:
        return tree.lookup(first.colour_frame, first.depth_frame, first.stamp_ns)
    except FrameError as error:
        raise UnsettledError(
            "no_extrinsics",
            f"points are in frame '{first.depth_frame}', colour in '{first.colour_frame}', and tf "
            f"does not say how they lie ({error}): publish tf_static",
        ) from error


def _is_registered(params: Ros2Params, first: FirstFrame) -> bool:
    if params.depth_registered != "auto":
        return params.depth_registered == "yes"
    return first.colour_frame == first.depth_frame


def _rig(colour: Lens, depth: Lens, T_color_depth: Float64) -> Rig:
    undistort = Undistortion(colour)
    of_depth = undistort if depth is colour else Undistortion(depth)
    return Rig(colour, depth, T_color_depth, undistort, of_depth)
