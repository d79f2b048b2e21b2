"""Triangles small enough to carry light in their corners."""

import numpy as np

from sceneq_core.arrays import Bool, Float32, Int32
from sceneq_tools.room.mesh import Mesh

SLIVER = 0.12  # a triangle of less than this share of longest_m squared stays long: it has no area


def subdivided(mesh: Mesh, longest_m: float) -> Mesh:
    """Return the mesh with every edge at most ``longest_m``, slivers excepted.

    The longest edge is halved until none is too long. Neighbours share the new vertex, so a mesh
    stays as connected as it was; where a sliver stops earlier a T-junction is left, which rays do
    not mind.

    Raises:
        ValueError: ``longest_m`` is not positive.
    """
    if longest_m <= 0:
        raise ValueError(f"longest_m must be positive, got {longest_m}")
    corners = np.concatenate([mesh.vertices, mesh.normals, mesh.uv], axis=1, dtype=np.float32)
    faces, material = mesh.faces, mesh.material_index
    done_faces, done_material = [], []
    while len(faces):
        edge = _edge_lengths(corners, faces)
        long = _too_long(corners, faces, edge, longest_m)
        done_faces.append(faces[~long])
        done_material.append(material[~long])
        longest = edge[long].argmax(axis=1).astype(np.int32)
        corners, faces = _halved(corners, faces[long], longest)
        material = np.tile(material[long], 2)
    return _mesh(mesh, corners, done_faces, done_material)


def _edge_lengths(corners: Float32, faces: Int32) -> Float32:
    points = corners[faces, :3]
    lengths: Float32 = np.linalg.norm(points[:, [1, 2, 0]] - points, axis=2)
    return lengths


def _too_long(corners: Float32, faces: Int32, edge: Float32, longest_m: float) -> Bool:
    points = corners[faces, :3]
    cross = np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
    area = np.linalg.norm(cross, axis=1) / 2
    long: Bool = (edge.max(axis=1) > longest_m) & (area > SLIVER * longest_m**2)
    return long


def _halved(corners: Float32, faces: Int32, longest: Int32) -> tuple[Float32, Int32]:
    """Split each face at the middle of its ``longest`` edge; first halves first."""
    row = np.arange(len(faces))
    a, b, c = (faces[row, (longest + k) % 3] for k in range(3))
    ends = np.sort(np.stack([a, b], axis=1), axis=1)
    edges, of_face = np.unique(ends, axis=0, return_inverse=True)
    middles = (corners[edges[:, 0]] + corners[edges[:, 1]]) / 2
    m = (of_face.reshape(-1) + len(corners)).astype(np.int32)
    halves = np.concatenate([np.stack([a, m, c], axis=1), np.stack([m, b, c], axis=1)])
    return np.concatenate([corners, middles]), halves.astype(np.int32)


def _mesh(mesh: Mesh, corners: Float32, faces: list[Int32], material: list[Int32]) -> Mesh:
    normals = corners[:, 3:6]
    length = np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    return Mesh(
        np.ascontiguousarray(corners[:, :3]),
        (normals / length).astype(np.float32),
        np.ascontiguousarray(corners[:, 6:8]),
        np.concatenate([*faces, np.zeros((0, 3), np.int32)]).astype(np.int32),
        np.concatenate([*material, np.zeros(0, np.int32)]).astype(np.int32),
        mesh.materials,
    )
