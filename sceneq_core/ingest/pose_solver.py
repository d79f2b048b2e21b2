"""The poses that fit measured motions between them best."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.ingest.transforms import inverse, nearest_rigid


@dataclass(frozen=True, slots=True)
class Edge:
    """``T_a_b`` (4, 4) between poses number ``a`` and ``b``.

    ``information`` (6, 6) of rotation (rad) and translation (m) about the axes of ``b``;
    ``measured`` by images, and so possibly false, or else by odometry.
    """

    a: int
    b: int
    T_a_b: Float64
    information: Float64
    measured: bool


def about_source(information: Float64, T_target_source: Float64) -> Float64:
    """Return information (6, 6) about the target's axes as that about those of the source."""
    rotation, (x, y, z) = T_target_source[:3, :3], T_target_source[:3, 3]
    adjoint = np.zeros((6, 6))
    adjoint[:3, :3] = adjoint[3:, 3:] = rotation
    adjoint[3:, :3] = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]) @ rotation
    about: Float64 = adjoint.T @ information @ adjoint
    return about


class PoseSolver:
    """Open3D's pose graph: Levenberg-Marquardt with line processes that switch off false edges.

    Choi et al. 2015, DOI 10.1109/CVPR.2015.7299195. ``edge_m``: a measured edge that the others
    contradict by more than about that is left out.
    """

    def __init__(self, edge_m: float) -> None:
        self._edge_m = edge_m

    def solve(self, poses: list[Float64], edges: list[Edge]) -> list[Float64]:
        """Return the poses T_world_camera (4, 4) that fit best; the first one stays."""
        # Imported here: it takes a second or two, and only a closed loop needs it.
        from open3d import pipelines, utility

        registration = pipelines.registration
        graph = registration.PoseGraph()
        for T_world_camera in poses:
            graph.nodes.append(registration.PoseGraphNode(T_world_camera))
        for edge in edges:
            graph.edges.append(
                registration.PoseGraphEdge(
                    edge.b, edge.a, edge.T_a_b, edge.information, uncertain=edge.measured
                )
            )
        with utility.VerbosityContextManager(utility.VerbosityLevel.Error):
            registration.global_optimization(
                graph,
                registration.GlobalOptimizationLevenbergMarquardt(),
                registration.GlobalOptimizationConvergenceCriteria(),
                registration.GlobalOptimizationOption(
                    max_correspondence_distance=self._edge_m,
                    edge_prune_threshold=0.25,
                    preference_loop_closure=1.0,
                    reference_node=0,
                ),
            )
        # The solver keeps the reference only up to rounding.
        solved = [np.array(node.pose) for node in graph.nodes]
        T_back = poses[0] @ inverse(solved[0])
        return [nearest_rigid(T_back @ T_world_camera) for T_world_camera in solved]
