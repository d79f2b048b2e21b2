"""Where frames lie to each other over time: a tree of rigid motions with a short memory."""

from bisect import bisect_left, insort
from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.checks import need_positive
from sceneq_core.ingest.quaternion import rigid_from_quaternion, slerp, unit_quaternion
from sceneq_core.ingest.transforms import inverse

NS_PER_S = 1e9
TOO_FAR_M = 1e7
"""Farther than any two frames on Earth that a map can hold; also what is not finite."""


class FrameError(ValueError):
    """The tree cannot tell, or would not be a tree any more."""


class UnknownFrameError(FrameError):
    """Nothing was ever said about a frame."""


class UnconnectedError(FrameError):
    """Two frames are in different trees."""


class ExtrapolationError(FrameError):
    """A time before, after or in a gap of what was said; ``is_ahead``: it may still be said."""

    def __init__(self, message: str, is_ahead: bool) -> None:
        super().__init__(message)
        self.is_ahead = is_ahead


class TopologyError(FrameError):
    """A second parent, or a frame that would be its own ancestor."""


@dataclass(frozen=True, slots=True)
class FrameTreeParams:
    """``keep_s`` seconds of motion are remembered; over ``max_gap_s`` nothing is interpolated."""

    keep_s: float = 10.0
    max_gap_s: float = 2.0

    def __post_init__(self) -> None:
        need_positive(self, "keep_s", "max_gap_s")


@dataclass(frozen=True, slots=True)
class StampedTransform:
    """``child`` in the coordinates of ``parent``: metres, unit quaternion x y z w.

    ``is_static``: it holds for all times, before ``stamp_ns`` too.
    """

    stamp_ns: int
    parent: str
    child: str
    xyz_m: Float64
    xyzw: Float64
    is_static: bool = False


class FrameTree:
    """Frames and their motions, as ROS tf2 has them (Foote 2013, DOI 10.1109/TePRA.2013.6556373).

    Between two stamps positions are interpolated linearly and rotations along the shorter arc.
    """

    def __init__(self, params: FrameTreeParams | None = None) -> None:
        self._params = params or FrameTreeParams()
        self._edges: dict[str, _Edge] = {}
        self._parents: set[str] = set()

    def add(self, transform: StampedTransform) -> None:
        """Learn one motion; an earlier one of the same stamp is replaced.

        Raises:
            TopologyError: the child has another parent already, or the frames would form a circle.
            ValueError: not finite, absurdly far, or no unit quaternion.

        In both cases the tree is unchanged.
        """
        parent, child = transform.parent, transform.child
        if not (np.abs(transform.xyz_m) < TOO_FAR_M).all():
            raise ValueError(f"{parent} -> {child}: translation {transform.xyz_m.tolist()} m")
        xyzw = unit_quaternion(transform.xyzw)
        edge = self._edges.get(child)
        if edge is None:
            self._need_no_circle(parent, child)
            edge = self._edges[child] = _Edge(parent, child)
            self._parents.add(parent)
        elif edge.parent != parent:
            raise TopologyError(f"frame '{child}' has two parents: '{edge.parent}' and '{parent}'")
        xyz_m = np.array(transform.xyz_m, np.float64)
        edge.add(_Pose(transform.stamp_ns, xyz_m, xyzw), transform.is_static, self._params)

    def lookup(self, target: str, source: str, stamp_ns: int) -> Float64:
        """Return T_target_source (4, 4) at ``stamp_ns``.

        Raises:
            UnknownFrameError: a frame that nobody mentioned.
            UnconnectedError: no way from one frame to the other.
            ExtrapolationError: the way was not known at that time, or is not yet.
        """
        if target == source:
            return np.eye(4)
        up_source, up_target = self._way_up(source), self._way_up(target)
        common = next((frame for frame in up_source if frame in up_target), None)
        if common is None:
            raise UnconnectedError(
                f"no transform between '{target}' and '{source}': their roots are "
                f"'{up_target[-1]}' and '{up_source[-1]}'"
            )
        T_common_source = self._chain(up_source[: up_source.index(common)], stamp_ns)
        T_common_target = self._chain(up_target[: up_target.index(common)], stamp_ns)
        return inverse(T_common_target) @ T_common_source

    def frames(self) -> list[str]:
        """Return the names of all frames, sorted."""
        return sorted(self._parents | set(self._edges))

    def knows(self, frame: str) -> bool:
        """Tell whether ``frame`` was ever mentioned."""
        return frame in self._edges or frame in self._parents

    def set_back(self, stamp_ns: int) -> None:
        """Forget motion that is later than ``stamp_ns`` can be: the clock was set back to it."""
        latest_ns = stamp_ns + self._params.keep_s * NS_PER_S
        edges = {child: edge for child, edge in self._edges.items() if edge.set_back(latest_ns)}
        self._edges, self._parents = edges, {edge.parent for edge in edges.values()}

    def _chain(self, frames: list[str], stamp_ns: int) -> Float64:
        """Return the motion from the first of ``frames`` to the parent of the last."""
        T_above_first = np.eye(4)
        for frame in frames:
            T_above_first = self._edges[frame].at(stamp_ns, self._params) @ T_above_first
        return T_above_first

    def _way_up(self, frame: str) -> list[str]:
        if not self.knows(frame):
            known = ", ".join(self.frames()) or "none"
            raise UnknownFrameError(f"unknown frame '{frame}' (known: {known})")
        way = [frame]
        while (edge := self._edges.get(way[-1])) is not None:
            way.append(edge.parent)
        return way

    def _need_no_circle(self, parent: str, child: str) -> None:
        above = self._way_up(parent) if self.knows(parent) else [parent]
        if child in above:
            circle = " -> ".join([child, *above[: above.index(child) + 1]])
            raise TopologyError(f"frames form a circle: {circle}")


@dataclass(frozen=True, slots=True)
class _Pose:
    stamp_ns: int
    xyz_m: Float64
    xyzw: Float64

    @property
    def T_parent_child(self) -> Float64:
        return rigid_from_quaternion(self.xyz_m, self.xyzw)


class _Edge:
    """One frame in its parent: poses in the order of their stamps."""

    def __init__(self, parent: str, child: str) -> None:
        self.parent, self.is_static = parent, False
        self._name = f"{parent} -> {child}"
        self._poses: list[_Pose] = []

    def add(self, pose: _Pose, is_static: bool, params: FrameTreeParams) -> None:
        if is_static:
            self.is_static, self._poses = True, [pose]
            return
        self.is_static = False
        if self._poses and self._poses[-1].stamp_ns - pose.stamp_ns > params.keep_s * NS_PER_S:
            self._poses = []  # far before all that is remembered: another clock
        at = bisect_left(self._poses, pose.stamp_ns, key=_stamp)
        if at < len(self._poses) and self._poses[at].stamp_ns == pose.stamp_ns:
            self._poses[at] = pose
        else:
            insort(self._poses, pose, key=_stamp)
        oldest_ns = self._poses[-1].stamp_ns - params.keep_s * NS_PER_S
        del self._poses[: bisect_left(self._poses, oldest_ns, key=_stamp)]

    def set_back(self, latest_ns: float) -> bool:
        """Forget what is later; tell whether anything is left."""
        if not self.is_static:
            self._poses = [pose for pose in self._poses if pose.stamp_ns <= latest_ns]
        return bool(self._poses)

    def at(self, stamp_ns: int, params: FrameTreeParams) -> Float64:
        if self.is_static:
            return self._poses[0].T_parent_child
        poses, after = self._poses, bisect_left(self._poses, stamp_ns, key=_stamp)
        if after < len(poses) and poses[after].stamp_ns == stamp_ns:
            return poses[after].T_parent_child
        if after == 0:
            self._refuse("before the first", poses[0].stamp_ns - stamp_ns, is_ahead=False)
        if after == len(poses):
            self._refuse("after the last", stamp_ns - poses[-1].stamp_ns, is_ahead=True)
        return self._between(poses[after - 1], poses[after], stamp_ns, params)

    def _between(self, a: _Pose, b: _Pose, stamp_ns: int, params: FrameTreeParams) -> Float64:
        gap_ns = b.stamp_ns - a.stamp_ns
        if gap_ns > params.max_gap_s * NS_PER_S:
            self._refuse("in a gap of the", gap_ns, is_ahead=False)
        share = (stamp_ns - a.stamp_ns) / gap_ns
        xyz_m = (1.0 - share) * a.xyz_m + share * b.xyz_m
        return rigid_from_quaternion(xyz_m, slerp(a.xyzw, b.xyzw, share))

    def _refuse(self, where: str, by_ns: int, is_ahead: bool) -> None:
        message = f"{self._name}: {where} known transform by {by_ns / NS_PER_S:.3f} s"
        raise ExtrapolationError(message, is_ahead)


def _stamp(pose: _Pose) -> int:
    return pose.stamp_ns
