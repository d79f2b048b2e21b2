"""The map as a recording for the Rerun viewer: `rerun OUT/scene.rrd`."""

from pathlib import Path

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.picture import instance_colours
from sceneq_tools.scene_files import SceneFiles, caption


def write_rerun(files: SceneFiles, path: Path) -> None:
    """Write the cloud in its own and in instance colours, and the oriented boxes with captions."""
    import rerun as rr

    points_world, rgb, instance_id = files.replica.cloud()
    radius_m = files.replica.voxel_size_m / 2
    recording = rr.RecordingStream("sceneq", recording_id=files.scene)
    recording.save(path)
    recording.log("world/colour", rr.Points3D(points_world, colors=rgb, radii=radius_m))
    colours = instance_colours(instance_id, rgb)
    recording.log("world/instances", rr.Points3D(points_world, colors=colours, radii=radius_m))
    boxes = [record["box_oriented"] for record in files.instances]
    rotations = [np.asarray(box["rotation"]) for box in boxes]
    if boxes:
        recording.log(
            "world/boxes",
            rr.Boxes3D(
                centers=[box["centre"] for box in boxes],
                sizes=[box["size"] for box in boxes],
                quaternions=[rr.Quaternion(xyzw=_xyzw(rotation)) for rotation in rotations],
                labels=[caption(record) for record in files.instances],
            ),
        )
    recording.flush()
    recording.disconnect()


def _xyzw(R_world_box: Float64) -> Float64:
    from scipy.spatial.transform import Rotation

    xyzw: Float64 = Rotation.from_matrix(R_world_box).as_quat()
    return xyzw
