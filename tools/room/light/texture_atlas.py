"""All pictures of a room in one image, so that one call reads a texel for every pixel."""

from dataclasses import dataclass

import cv2
import numpy as np

from sceneq_core.arrays import Float32, Int32, UInt8

WIDTH_PX = 8192  # cv2.remap takes at most 32767 in either direction
ROW_PX = 512  # reads are folded into rows of this many, for the same reason


@dataclass(frozen=True, slots=True, eq=False)
class TextureAtlas:
    """Every texture at every halving, each with a border that repeats its far side.

    Attributes:
        image: uint8 (h, w, 4) sRGB + alpha.
        tiles: float32 (T, 4): x, y of the first texel, width, height; one row for each level.
        first_tile: int32 (N,) row of a texture's full size.
        levels: int32 (N,) how many rows it has.
    """

    image: UInt8
    tiles: Float32
    first_tile: Int32
    levels: Int32

    def read(self, texture: Int32, uv: Float32, level: Int32) -> UInt8:
        """Return uint8 (N, 4): bilinear in the halving ``level`` of each texture, repeated.

        Shapes: texture (N,), uv (N, 2) with v upwards, level (N,) clipped to what there is.
        """
        tile = self.tiles[self.first_tile[texture] + np.clip(level, 0, self.levels[texture] - 1)]
        at = uv - np.floor(uv)
        x = tile[:, 0] + at[:, 0] * tile[:, 2] - np.float32(0.5)
        y = tile[:, 1] + (1 - at[:, 1]) * tile[:, 3] - np.float32(0.5)
        return _read(self.image, np.stack([x, y]).astype(np.float32))


def halvings(texture: UInt8, largest_px: int) -> list[UInt8]:
    """Return the texture, no side longer than ``largest_px``, and its halves down to 1 px."""
    shrink = min(1.0, largest_px / max(texture.shape[:2]))
    levels = [_resized(texture, shrink) if shrink < 1 else texture]
    while max(levels[-1].shape[:2]) > 1:
        levels.append(_resized(levels[-1], 0.5))
    return levels


def texture_atlas(textures: list[list[UInt8]]) -> TextureAtlas:
    """Pack the levels of every texture in shelves, tallest first."""
    tiles = [_with_border(level) for levels in textures for level in levels]
    places, height = _shelves([tile.shape[:2] for tile in tiles])
    image = np.zeros((max(height, 1), WIDTH_PX if tiles else 1, 4), np.uint8)
    table = np.zeros((len(tiles), 4), np.float32)
    for row, (tile, (x, y)) in enumerate(zip(tiles, places, strict=True)):
        h, w = tile.shape[:2]
        image[y : y + h, x : x + w] = tile
        table[row] = x + 1, y + 1, w - 2, h - 2
    levels = np.array([len(levels) for levels in textures], np.int32)
    first = np.concatenate([[0], np.cumsum(levels)[:-1]]) if len(levels) else levels
    return TextureAtlas(image, table, first.astype(np.int32), levels)


def _resized(image: UInt8, factor: float) -> UInt8:
    h, w = image.shape[:2]
    size = max(1, round(w * factor)), max(1, round(h * factor))
    return np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), np.uint8)


def _with_border(image: UInt8) -> UInt8:
    return np.pad(image, ((1, 1), (1, 1), (0, 0)), mode="wrap")


def _shelves(sizes: list[tuple[int, int]]) -> tuple[list[tuple[int, int]], int]:
    places = [(0, 0)] * len(sizes)
    x = y = shelf = 0
    for index in sorted(range(len(sizes)), key=lambda i: (-sizes[i][0], -sizes[i][1], i)):
        h, w = sizes[index]
        if x + w > WIDTH_PX:
            x, y, shelf = 0, y + shelf, 0
        places[index] = x, y
        x, shelf = x + w, max(shelf, h)
    return places, y + shelf


def _read(image: UInt8, at: Float32) -> UInt8:
    count = at.shape[1]
    padded = -(-count // ROW_PX) * ROW_PX
    grid = np.zeros((2, padded), np.float32)
    grid[:, :count] = at
    rows = 16 * 1024
    parts = [
        cv2.remap(image, x.reshape(-1, ROW_PX), y.reshape(-1, ROW_PX), cv2.INTER_LINEAR)
        for x, y in np.split(grid, range(rows * ROW_PX, padded, rows * ROW_PX), axis=1)
        if len(x)
    ]
    blank = np.zeros((0, 4), np.uint8)
    texels = np.concatenate([blank, *(np.asarray(part).reshape(-1, 4) for part in parts)])
    return texels[:count].astype(np.uint8, copy=False)
