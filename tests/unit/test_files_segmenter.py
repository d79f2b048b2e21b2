"""Label images beside the frames."""

from pathlib import Path

import numpy as np

from sceneq_core.frame import Frame
from sceneq_nodes._files_segmenter import FilesSegmenter, FilesSegmenterParams
from sceneq_nodes._folder_source import FolderParams, FolderSource

from support.recording import write_recording
from support.room import Room


def test_every_lap_of_a_looped_folder_meets_its_masks(tmp_path: Path) -> None:
    folder = write_recording(tmp_path / "room", frames=5)
    segmenter = FilesSegmenter(FilesSegmenterParams(str(folder)))
    stream = FolderSource(FolderParams(str(folder), step=2, loop=True)).frames()
    rounds = [next(stream).seq for _ in range(7)]
    assert rounds == [0, 2, 4, 5, 7, 9, 10]
    for turn, seq in enumerate(rounds):
        rgb, depth_mm, instance, T_world_camera = Room().frame(2 * (turn % 3), 5)
        frame = Frame(seq, 0, rgb, depth_mm / np.float32(1000), Room().K, T_world_camera)
        np.testing.assert_array_equal(segmenter.segment(frame), instance)
