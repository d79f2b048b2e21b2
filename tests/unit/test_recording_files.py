from pathlib import Path

import cv2
import numpy as np
import pytest

from sceneq_tools.room.truth.recording_files import SIGNATURE, FrameImages, Output, write_frame


def write(path: Path, force: bool = False, text: str = "new") -> None:
    with Output(path, force) as folder:
        (folder / "README.md").write_text(f"{SIGNATURE} {text}")
        (folder / "frame-000000.pose.txt").write_text(text)


def images() -> FrameImages:
    depth = np.arange(48 * 64, dtype=np.uint16).reshape(48, 64)
    rgb = np.full((48, 64, 3), (200, 60, 10), np.uint8)
    return FrameImages(rgb, depth, depth % 7, depth % 300)


def test_images_are_read_as_they_were_written(tmp_path: Path) -> None:
    written = images()
    write_frame(tmp_path, 7, written, np.eye(4))
    for part in ("depth_mm", "instance_id", "mask"):
        name = {"depth_mm": "depth", "instance_id": "instance"}.get(part, part)
        read = cv2.imread(str(tmp_path / f"frame-000007.{name}.png"), cv2.IMREAD_UNCHANGED)
        np.testing.assert_array_equal(read, getattr(written, part))
    rgb = cv2.imread(str(tmp_path / "frame-000007.color.jpg"))[..., ::-1]
    assert np.abs(rgb.astype(int) - written.rgb).max() <= 3


def test_a_folder_that_cannot_be_written_to_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="frame-000000"):
        write_frame(tmp_path / "missing", 0, images(), np.eye(4))


def test_nothing_is_there_until_all_is_there(tmp_path: Path) -> None:
    with Output(tmp_path / "out") as folder:
        (folder / "stamps.txt").write_text("0")
        assert not (tmp_path / "out").exists()
    assert [p.name for p in tmp_path.iterdir()] == ["out"]
    assert (tmp_path / "out" / "stamps.txt").read_text() == "0"


@pytest.mark.parametrize("interrupt", [KeyboardInterrupt, ValueError])
def test_an_interrupt_leaves_nothing(tmp_path: Path, interrupt: type[BaseException]) -> None:
    def write_half() -> None:
        with Output(tmp_path / "out") as folder:
            (folder / "frame-000000.pose.txt").write_text("half")
            raise interrupt

    with pytest.raises(interrupt):
        write_half()
    assert list(tmp_path.iterdir()) == []


def test_an_interrupt_leaves_the_earlier_recording(tmp_path: Path) -> None:
    write(tmp_path / "out", text="first")
    with pytest.raises(KeyboardInterrupt), Output(tmp_path / "out"):
        raise KeyboardInterrupt
    assert (tmp_path / "out" / "frame-000000.pose.txt").read_text() == "first"


def test_an_earlier_recording_is_replaced_whole(tmp_path: Path) -> None:
    write(tmp_path / "out", text="first")
    (tmp_path / "out" / "frame-000009.depth.png").write_text("of the first")
    write(tmp_path / "out", text="second")
    assert not (tmp_path / "out" / "frame-000009.depth.png").exists()
    assert (tmp_path / "out" / "frame-000000.pose.txt").read_text() == "second"


def test_other_files_are_in_the_way_unless_forced_and_then_stay(tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").write_text("dear")
    with pytest.raises(FileExistsError, match="not empty"):
        Output(tmp_path)
    write(tmp_path, force=True)
    assert (tmp_path / "thesis.tex").read_text() == "dear"
    assert (tmp_path / "frame-000000.pose.txt").read_text() == "new"


def test_a_file_is_no_folder(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(NotADirectoryError, match="is a file"):
        Output(tmp_path / "file")
