"""Keyframes whose relative poses were measured, and the poses that fit all of them best."""

from dataclasses import dataclass, field, replace

import numpy as np

from sceneq_core.arrays import Float32, Float64, UInt16
from sceneq_core.checks import need_at_least, need_between, need_positive
from sceneq_core.ingest.alignment import Alignment, AlignmentParams, align_views, judge
from sceneq_core.ingest.depth_view import DepthView, DepthViewParams, depth_view, thin_depth
from sceneq_core.ingest.pose_solver import Edge, PoseSolver, about_source
from sceneq_core.ingest.shading import Shading
from sceneq_core.ingest.transforms import angle_deg, distance_m, inverse, nearest_rigid


@dataclass(frozen=True, slots=True)
class PoseGraphParams:
    """When two keyframes are taken to show the same surface, and what follows.

    ``candidates`` older keyframes are tried, those that a new one should overlap most, at least
    by ``min_overlap``, and be trusted by ``min_trust`` (see ``Alignment``); where pictures are too
    plain to tell, ``min_inliers`` of what overlaps has to lie on their surface. An alignment
    that is farther from where odometry says than ``slack_m`` (``slack_deg``) plus ``drift_share``
    of the way (``drift_deg_per_m``) is a false one. A keyframe that lies in another by
    ``same_overlap`` hangs on it and is no node: so the graph is bounded by the room, not by time.
    Poses are worth telling when one changed by ``news_m`` or ``news_deg``. ``edge_m``: a measured
    edge that the others contradict by more than about that is left out.
    """

    candidates: int = 4
    min_overlap: float = 0.3
    min_inliers: float = 0.6
    min_trust: float = 0.5
    same_overlap: float = 0.8
    slack_m: float = 0.08
    slack_deg: float = 3.0
    drift_share: float = 0.03
    drift_deg_per_m: float = 1.5
    news_m: float = 0.01
    news_deg: float = 0.4
    edge_m: float = 0.05
    odometry_points: float = 500.0
    view: DepthViewParams = field(default_factory=DepthViewParams)
    alignment: AlignmentParams = field(default_factory=lambda: AlignmentParams(reach_m=0.06))

    def __post_init__(self) -> None:
        need_at_least(self, 1, "candidates")
        need_between(self, 0, 1, "min_overlap", "min_inliers", "min_trust", "same_overlap")
        need_positive(self, "slack_m", "slack_deg", "news_m", "news_deg", "edge_m")
        need_positive(self, "odometry_points")
        need_at_least(self, 0, "drift_share", "drift_deg_per_m")


@dataclass(slots=True)
class _Node:
    """A keyframe that others are aligned with: where it is, what it saw, how far the way was."""

    T_world_camera: Float64
    thin_mm: UInt16
    K: Float64
    shade: Float32
    coarse: DepthView
    way_m: float


@dataclass(slots=True)
class _Keyframe:
    """A keyframe hangs rigidly on a node; ``T_world_first`` is the pose it was published with."""

    node: int
    T_node_camera: Float64
    T_world_first: Float64


@dataclass(frozen=True, slots=True)
class _Match:
    node: int
    found: Alignment


class PoseGraph:
    """Finds where each keyframe is among the earlier ones and spreads what does not fit.

    Poses are those of the depth camera. Attributes: ``closures`` edges that were measured,
    ``refused`` alignments that were no match, ``optimisations`` of the graph.
    """

    def __init__(self, params: PoseGraphParams) -> None:
        self._params = params
        self._solver = PoseSolver(params.edge_m)
        self._nodes: list[_Node] = []
        self._edges: dict[tuple[int, int], Edge] = {}
        self._keyframes: dict[int, _Keyframe] = {}
        self._last: _Keyframe | None = None
        self._T_odometry_last = np.eye(4)
        self._told: dict[int, Float64] = {}
        self._way_m = 0.0
        self.closures = self.refused = self.optimisations = 0

    def __len__(self) -> int:
        """Return the number of nodes."""
        return len(self._nodes)

    def pose(self, T_odometry_camera: Float64) -> Float64:
        """Return T_world_camera (4, 4) of a pose (4, 4) that odometry gives now."""
        if self._last is None:
            return T_odometry_camera
        T_last_now = inverse(self._T_odometry_last) @ T_odometry_camera
        return nearest_rigid(self._pose_of(self._last) @ T_last_now)

    def add(
        self,
        seq: int,
        T_odometry_camera: Float64,
        depth_mm: UInt16,
        K: Float64,
        shading: Shading | None = None,
    ) -> Float64:
        """Add a keyframe at the pose (4, 4) that odometry gives; return T_world_camera (4, 4)."""
        expected = self.pose(T_odometry_camera)
        if self._last is not None:
            self._way_m += distance_m(self._T_odometry_last, T_odometry_camera)
        thin_mm, K_thin = thin_depth(depth_mm, K, self._params.view)
        view = depth_view(thin_mm, K_thin, self._params.view).shaded(shading)
        matches = self._matches(view, expected)
        keyframe = self._hang(matches)
        if keyframe is None:
            keyframe = _Keyframe(len(self._nodes), np.eye(4), expected)
            node = _Node(expected, thin_mm, K_thin, view.shade, view.coarse, self._way_m)
            self._nodes.append(node)
        news = [self._connect(keyframe, match) for match in matches]
        # A keyframe that hangs on an old node closes the loop that odometry came along.
        closed = self._follow(keyframe, T_odometry_camera) and bool(matches)
        if closed or any(news):
            self._optimise()
        keyframe.T_world_first = self._pose_of(keyframe)
        self._keyframes[seq] = self._last = keyframe
        self._T_odometry_last = T_odometry_camera
        return keyframe.T_world_first

    def corrections(self) -> dict[int, Float64]:
        """Return all poses by seq that differ from those that ``add`` gave; {} = no news.

        They are news when one of them differs enough from what was last returned.
        """
        now = {seq: self._pose_of(keyframe) for seq, keyframe in self._keyframes.items()}
        if not any(self._is_news(seq, T) for seq, T in now.items()):
            return {}
        self._told = {
            seq: T
            for seq, T in now.items()
            if seq in self._told or not np.array_equal(T, self._keyframes[seq].T_world_first)
        }
        return dict(self._told)

    def _is_news(self, seq: int, T_world_camera: Float64) -> bool:
        told = self._told.get(seq, self._keyframes[seq].T_world_first)
        moved = distance_m(told, T_world_camera) >= self._params.news_m
        return moved or angle_deg(told, T_world_camera) >= self._params.news_deg

    def _pose_of(self, keyframe: _Keyframe) -> Float64:
        pose: Float64 = self._nodes[keyframe.node].T_world_camera @ keyframe.T_node_camera
        return pose

    def _matches(self, view: DepthView, expected: Float64) -> list[_Match]:
        """Return the nodes that show the same surface, the one that shows most of it first."""
        matches = []
        for number in self._candidates(view, expected):
            node = self._nodes[number]
            fine = replace(depth_view(node.thin_mm, node.K, self._params.view), shade=node.shade)
            guess = inverse(node.T_world_camera) @ expected
            found = align_views(view, fine, guess, self._params.alignment)
            if self._is_match(node, found, guess):
                matches.append(_Match(number, found))
            else:
                self.refused += 1
        return sorted(matches, key=lambda match: (-match.found.overlap, match.node))

    def _candidates(self, view: DepthView, expected: Float64) -> list[int]:
        overlaps = []
        for number, node in enumerate(self._nodes):
            guess = inverse(node.T_world_camera) @ expected
            if angle_deg(node.T_world_camera, expected) < 75.0:
                seen = judge(view.coarse, node.coarse, guess, self._params.alignment)
                overlaps.append((seen.overlap, number))
        overlaps = [pair for pair in overlaps if pair[0] >= self._params.min_overlap]
        return [number for _, number in sorted(overlaps, reverse=True)[: self._params.candidates]]

    def _is_match(self, node: _Node, found: Alignment, guess: Float64) -> bool:
        params, way_m = self._params, self._way_m - node.way_m
        plain = np.isnan(found.likeness) and found.inliers >= params.min_inliers
        trusted = plain or found.trust >= params.min_trust
        return (
            found.overlap >= params.min_overlap
            and trusted
            and distance_m(found.T_target_source, guess)
            <= params.slack_m + params.drift_share * way_m
            and angle_deg(found.T_target_source, guess)
            <= params.slack_deg + params.drift_deg_per_m * way_m
        )

    def _hang(self, matches: list[_Match]) -> _Keyframe | None:
        """Return a keyframe that hangs on the node that shows nearly the same, if there is one."""
        if not matches or matches[0].found.overlap < self._params.same_overlap:
            return None
        best = matches[0]
        return _Keyframe(best.node, best.found.T_target_source, np.eye(4))

    def _follow(self, keyframe: _Keyframe, T_odometry_camera: Float64) -> bool:
        """Tie the keyframe's node to that of the one before by odometry, unless they are tied."""
        last = self._last
        if last is None or last.node == keyframe.node:
            return False
        a, b = last.node, keyframe.node
        if (a, b) in self._edges or (b, a) in self._edges:
            return False
        T_last_now = inverse(self._T_odometry_last) @ T_odometry_camera
        T_a_b = last.T_node_camera @ T_last_now @ inverse(keyframe.T_node_camera)
        weight = self._params.odometry_points * np.eye(6)
        self._edges[(a, b)] = Edge(a, b, T_a_b, weight, False)
        return True

    def _connect(self, keyframe: _Keyframe, match: _Match) -> bool:
        """Tie the keyframe's node to a match; tell whether that is a new edge."""
        a, b, found = match.node, keyframe.node, match.found
        known = self._edges.get((a, b)) or self._edges.get((b, a))
        if a == b or (known and known.measured):
            return False
        T_a_b = found.T_target_source @ inverse(keyframe.T_node_camera)
        information = about_source(found.information, T_a_b)
        # Distances count by their noise; here a point counts as one.
        information = information / max(information[5, 5], 1e-9) * (1e4 * found.overlap)
        self._edges.pop((b, a), None)
        self._edges[(a, b)] = Edge(a, b, T_a_b, information, True)
        self.closures += 1
        return True

    def _optimise(self) -> None:
        poses = [node.T_world_camera for node in self._nodes]
        solved = self._solver.solve(poses, list(self._edges.values()))
        for node, T_world_camera in zip(self._nodes, solved, strict=True):
            node.T_world_camera = T_world_camera
        self.optimisations += 1
