"""Where a promptable segmenter is asked: the middles of equal cells of the image."""

import numpy as np

from sceneq_core.arrays import Float32


def point_grid(per_side: int, height: int, width: int) -> Float32:
    """Return (per_side ** 2, 2) points (x, y) in pixels of an image, row by row.

    As in A. Kirillov et al., Segment Anything, ICCV 2023, doi 10.1109/ICCV51070.2023.00371.
    """
    middle = (np.arange(per_side) + 0.5) / per_side
    x, y = np.meshgrid(middle * width, middle * height)
    return np.stack([x.ravel(), y.ravel()], axis=1).astype(np.float32)
