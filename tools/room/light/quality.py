"""How much work light and edges are worth."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Quality:
    """Costs and fineness of a rendering.

    Attributes:
        shadow_rays: rays from each point to each light.
        gather_rays: rays from each coarse point to its surroundings.
        bounces: how often light is passed on between surfaces.
        cell_m: metres between points where direct light is measured on large things.
        texture_px: longest side of a texture in memory.
        edge_rays: rays through each corner of a pixel that lies on an edge.
        threads: pieces of an image that are shaded at the same time.
    """

    shadow_rays: int = 12
    gather_rays: int = 32
    bounces: int = 3
    cell_m: float = 0.045
    texture_px: int = 1024
    edge_rays: int = 1
    threads: int = 2

    def __post_init__(self) -> None:
        for name in ("shadow_rays", "gather_rays", "texture_px", "threads"):
            if getattr(self, name) < 1:
                raise ValueError(f"{name} must be at least 1, got {getattr(self, name)}")
        for name in ("bounces", "edge_rays"):
            if getattr(self, name) < 0:
                raise ValueError(f"{name} must not be negative, got {getattr(self, name)}")
        if self.cell_m <= 0:
            raise ValueError(f"cell_m must be positive, got {self.cell_m}")
