"""All pictures of a room in one image, so that one call reads a texel for every pixel."""

from dataclasses import dataclass

import cv2
import numpy as np

from sceneq_core.arrays import Float32, Int64, UInt8

WIDTH_PX = 8192  # cv2.remap takes at most 32767 in either direction
ROW_PX = 512  # reads are folded into rows of this many, for the same reason
MOST_ROWS = 16 * 1024


@dataclass(frozen=True, slots=True, eq=False)
class TextureAtlas:
    """Every texture at every halving, each with a border that repeats its far side.

    Attributes:
        image: uint8 (h, w, 4) sRGB + alpha.
        tiles: float32 (T, 4): x, y of the first texel's corner, half a pixel before its centre,
            width and height; one row for each level.
        first_tile: int64 (N,) row of a texture's full size.
        last_level: int64 (N,) its smallest halving.
    """

    image: UInt8
    tiles: Float32
    first_tile: Int64
    last_level: Int64

    def read(self, texture: Int64, uv: Float32, level: Int64) -> UInt8:
        """Return uint8 (N, 4): bilinear in the halving ``level`` of each texture, repeated.

        Shapes: texture (N,), uv (N, 2) with v upwards, level (N,) clipped to what there is.
        """
        row = np.minimum(np.maximum(level, 0), self.last_level.take(texture))
        row += self.first_tile.take(texture)
        x, y, width, height = np.ascontiguousarray(self.tiles.take(row, axis=0).T)
        u, v = uv.T
        width *= u - np.floor(u)
        height *= 1 + np.floor(v) - v
        return _read(self.image, x + width, y + height)


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
        table[row] = x + 0.5, y + 0.5, w - 2, h - 2
    levels = np.array([len(levels) for levels in textures], np.int64)
    first = np.concatenate([[0], np.cumsum(levels)[:-1]]) if len(levels) else levels
    return TextureAtlas(image, table, first.astype(np.int64), levels - 1)


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


def _read(image: UInt8, x: Float32, y: Float32) -> UInt8:
    """Read at (x, y), in rows and pieces that are small enough for OpenCV."""
    count = len(x)
    grid = np.zeros((2, -(-count // ROW_PX), ROW_PX), np.float32)
    flat = grid.reshape(2, -1)
    flat[0, :count], flat[1, :count] = x, y
    texels = np.empty((*grid.shape[1:], 4), np.uint8)
    for first in range(0, len(texels), MOST_ROWS):
        rows = slice(first, first + MOST_ROWS)
        cv2.remap(image, grid[0, rows], grid[1, rows], cv2.INTER_LINEAR, dst=texels[rows])
    return texels.reshape(-1, 4)[:count]
