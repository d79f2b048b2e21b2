"""The points of the map for a page that draws them.

Little endian: the bytes ``SQC1``, uint32 N, float32 up (3,), float32 positions (N, 3) in metres,
uint8 colours (N, 3) padded to a multiple of 4 bytes, int32 instances (N,), 0 = none.
"""

import numpy as np

from sceneq_core.mapping.replica import MapReplica

MAGIC = b"SQC1"
MEDIA_TYPE = "application/vnd.sceneq.cloud"


def cloud_bytes(replica: MapReplica, max_points: int) -> bytes:
    """Return the map's points, of a larger map every second, third, ... one."""
    points_world, rgb, instance_id = replica.cloud()
    every = max(1, -(-len(points_world) // max_points))
    points_world, rgb = points_world[::every], rgb[::every]
    colours = rgb.astype("<u1").tobytes()
    return b"".join(
        (
            MAGIC,
            np.uint32(len(points_world)).astype("<u4").tobytes(),
            np.asarray(replica.up_world, "<f4").tobytes(),
            points_world.astype("<f4").tobytes(),
            colours + bytes(-len(colours) % 4),
            instance_id[::every].astype("<i4").tobytes(),
        )
    )
