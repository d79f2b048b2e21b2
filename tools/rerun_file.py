"""The map as a recording for the Rerun viewer: `rerun OUT/scene.rrd`."""

from pathlib import Path

from sceneq_nodes._caption import caption
from sceneq_nodes._viewer_eye import Eyes
from sceneq_nodes._viewer_layout import map_layout
from sceneq_nodes._viewer_map import MapLog
from sceneq_nodes._viewer_output import need_rerun
from sceneq_tools.errors import UserError
from sceneq_tools.scene_files import SceneFiles


def write_rerun(files: SceneFiles, path: Path) -> None:
    """Write the cloud in its own and in instance colours, and the oriented boxes with captions.

    Raises:
        UserError: Rerun is not installed.
    """
    try:
        need_rerun()
    except ValueError as error:
        raise UserError(str(error)) from error
    import rerun as rr

    recording = rr.RecordingStream("sceneq", recording_id=files.scene)
    recording.save(path, default_blueprint=map_layout(Eyes().look(files.replica)))
    captions = {record["id"]: caption(record) for record in files.instances}
    MapLog(recording).log(files.replica, captions)
    recording.flush()
    recording.disconnect()
