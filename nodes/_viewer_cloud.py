"""The voxels of a map as point clouds of a Rerun recording."""

import zlib
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from sceneq_core.arrays import Bool, Float32, UInt8
from sceneq_core.mapping.replica import MapReplica
from sceneq_core.picture.colours import instance_colours

BLOCK = 8192
"""Voxels of neighbouring ids, seen about the same time, are one entity: what changes is logged."""
NOT_LOGGED = -1
SCATTER = np.uint32(2654435761)
"""Knuth's multiplier: ids that follow each other are thinned out without a pattern."""

Colours = Callable[[MapReplica], UInt8]


def by_colour(replica: MapReplica) -> UInt8:
    """Return the measured colours, uint8 (N, 3), by voxel id."""
    return replica.rgb


def by_instance(replica: MapReplica) -> UInt8:
    """Return a colour per instance, uint8 (N, 3), by voxel id; faint grey = none."""
    return instance_colours(replica.instance_of_voxel(), replica.rgb)


def by_superpoint(replica: MapReplica) -> UInt8:
    """Return a colour per superpoint, uint8 (N, 3), by voxel id; faint grey = none."""
    return instance_colours(replica.superpoint_id + np.int32(1), replica.rgb)


@dataclass(slots=True)
class CloudLog:
    """One cloud of a recording, in blocks; a block is logged when it differs from the last time.

    Attributes:
        path: entity that holds the blocks.
        colours: how voxels are coloured.
        max_points: a larger map is shown by this many of its points at most.
    """

    path: str
    colours: Colours
    max_points: int
    _logged: dict[int, int] = field(default_factory=dict)

    def log(self, recording: Any, replica: MapReplica) -> int:
        """Bring the recording up to date; return the number of points logged."""
        if not (replica.voxel_count or self._logged):
            return 0
        thinning = thinning_of(int(replica.alive.sum()), self.max_points)
        shown = replica.alive & kept(replica.voxel_count, thinning)
        radius_m = replica.voxel_size_m / 2 * thinning**0.5
        colours = self.colours(replica) if replica.voxel_count else replica.rgb
        blocks = max(-(-replica.voxel_count // BLOCK), len(self._logged))
        count = 0
        for block in range(blocks):
            rows = slice(block * BLOCK, (block + 1) * BLOCK)
            points_world, rgb = replica.points_world[rows][shown[rows]], colours[rows][shown[rows]]
            mark = zlib.crc32(rgb.tobytes(), zlib.crc32(points_world.tobytes()))
            if self._logged.get(block) != mark:
                self._logged.pop(block, None)  # the dict is in the order of logging
                self._logged[block] = mark
                recording.log(f"{self.path}/{block}", _points(points_world, rgb, radius_m))
                count += len(points_world)
        return count

    def forget_oldest(self) -> None:
        """Log the block that was logged longest ago anew next time."""
        oldest = next(iter(self._logged), None)
        if oldest is not None:
            self._logged[oldest] = NOT_LOGGED


def thinning_of(count: int, max_points: int) -> int:
    """Return the power of two of which one in so many of ``count`` points may be shown."""
    thinning = 1
    while count > thinning * max_points:
        thinning *= 2
    return thinning


def kept(count: int, thinning: int) -> Bool:
    """Return which voxel ids (``count``,) are shown; always the same ones."""
    scattered = (np.arange(count, dtype=np.uint32) * SCATTER) >> np.uint32(8)
    shown: Bool = scattered % np.uint32(thinning) == 0
    return shown


def _points(points_world: Float32, rgb: UInt8, radius_m: float) -> Any:
    import rerun as rr

    return rr.Points3D(points_world, colors=rgb, radii=radius_m)
