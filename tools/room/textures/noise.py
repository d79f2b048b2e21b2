"""Smooth random fields that repeat without a seam."""

import numpy as np

from sceneq_core.arrays import Float64

Shape = tuple[int, int]


def value_noise(rng: np.random.Generator, shape: Shape, cells: Shape) -> Float64:
    """Random values on a grid of ``cells``, smoothly blended; 0 to 1, (h, w)."""
    grid = rng.random(cells)
    row, row_after, down = _places(shape[0], cells[0])
    column, column_after, right = _places(shape[1], cells[1])
    top = _blend(grid[row][:, column], grid[row][:, column_after], right[None, :])
    bottom = _blend(grid[row_after][:, column], grid[row_after][:, column_after], right[None, :])
    return _blend(top, bottom, down[:, None])


def fractal_noise(
    rng: np.random.Generator, shape: Shape, cells: Shape, octaves: int = 5, gain: float = 0.5
) -> Float64:
    """Sum of value noises, each twice as fine and ``gain`` times as strong; 0 to 1, (h, w)."""
    total, weight, strength = np.zeros(shape), 0.0, 1.0
    for octave in range(octaves):
        finer = (cells[0] << octave, cells[1] << octave)
        if finer[0] > shape[0] or finer[1] > shape[1]:
            break
        total += strength * value_noise(rng, shape, finer)
        weight += strength
        strength *= gain
    return total / max(weight, 1e-9)


def spread(field: Float64) -> Float64:
    """Stretch a field to the full range 0 to 1."""
    low, high = float(field.min()), float(field.max())
    return (field - low) / max(high - low, 1e-9)


def _places(length: int, cells: int) -> tuple[np.ndarray, np.ndarray, Float64]:
    place = np.arange(length) * cells / length
    before = place.astype(np.int64)
    fraction = place - before
    return before, (before + 1) % cells, fraction * fraction * (3 - 2 * fraction)


def _blend(a: Float64, b: Float64, share: Float64) -> Float64:
    return np.asarray(a * (1 - share) + b * share)
