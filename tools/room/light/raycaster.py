"""Where rays meet the triangles of a room."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from sceneq_core.arrays import Bool, Float32, Int32

STEP_M = 1e-4  # a ray that goes on behind a surface starts this far behind it
LAYERS = 64  # more surfaces of things that are gone are not looked behind


@dataclass(frozen=True, slots=True, eq=False)
class Hits:
    """The first surface on each ray.

    Attributes:
        distance: float32 (N,) in lengths of the ray's direction; infinite where nothing is.
        face: int32 (N,), -1 where nothing is.
        uv: float32 (N, 2) weights of the second and third corner.
        normal: float32 (N, 3) unit, of the flat triangle.
    """

    distance: Float32
    face: Int32
    uv: Float32
    normal: Float32


class TriangleGroup:
    """Triangles that were put into one acceleration structure together.

    ``face_of`` says which face of the room each of them is now, -1 for what is gone since;
    ``built_of`` which it was at first.
    """

    def __init__(self, vertices: Float32, faces: Int32, face_of: Int32) -> None:
        import open3d as o3d

        self._tensor = o3d.core.Tensor.from_numpy
        self._scene = o3d.t.geometry.RaycastingScene()
        if len(faces):
            used, local = np.unique(faces, return_inverse=True)
            corners = self._tensor(np.ascontiguousarray(vertices[used]))
            indices = self._tensor(local.reshape(-1, 3).astype(np.uint32))
            self._scene.add_triangles(corners, indices)
        self.face_of = self.built_of = face_of

    def renumbered(self, face_of: Int32) -> "TriangleGroup":
        """Return the same triangles under other face numbers, sharing the structure."""
        other = object.__new__(TriangleGroup)
        other._tensor, other._scene = self._tensor, self._scene
        other.built_of, other.face_of = self.built_of, face_of
        return other

    @property
    def complete(self) -> bool:
        """Whether nothing of it is gone."""
        return bool((self.face_of >= 0).all())

    def nearest(self, rays: Float32) -> Hits:
        """Return the first hit of rays (N, 6), looking through what is gone.

        What lies within ``STEP_M`` behind something gone is missed: put it into another group.
        """
        hits = self._cast(rays)
        for _ in range(LAYERS):
            gone = np.flatnonzero((hits.face < 0) & np.isfinite(hits.distance))
            if not len(gone):
                break
            start = hits.distance[gone] + _step(rays[gone])
            behind = rays[gone].copy()
            behind[:, :3] += behind[:, 3:] * start[:, None]
            further = self._cast(behind)
            _put(hits, gone, further, further.distance + start)
        return hits

    def occluded(self, rays: Float32, reach: float) -> Bool:
        """Return whether a triangle lies within ``reach`` lengths of the ray's direction."""
        if not len(self.face_of):
            return np.zeros(len(rays), bool)
        if not self.complete:
            return self.nearest(rays).distance < reach
        answer = self._scene.test_occlusions(self._tensor(rays), 0.0, reach)
        blocked: Bool = answer.numpy()
        return blocked

    def _cast(self, rays: Float32) -> Hits:
        if not len(self.face_of) or not len(rays):
            return _nothing(len(rays))
        answer = self._scene.cast_rays(self._tensor(rays))
        primitive = answer["primitive_ids"].numpy()
        distance = answer["t_hit"].numpy()
        missed = np.flatnonzero(np.isinf(distance))
        primitive[missed] = 0
        face = self.face_of[primitive]
        face[missed] = -1
        uv, normal = answer["primitive_uvs"].numpy(), answer["primitive_normals"].numpy()
        return Hits(distance, face, uv, normal)


class Raycaster:
    """What casts shadows, and all that can be seen: glass, lamps and cut-out leaves as well.

    What is solid is held twice: one walk through everything takes less than one through what is
    solid and another through the rest.
    """

    def __init__(
        self, solid: tuple[TriangleGroup, ...], visible: tuple[TriangleGroup, ...]
    ) -> None:
        self._solid = solid
        self._visible = visible

    def nearest(self, origins: Float32, directions: Float32) -> Hits:
        """Return the first surface of any kind on rays (N, 3), (N, 3)."""
        rays = _rays(origins, directions)
        return _first_of([group.nearest(rays) for group in self._visible], rays)

    def nearest_solid(self, origins: Float32, directions: Float32) -> Hits:
        """Return the first surface that blocks light."""
        rays = _rays(origins, directions)
        return _first_of([group.nearest(rays) for group in self._solid], rays)

    def occluded(self, origins: Float32, directions: Float32, reach: float = 0.999) -> Bool:
        """Return whether light is blocked between origin and origin + reach * direction."""
        rays = _rays(origins, directions)
        blocked = np.zeros(len(rays), bool)
        for group in self._solid:
            blocked |= group.occluded(rays, reach)
        return blocked


def _rays(origins: Float32, directions: Float32) -> Float32:
    rays = np.empty((len(directions), 6), np.float32)
    rays[:, :3], rays[:, 3:] = origins, directions
    return rays


def _step(rays: Float32) -> Float32:
    length: Float32 = np.linalg.norm(rays[:, 3:], axis=1)
    return (STEP_M / np.maximum(length, 1e-9)).astype(np.float32)


def _put(hits: Hits, where: Any, other: Hits, distance: Float32) -> None:
    hits.distance[where] = distance
    hits.face[where] = other.face
    hits.uv[where] = other.uv
    hits.normal[where] = other.normal


def _first_of(found: list[Hits], rays: Float32) -> Hits:
    nearest = found[0] if found else _nothing(len(rays))
    for other in found[1:]:
        closer = np.flatnonzero(other.distance < nearest.distance)
        if len(closer):
            chosen = Hits(
                other.distance[closer], other.face[closer], other.uv[closer], other.normal[closer]
            )
            _put(nearest, closer, chosen, chosen.distance)
    return nearest


def _nothing(count: int) -> Hits:
    return Hits(
        np.full(count, np.inf, np.float32),
        np.full(count, -1, np.int32),
        np.zeros((count, 2), np.float32),
        np.zeros((count, 3), np.float32),
    )
