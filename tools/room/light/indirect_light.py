"""Light that comes by way of other surfaces."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Float32, Int32
from sceneq_tools.room.light.direct_light import Receivers
from sceneq_tools.room.light.raycaster import Raycaster
from sceneq_tools.room.light.stage import Stage

GOLDEN = 0.6180339887
FEELERS = 6  # short rays that tell a gap from a surface


@dataclass(frozen=True, slots=True, eq=False)
class Views:
    """What each receiver sees around it: N receivers, R rays.

    Attributes:
        face: int32 (R, N), -1 for nothing.
        side: int8 (R, N), 0 where its front is seen and 1 where its back is.
    """

    face: Int32
    side: np.ndarray[tuple[int, ...], np.dtype[np.int8]]


def views(to: Receivers, raycaster: Raycaster, rays: int) -> Views:
    """Look from each receiver in ``rays`` directions, dense where light counts most (cosine)."""
    face = np.empty((rays, len(to.positions)), np.int32)
    side = np.empty(face.shape, np.int8)
    for k, ray in enumerate(_directions(to, rays)):
        hits = raycaster.nearest_solid(to.positions, ray)
        face[k] = hits.face
        side[k] = np.einsum("ij,ij->i", hits.normal, ray) > 0
    return Views(face, side)


def openness(to: Receivers, raycaster: Raycaster, reach_m: float) -> Float32:
    """Return the share (N,) of short rays that meet nothing: 0 in narrow gaps."""
    free = np.zeros(len(to.positions), np.float32)
    for ray in _directions(to, FEELERS):
        free += ~raycaster.occluded(to.positions, ray * np.float32(reach_m), reach=1.0)
    return free / np.float32(FEELERS)


def _directions(to: Receivers, count: int) -> Iterator[Float32]:
    """Yield ``count`` unit vectors (N, 3), spread by cosine over each one's hemisphere."""
    tangent, bitangent = _frame(to.normals)
    for k in range(count):
        out = ((k + to.jitter[:, 0]) / count)[:, None]
        angle = 2 * np.pi * ((k * GOLDEN + to.jitter[:, 1:]) % 1.0)
        flat = tangent * np.cos(angle) + bitangent * np.sin(angle)
        yield (flat * np.sqrt(out) + to.normals * np.sqrt(1 - out)).astype(np.float32)


def indirect_light(seen: Views, stage: Stage, irradiance: Float32) -> Float32:
    """Return the irradiance (N, 3) that what is seen sends on.

    ``irradiance`` is float32 (2, C, 3): at front and back of the coarse points.
    """
    total = np.zeros((seen.face.shape[1], 3), np.float32)
    for face, side in zip(seen.face, seen.side, strict=True):
        hit = np.flatnonzero(face >= 0)
        at = face[hit]
        total[hit] += stage.face_colour[at] * irradiance[side[hit], stage.coarse_of_face[at]]
    return total / np.float32(len(seen.face))


def _frame(normals: Float32) -> tuple[Float32, Float32]:
    """Return two unit vectors at right angles to each normal and to each other."""
    away = np.where(np.abs(normals[:, :1]) < 0.9, [[1.0, 0, 0]], [[0, 1.0, 0]])
    tangent = np.cross(normals, away)
    tangent /= np.maximum(np.linalg.norm(tangent, axis=1, keepdims=True), 1e-9)
    return tangent.astype(np.float32), np.cross(normals, tangent).astype(np.float32)
