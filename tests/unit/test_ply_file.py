"""The point cloud on disk, as others read it."""

from pathlib import Path

import numpy as np
import pytest

from sceneq_tools.ply_file import write_ply


def test_open3d_reads_what_was_written(tmp_path: Path) -> None:
    import open3d

    rng = np.random.default_rng(1)
    points_world = rng.normal(size=(50, 3)).astype(np.float32)
    rgb = rng.integers(0, 256, (50, 3)).astype(np.uint8)
    write_ply(tmp_path / "cloud.ply", points_world, rgb)
    cloud = open3d.io.read_point_cloud(str(tmp_path / "cloud.ply"))
    assert np.array_equal(np.asarray(cloud.points), points_world.astype(np.float64))
    assert np.array_equal(np.rint(np.asarray(cloud.colors) * 255), rgb)


def test_the_file_is_as_long_as_it_says(tmp_path: Path) -> None:
    path = tmp_path / "cloud.ply"
    write_ply(path, np.zeros((3, 3), np.float32), np.zeros((3, 3), np.uint8))
    header, _, body = path.read_bytes().partition(b"end_header\n")
    assert header.splitlines()[:3] == [
        b"ply",
        b"format binary_little_endian 1.0",
        b"element vertex 3",
    ]
    assert len(body) == 3 * (3 * 4 + 3)


def test_a_folder_that_is_not_there_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="nowhere"):
        write_ply(
            tmp_path / "nowhere" / "cloud.ply",
            np.zeros((0, 3), np.float32),
            np.zeros((0, 3), np.uint8),
        )
