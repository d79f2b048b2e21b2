"""What a picture of a scene is drawn from."""

from dataclasses import dataclass

from sceneq_core.arrays import Float32, Float64, Int32, UInt8

SHELL_SIDE_M = 1.8
"""Something that is as long in two directions is a wall or a floor: few pieces of furniture are."""


@dataclass(frozen=True, slots=True)
class Cloud:
    """The points of a scene.

    Attributes:
        points_world: float32 (N, 3), metres.
        rgb: uint8 (N, 3).
        instance_id: int32 (N,), 0 = none.
        voxel_size_m: what a point stands for.
        up_world: (3,).
    """

    points_world: Float32
    rgb: UInt8
    instance_id: Int32
    voxel_size_m: float
    up_world: Float64


@dataclass(frozen=True, slots=True)
class Thing:
    """An instance that may get a caption: ``text`` where it is named, else its number.

    Attributes:
        instance_id: its id.
        text: its caption.
        p: how sure the name is.
        named: whether the text holds a name; a mere number is only written on the thing itself.
        size_m: the sides of its box, metres.
    """

    instance_id: int
    text: str
    p: float
    named: bool
    size_m: tuple[float, float, float]

    @property
    def is_shell(self) -> bool:
        """Whether it is as large as a wall or floor."""
        return sorted(self.size_m)[1] >= SHELL_SIDE_M


@dataclass(frozen=True, slots=True)
class Mark:
    """A thing to point at: its box as corners (8, 3) in metres and what to write beside it."""

    instance_id: int
    text: str
    corners_world: Float64
