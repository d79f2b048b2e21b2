"""KISS-ICP on the depth of a ray-cast room."""

import subprocess
import sys

import numpy as np
import pytest

from sceneq_core.ingest.odometry import KissIcpOdometry, KissIcpParams
from sceneq_core.ingest.trajectory import trajectory_report
from sceneq_core.ingest.transforms import rigid_defect

from support.room import Room

FRAMES = 24
ROOM = Room()


@pytest.fixture(scope="module")
def views() -> list[tuple[np.ndarray, np.ndarray]]:
    return [ROOM.frame(i, 3 * FRAMES)[1::2] for i in range(FRAMES)]


def run(views, **params) -> list[np.ndarray]:
    odometry = KissIcpOdometry(KissIcpParams(**params))
    poses = [odometry.register(depth_mm, ROOM.K, 0) for depth_mm, _ in views]
    assert all(T is not None and rigid_defect(T) is None for T in poses)
    return poses


def test_it_follows_the_camera(views) -> None:
    found = run(views, stride=1)
    report = trajectory_report(list(enumerate(found)), [(i, T) for i, (_, T) in enumerate(views)])
    assert report.frames == FRAMES
    assert report.length_m > 0.5
    assert report.rmse_m < 0.05 * report.length_m
    np.testing.assert_allclose(found[0], np.eye(4), atol=1e-9)


def test_it_is_deterministic_to_the_bit(views) -> None:
    first, second = run(views[:6]), run(views[:6])
    assert np.stack(first).tobytes() == np.stack(second).tobytes()


def test_an_empty_image_gets_no_pose_and_does_no_harm(views) -> None:
    empty = np.zeros_like(views[0][0])
    odometry = KissIcpOdometry(KissIcpParams())
    assert odometry.register(empty, ROOM.K, 0) is None
    found = [odometry.register(depth, ROOM.K, 0) for depth, _ in views[:3]]
    assert odometry.register(empty, ROOM.K, 0) is None
    assert np.stack(found).tobytes() == np.stack(run(views[:3])).tobytes()


def test_the_environment_does_not_count(views, monkeypatch: pytest.MonkeyPatch) -> None:
    plain = run(views[:3])
    monkeypatch.setenv("kiss_icp_mapping", '{"voxel_size": 3.0}')
    assert np.stack(run(views[:3])).tobytes() == np.stack(plain).tobytes()


@pytest.mark.parametrize("name", ["voxel_m", "stride", "max_range_m"])
def test_parameters_name_what_is_wrong(name: str) -> None:
    with pytest.raises(ValueError, match=name):
        KissIcpParams(**{name: 0})


def test_it_prints_nothing_and_loads_no_viewer() -> None:
    code = (
        "import sys; from sceneq_core.ingest.odometry import KissIcpOdometry as O;"
        "assert 'kiss_icp' not in sys.modules; O(O.Params());"
        "print(*{'open3d', 'polyscope', 'matplotlib', 'torch'} & set(sys.modules), end='')"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True, text=True)
    assert (done.stdout, done.stderr) == ("", "")
