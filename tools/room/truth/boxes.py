"""Boxes and outlines of things in the world, from the exact vertices of their meshes."""

from dataclasses import dataclass

import cv2
import numpy as np

from sceneq_core.arrays import Float64
from sceneq_tools.room.room import Thing


@dataclass(frozen=True, slots=True, eq=False)
class OrientedBox:
    """A box along a thing's own axes: world ``centre`` (3,), ``size`` (3,) metres, own axes.

    ``axes`` (3, 3) holds the box's axes in world coordinates as columns.
    """

    centre: Float64
    size: Float64
    axes: Float64


@dataclass(frozen=True, slots=True, eq=False)
class Outline:
    """A thing seen from above: convex ``corners`` (N, 2) world metres, and how high it reaches."""

    corners: Float64
    low_m: float
    high_m: float

    @property
    def centre(self) -> Float64:
        """Middle of the bounding rectangle, (2,)."""
        middle: Float64 = (self.corners.min(0) + self.corners.max(0)) / 2
        return middle


def vertices_world(thing: Thing) -> Float64:
    """Return the vertices that belong to a face, (N, 3) world metres."""
    used = np.unique(thing.mesh.faces)
    own = thing.mesh.vertices[used].astype(np.float64)
    T_world_thing = thing.T_world_thing
    moved: Float64 = own @ T_world_thing[:3, :3].T + T_world_thing[:3, 3]
    return moved


def world_box(thing: Thing) -> Float64:
    """Return the axis-aligned box (2, 3): lowest and highest corner, world metres."""
    points_world = vertices_world(thing)
    return np.stack([points_world.min(0), points_world.max(0)])


def oriented_box(thing: Thing) -> OrientedBox:
    """Return the smallest box along the thing's own axes."""
    own = thing.mesh.vertices[np.unique(thing.mesh.faces)].astype(np.float64)
    low, high = own.min(0), own.max(0)
    T_world_thing = thing.T_world_thing
    axes, origin = T_world_thing[:3, :3], T_world_thing[:3, 3]
    return OrientedBox(axes @ ((low + high) / 2) + origin, high - low, axes.copy())


def outline(thing: Thing) -> Outline:
    """Return the convex outline from above and the heights of a thing."""
    points_world = vertices_world(thing)
    # The hull is searched in single precision around the thing, where that is micrometres.
    origin = points_world[0, :2]
    hull = cv2.convexHull((points_world[:, :2] - origin).astype(np.float32))
    corners = hull[:, 0].astype(np.float64) + origin
    return Outline(corners, float(points_world[:, 2].min()), float(points_world[:, 2].max()))


def box_gap(a: Float64, b: Float64) -> float:
    """Return the distance between two axis-aligned boxes (2, 3), 0 where they touch."""
    return float(np.linalg.norm(np.maximum(0, np.maximum(a[0] - b[1], b[0] - a[1]))))


def level_gap(a: Outline, b: Outline) -> float:
    """Return the distance between two outlines in the plane, metres; 0 where they touch."""
    if _touch(a.corners, b.corners):
        return 0.0
    return min(_corner_to_edge(a.corners, b.corners), _corner_to_edge(b.corners, a.corners))


def height_gap(a: Outline, b: Outline) -> float:
    """Return the free height between two things, 0 where their heights overlap."""
    return max(0.0, a.low_m - b.high_m, b.low_m - a.high_m)


def gap(a: Outline, b: Outline) -> float:
    """Return the distance between two upright prisms over the outlines, metres."""
    return float(np.hypot(level_gap(a, b), height_gap(a, b)))


def covered_share(a: Outline, b: Outline) -> float:
    """Return the share of ``a``'s outline that lies in ``b``'s, 0 to 1."""
    origin = a.corners[0]
    mine = (a.corners - origin).astype(np.float32)
    theirs = (b.corners - origin).astype(np.float32)
    area = cv2.contourArea(mine)
    shared, _ = cv2.intersectConvexConvex(mine, theirs)
    return min(1.0, float(shared) / area) if area > 0 else 0.0


def _touch(a: Float64, b: Float64) -> bool:
    """Tell by separating axes whether two convex polygons share a point."""
    for polygon in (a, b):
        edges = np.roll(polygon, -1, axis=0) - polygon
        normals = np.column_stack([edges[:, 1], -edges[:, 0]])
        on_a, on_b = a @ normals.T, b @ normals.T
        if ((on_a.max(0) < on_b.min(0)) | (on_b.max(0) < on_a.min(0))).any():
            return False
    return True


def _corner_to_edge(corners: Float64, polygon: Float64) -> float:
    """Return the least distance from corners (N, 2) to the edges of a polygon (M, 2)."""
    edges = np.roll(polygon, -1, axis=0) - polygon
    offsets = corners[:, None] - polygon[None]
    length2 = np.maximum((edges**2).sum(-1), 1e-12)
    along = np.clip((offsets * edges).sum(-1) / length2, 0.0, 1.0)
    return float(np.linalg.norm(offsets - along[..., None] * edges, axis=-1).min())
