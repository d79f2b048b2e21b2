"""The materials of a room as one table."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Float32, Int64, UInt8
from sceneq_tools.room.light.texture_atlas import TextureAtlas, halvings, texture_atlas
from sceneq_tools.room.mesh import Material
from sceneq_tools.room.textures.linear import linear

WHITE: UInt8 = np.full((1, 1, 4), 255, np.uint8)
DARKEST, BRIGHTEST = 0.004, 0.85  # black paint reflects a little, white paint not all


@dataclass(frozen=True, slots=True, eq=False)
class Surfaces:
    """One row for each material: how it answers light.

    Attributes:
        colour: float32 (3, M) linear.
        texture: int64 (M,) in the atlas, a white one for none; ``shrunk``: float32 (M,) how much
            smaller the atlas holds it than the material does, 1 or less.
        opacity, shine, gloss, emission: float32 (M,), as in ``Material``.
        atlas: all textures.
    """

    colour: Float32
    texture: Int64
    shrunk: Float32
    opacity: Float32
    shine: Float32
    gloss: Float32
    emission: Float32
    atlas: TextureAtlas


class TextureStore:
    """Halvings of textures, kept while they are in use; the atlas is rebuilt when they change."""

    def __init__(self, largest_px: int) -> None:
        self._largest_px = largest_px
        self._kept: dict[int, tuple[UInt8, list[UInt8]]] = {}
        self._order: tuple[int, ...] | None = None
        self._atlas: TextureAtlas | None = None

    def surfaces(self, materials: list[Material]) -> Surfaces:
        """Return the table of these materials."""
        textures = {id(m.texture): m.texture for m in materials if m.texture is not None}
        order = tuple(textures)
        if self._atlas is None or order != self._order:
            self._kept = {key: self._halved(key, t) for key, t in textures.items()}
            self._order = order
            halved = [levels for _, levels in self._kept.values()]
            self._atlas = texture_atlas([*halved, [WHITE]])
        rows = {key: row for row, key in enumerate(order)}
        return _table(materials, rows, self._atlas)

    def _halved(self, key: int, texture: UInt8) -> tuple[UInt8, list[UInt8]]:
        kept = self._kept.get(key)
        if kept is not None and kept[0] is texture:
            return kept
        return texture, halvings(texture, self._largest_px)


def _table(materials: list[Material], rows: dict[int, int], atlas: TextureAtlas) -> Surfaces:
    colour = linear(np.array([m.colour for m in materials], np.float32).reshape(-1, 3))
    plain = np.array([m.texture is None for m in materials], bool)
    colour[plain] = np.clip(colour[plain], DARKEST, BRIGHTEST)
    texture = [len(rows) if m.texture is None else rows[id(m.texture)] for m in materials]
    return Surfaces(
        np.ascontiguousarray(colour.T),
        np.array(texture, np.int64),
        np.array(
            [_shrunk(m, t, atlas) for m, t in zip(materials, texture, strict=True)], np.float32
        ),
        opacity=np.array([m.opacity for m in materials], np.float32),
        shine=np.array([m.shine for m in materials], np.float32),
        gloss=np.array([m.gloss for m in materials], np.float32),
        emission=np.array([m.emission for m in materials], np.float32),
        atlas=atlas,
    )


def _shrunk(material: Material, texture: int, atlas: TextureAtlas) -> float:
    if material.texture is None:
        return 1.0
    width = float(atlas.tiles[atlas.first_tile[texture], 2])
    return width / int(material.texture.shape[1])
