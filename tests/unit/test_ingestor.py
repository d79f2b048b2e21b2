"""From source frames to keyframes."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from sceneq_core.frame import depth_to_mm
from sceneq_core.ingest.ingestor import Ingested, Ingestor
from sceneq_core.ingest.keyframes import EveryNth, EveryNthParams
from sceneq_core.ingest.pose_graph import PoseGraph, PoseGraphParams
from sceneq_core.ingest.shading import Shading
from sceneq_core.ingest.source import Camera, RawFrame, RefusedError, Skipped
from sceneq_core.ingest.trajectory import color_trajectory
from sceneq_core.ingest.transforms import inverse

from support.seven_scenes import SIZE, K, color, depth_mm, pose


class Memory:
    """A source of frames that count how often they are decoded."""

    name = "memory"
    color_camera = depth_camera = Camera(K, SIZE)
    T_color_depth = np.eye(4)

    def __init__(self, has_poses: bool = True) -> None:
        self.has_poses = has_poses
        self.decoded: list[str] = []

    def frames(self) -> Iterator[RawFrame | Skipped]:
        return map(self.frame, range(6))

    def control(self, verb: str, arguments: Mapping[str, str]) -> dict[str, Any]:
        raise RefusedError("memory stays as it is")

    def frame(self, number: int) -> RawFrame:
        def read(what: str, image: np.ndarray) -> np.ndarray:
            self.decoded.append(f"{what} {number}")
            return image

        return RawFrame(
            seq=number,
            stamp_ns=number * 100,
            T_world_camera=pose(number) if self.has_poses else None,
            read_rgb=lambda: read("rgb", color(number)),
            read_depth_mm=lambda: read("depth", np.minimum(depth_mm(number), 9000)),
        )


class Sideways:
    """An odometry that knows nothing at every third image."""

    kind = "sideways"

    def __init__(self) -> None:
        self.calls = 0

    def register(
        self, depth_mm: np.ndarray, K: np.ndarray, stamp_ns: int, shading: Shading | None = None
    ) -> np.ndarray | None:
        assert shading is not None
        self.calls += 1
        return pose(100) if self.calls % 3 else None


def every(n: int) -> EveryNth:
    return EveryNth(EveryNthParams(every=n))


def test_keyframes_are_decoded_and_other_frames_are_not() -> None:
    source = Memory()
    ingestor = Ingestor(source, every(3))
    results = [ingestor.ingest(raw) for raw in source.frames()]
    assert [r.keyframe is not None for r in results] == [True, False, False] * 2
    assert source.decoded == ["rgb 0", "depth 0", "rgb 3", "depth 3"]
    assert {r.pose_source for r in results} == {"given"}


def test_a_keyframe_carries_everything() -> None:
    result = Ingestor(Memory(), every(1)).ingest(Memory().frame(4))
    assert isinstance(result, Ingested)
    frame = result.keyframe
    assert frame is not None
    assert (frame.seq, frame.stamp_ns) == (4, 400)
    np.testing.assert_array_equal(frame.rgb, color(4))
    np.testing.assert_array_equal(depth_to_mm(frame.depth_m), np.minimum(depth_mm(4), 9000))
    np.testing.assert_array_equal(frame.K, K)
    np.testing.assert_allclose(frame.T_world_camera, pose(4), atol=1e-15)
    assert frame.T_world_camera is result.T_world_camera


def test_poses_are_those_of_the_colour_camera() -> None:
    source = Memory()
    source.T_color_depth = np.eye(4)
    source.T_color_depth[:3, 3] = (-0.02, 0.01, 0)
    result = Ingestor(source, every(1)).ingest(source.frame(5))
    # The colour camera sits at +2 cm, -1 cm in the depth camera's frame.
    np.testing.assert_allclose(result.T_world_camera[:3, 3], (0.07, -0.01, 0), atol=1e-12)
    np.testing.assert_allclose(color_trajectory(source)[5][1], result.T_world_camera, atol=1e-12)


def test_frames_without_pose_ask_the_odometry() -> None:
    source = Memory(has_poses=False)
    ingestor = Ingestor(source, every(1), Sideways())
    good, _, lost = (ingestor.ingest(source.frame(i)) for i in range(3))
    assert isinstance(good, Ingested)
    assert good.pose_source == "sideways"
    np.testing.assert_allclose(good.T_world_camera, pose(100))
    assert lost == Skipped(2, "sideways", "no pose: tracking lost, or too little depth")


class Shifting(PoseGraph):
    """A graph that puts every keyframe 1 m up, and the first one 2 m as soon as it has two."""

    def __init__(self) -> None:
        super().__init__(PoseGraphParams())
        self.seqs: list[int] = []

    def __len__(self) -> int:
        return 0

    def pose(self, T_odometry_camera: np.ndarray) -> np.ndarray:
        return up(T_odometry_camera, 0.5)

    def add(self, seq: int, T_odometry_camera: np.ndarray, *_: Any) -> np.ndarray:
        self.seqs.append(seq)
        return up(T_odometry_camera, 1.0)

    def corrections(self) -> dict[int, np.ndarray]:
        return {self.seqs[0]: up(pose(100), 2.0)} if len(self.seqs) == 2 else {}


def up(T_world_camera: np.ndarray, height_m: float) -> np.ndarray:
    lifted = T_world_camera.copy()
    lifted[1, 3] -= height_m
    return lifted


def test_the_graph_corrects_keyframes_and_says_what_it_knows_better() -> None:
    source = Memory(has_poses=False)
    source.T_color_depth = np.eye(4)
    source.T_color_depth[:3, 3] = (-0.02, 0.01, 0)
    T_depth_color = inverse(source.T_color_depth)
    ingestor = Ingestor(source, every(2), Sideways(), Shifting())
    results = [ingestor.ingest(source.frame(i)) for i in (0, 1, 3, 4)]
    first, between, lost, second = results
    assert isinstance(lost, Skipped)
    assert [bool(r.keyframe) for r in (first, between, second)] == [True, False, True]
    for result, height_m in ((first, 1.0), (between, 0.5), (second, 1.0)):
        expected = up(pose(100), height_m) @ T_depth_color
        np.testing.assert_allclose(result.T_world_camera, expected)
    np.testing.assert_array_equal(second.keyframe.T_world_camera, second.T_world_camera)
    assert not first.corrected
    assert list(second.corrected) == [0]
    np.testing.assert_allclose(second.corrected[0], up(pose(100), 2.0) @ T_depth_color)


def test_without_poses_and_odometry_it_does_not_start() -> None:
    with pytest.raises(ValueError, match="memory has no poses"):
        Ingestor(Memory(has_poses=False), every(1))


@pytest.mark.parametrize("part", ["read_rgb", "read_depth_mm"])
def test_the_frame_after_a_bad_keyframe_stands_in(part: str) -> None:
    source = Memory()
    ingestor = Ingestor(source, every(3))
    broken = Skipped(0, "frame-000000", "does not decode")
    assert ingestor.ingest(replace(source.frame(0), **{part: lambda: broken})) is broken
    stand_in = ingestor.ingest(source.frame(1))
    assert isinstance(stand_in, Ingested)
    assert stand_in.keyframe is not None


def test_depth_that_does_not_decode_has_no_odometry() -> None:
    broken = Skipped(0, "frame-000000", "does not decode")
    raw = replace(Memory(has_poses=False).frame(0), read_depth_mm=lambda: broken)
    ingestor = Ingestor(Memory(has_poses=False), every(1), Sideways())
    assert ingestor.ingest(raw) is broken


@pytest.mark.parametrize(
    ("T_world_camera", "reason"), [(None, "promised"), (np.diag([2.0, 1, 1, 1]), "not rigid")]
)
def test_a_source_that_breaks_its_promise_is_skipped(T_world_camera, reason: str) -> None:
    result = Ingestor(Memory(), every(1)).ingest(
        replace(Memory().frame(0), T_world_camera=T_world_camera)
    )
    assert isinstance(result, Skipped)
    assert reason in result.reason
