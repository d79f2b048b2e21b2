"""Frames whose images are given by a list of paths, as sources that have their own layouts use."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from sceneq_core.arrays import Float64
from sceneq_core.ingest.transforms import rigid_defect
from sceneq_nodes._frame_files import BadFileError, check_image


@dataclass(frozen=True, slots=True, eq=False)
class ListedFiles:
    """Frame number -> its two images and its pose (4, 4); ``None`` = the frame has no pose.

    ``pose_file`` is where poses come from, for people.
    """

    color: Mapping[int, Path]
    depth: Mapping[int, Path]
    poses: Mapping[int, Float64 | None]
    pose_file: Path

    @property
    def numbers(self) -> list[int]:
        """All frame numbers, sorted."""
        return sorted(self.color)

    @property
    def has_poses(self) -> bool:
        """Whether there is a pose at all."""
        return any(pose is not None for pose in self.poses.values())

    def path(self, number: int, part: str) -> Path:
        """Return the file of one part of a frame."""
        return (self.color if part == "color" else self.depth)[number]

    def image(self, number: int, part: str) -> tuple[bytes, tuple[int, int]]:
        """Return the bytes of a complete image file and its (width, height)."""
        path = self.path(number, part)
        try:
            data = path.read_bytes()
        except OSError as error:
            raise BadFileError(path, error.strerror or "cannot be read") from error
        return data, check_image(path, data, part)

    def pose(self, number: int) -> Float64:
        """Return the rigid T_world_camera (4, 4) of a frame."""
        T_world_camera = self.poses.get(number)
        if T_world_camera is None:
            raise BadFileError(self.pose_file, f"no pose for frame {number}")
        if defect := rigid_defect(T_world_camera):
            raise BadFileError(self.pose_file, f"pose of frame {number}: {defect}")
        return T_world_camera
