"""A room of coloured sheets of points, cut into patches as the map does, and a graph over it."""

import numpy as np

from sceneq_core.mapping.boxes import box_around
from sceneq_core.mapping.delta import CONFIRMED, Instance
from sceneq_core.mapping.scene_graph import SceneGraph, SceneGraphParams

STEP_M, CELL_M = 0.025, 0.16
WHITE, GREY, BROWN = (220, 220, 220), (120, 120, 120), (120, 80, 40)
RED, BLUE = (200, 30, 30), (30, 40, 180)


class Sheets:
    """Rectangles of points by name, and boxes made of them."""

    def __init__(self):
        self.names, self.points, self.normals, self.rgb = [], [], [], []

    def sheet(self, name, rgb, origin, u, v, normal):
        """Add a rectangle at ``origin`` with the edges ``u`` and ``v``, metres."""
        u, v = np.asarray(u, float), np.asarray(v, float)
        long, wide = np.linalg.norm(u), np.linalg.norm(v)
        a, b = np.meshgrid(np.arange(STEP_M / 2, long, STEP_M), np.arange(STEP_M / 2, wide, STEP_M))
        points = np.asarray(origin) + a.reshape(-1, 1) * u / long + b.reshape(-1, 1) * v / wide
        self.names += [name] * len(points)
        self.points.append(points)
        self.normals.append(np.broadcast_to(np.asarray(normal, float), points.shape))
        self.rgb.append(np.broadcast_to(np.asarray(rgb), points.shape))
        return self

    def box(self, name, rgb, low, high, sides="xXyYZ"):
        """Add the faces of a box: small letters the lower, capitals the upper end of an axis."""
        low, size = np.asarray(low, float), np.asarray(high, float) - np.asarray(low, float)
        for side in sides:
            axis, upper = "xyz".index(side.lower()), side.isupper()
            edges = [np.eye(3)[other] * size[other] for other in range(3) if other != axis]
            normal = np.eye(3)[axis] * (1 if upper else -1)
            self.sheet(name, rgb, low + normal * size * upper, *edges, normal)
        return self


class Surface:
    """Stands in for voxels and superpoints: a point is a voxel, a cell of a name a patch."""

    def __init__(self, sheets, turn):
        self.points = np.concatenate(sheets.points) @ turn.T
        self.normals = np.concatenate(sheets.normals) @ turn.T
        self.colours = np.concatenate(sheets.rgb).astype(np.uint8)
        self.names = np.array(sheets.names)
        number = np.unique(self.names, return_inverse=True)[1]
        facing = np.rint(self.normals * 2).astype(int)
        keys = np.column_stack((number, facing, np.floor(self.points / CELL_M).astype(int)))
        self.superpoint = np.unique(keys, axis=0, return_inverse=True)[1].reshape(-1)

    def __len__(self):
        return int(self.superpoint.max()) + 1

    def of(self, voxel_id):
        return self.superpoint[voxel_id].astype(np.int32)

    def means_and_normals(self, voxel_id):
        points = self.points[voxel_id].astype(np.float32)
        return points, self.colours[voxel_id], self.normals[voxel_id]

    def instances(self, up_world):
        """Return an instance per name, ids from 1 in the order of the names."""
        return {
            str(name): self._instance(number + 1, self.names == name, up_world)
            for number, name in enumerate(np.unique(self.names))
        }

    def _instance(self, number, mine, up_world):
        box = box_around(self.points[mine].astype(np.float32), up_world)
        return Instance(
            instance_id=number,
            state=CONFIRMED,
            merged_into=0,
            parent=0,
            superpoint_id=np.unique(self.superpoint[mine]).astype(np.int32),
            voxel_count=int(mine.sum()),
            centre_world=box.centre_world,
            aabb_world=box.aabb_world,
            T_world_box=box.T_world_box,
            box_size_m=box.box_size_m,
            first_seen_ns=0,
            last_seen_ns=0,
        )


def empty_room():
    """A floor, two walls and a ceiling, seen from inside."""
    return (
        Sheets()
        .sheet("floor", GREY, (0, 0, 0), (4, 0, 0), (0, 3, 0), (0, 0, 1))
        .sheet("ceiling", WHITE, (0, 0, 2.5), (4, 0, 0), (0, 3, 0), (0, 0, -1))
        .sheet("wall_x", WHITE, (0, 0, 0), (0, 3, 0), (0, 0, 2.5), (1, 0, 0))
        .sheet("wall_y", WHITE, (0, 0, 0), (4, 0, 0), (0, 0, 2.5), (0, 1, 0))
    )


def furnished_room():
    """The empty room with things on, in, under and next to each other."""
    room = empty_room()
    room.sheet("table", BROWN, (1.5, 1.2, 0.7), (1.2, 0, 0), (0, 0.8, 0), (0, 0, 1))
    for x, y in ((1.5, 1.2), (2.6, 1.2), (1.5, 1.9), (2.6, 1.9)):
        room.box("table", BROWN, (x, y, 0), (x + 0.1, y + 0.1, 0.7), "xXyY")
    room.box("cup", RED, (1.9, 1.5, 0.7), (2.0, 1.6, 0.82))
    room.box("stool", BLUE, (2.8, 1.4, 0.0), (3.1, 1.7, 0.45))
    room.box("lamp", BLUE, (3.3, 0.5, 2.1), (3.6, 0.8, 2.5), "xXyYz")
    room.sheet("rug", RED, (1.4, 2.1, 0.005), (1.2, 0, 0), (0, 0.8, 0), (0, 0, 1))
    room.sheet("picture", BLUE, (0.012, 1.2, 1.2), (0, 0.6, 0), (0, 0, 0.4), (1, 0, 0))
    room.box("shelf", BROWN, (0.0, 0.0, 0.0), (0.3, 0.8, 1.2), "yYZ")
    for height in (0.3, 0.6, 0.9):
        room.sheet("shelf", BROWN, (0, 0, height), (0.3, 0, 0), (0, 0.8, 0), (0, 0, 1))
    room.box("book", RED, (0.06, 0.3, 0.6), (0.24, 0.36, 0.8))
    return room


class GraphedRoom:
    """A scene graph that has seen a room; ``turn`` (3, 3) turns the world with everything in it."""

    def __init__(self, sheets, turn=None, params=None):
        self.turn = np.eye(3) if turn is None else turn
        self.up_world = self.turn @ [0.0, 0.0, 1.0]
        self.surface = Surface(sheets, self.turn)
        self.graph = SceneGraph(params or SceneGraphParams(), STEP_M)
        self.by_name = self.surface.instances(self.up_world)
        self.told = self.update(tuple(self.by_name.values()))

    def update(self, news, rounds=8):
        """Tell the graph of ``news``; return all it told until it had nothing left to work out."""
        none = np.zeros(0, np.int32)
        every = np.arange(len(self.surface.points), dtype=np.int32)
        told = [self._step(every, news)]
        told += [self._step(none, ()) for _ in range(rounds)]
        return [one for some in told for one in some]

    def _step(self, renewed, news):
        none = np.zeros(0, np.int32)
        return self.graph.update(self.surface, self.surface, renewed, none, news, self.up_world)

    def name(self, instance_id):
        found = [n for n, one in self.by_name.items() if one.instance_id == instance_id]
        return found[0] if found else ""

    def of(self, name):
        return self.graph.instances[self.by_name[name].instance_id]

    def relations(self):
        """Return role, carrier, holder and neighbours of everything, by name."""
        return {
            name: (
                one.role,
                self.name(one.supported_by),
                self.name(one.inside),
                sorted(self.name(n) for n in one.neighbour_id.tolist()),
            )
            for name in self.by_name
            for one in [self.of(name)]
        }
