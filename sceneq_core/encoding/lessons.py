"""What the conse encoder was taught beside the classes of its classifier."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Float32, Int64
from sceneq_core.encoding.looks import Looks
from sceneq_core.encoding.probe import Probe
from sceneq_core.encoding.usual_sizes import UsualSizes


@dataclass(frozen=True, slots=True, eq=False)
class Lessons:
    """Names, how things so called look (``probe``), and how large they are (``sizes``).

    ``text_vectors`` float32 (A, 384), length 1, are texts that mean a name, the name itself and
    others; ``text_of`` int64 (A,) is the row of the name each of them means. ``looks`` are those
    of the single things that taught, ``None`` = not remembered.
    """

    probe: Probe
    sizes: UsualSizes
    text_vectors: Float32
    text_of: Int64
    looks: Looks | None = None

    def __post_init__(self) -> None:
        count = len(self.probe)
        if len(self.sizes.mean) != count:
            raise ValueError(f"sizes: of {len(self.sizes.mean)} names, the probe has {count}")
        if len(self.text_vectors) != len(self.text_of):
            vectors = len(self.text_vectors)
            raise ValueError(f"text_of: {len(self.text_of)} rows for {vectors} texts")
        if set(self.text_of.tolist()) != set(range(count)):
            raise ValueError(f"text_of: not every one of {count} names has a text, or others have")

    def similarity(self, embedded: Float32) -> Float32:
        """Return (H,): the highest cosine of a sentence vector (384,) with a text of each name."""
        similarity = np.full(len(self.probe), -1.0, np.float32)
        np.maximum.at(similarity, self.text_of, self.text_vectors @ embedded)
        return similarity
