"""What a perfect camera would see."""

from dataclasses import dataclass

from sceneq_core.arrays import Float32, UInt8, UInt16


@dataclass(frozen=True, slots=True, eq=False)
class Rendering:
    """Registered images of one view, all (H, W).

    Attributes:
        rgb: uint8 (H, W, 3), tone-mapped, without sensor noise.
        depth_m: float32 z-depth at pixel centres, 0 = nothing there.
        instance_id: uint16 id of the thing at the pixel centre, 0 = nothing.
        incidence: float32 cosine between ray and surface normal, 0 grazing to 1 head-on.
    """

    rgb: UInt8
    depth_m: Float32
    instance_id: UInt16
    incidence: Float32
