"""What things may be called, and what an instance is called."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Float32, Float64
from sceneq_core.encoding.colour import COLOUR_TERMS
from sceneq_core.encoding.encoder import Encoder
from sceneq_core.encoding.looks import familiarity
from sceneq_core.encoding.usual_sizes import sized
from sceneq_core.routing import scannet200
from sceneq_core.routing.gate import capped, softmax

MAX_LABELS = 2000
MAX_LABEL_CHARS = 64

NAMED = {
    "scannet200": (scannet200.HEAD, scannet200.COMMON, scannet200.TAIL),
    "scannet200-head": (scannet200.HEAD,),
    "scannet200-common": (scannet200.COMMON,),
    "scannet200-tail": (scannet200.TAIL,),
}
"""Label sets that can be chosen by name."""


@dataclass(frozen=True, slots=True)
class LabelSet:
    """Distinct names of things, in a fixed order."""

    name: str
    labels: tuple[str, ...]

    def __post_init__(self) -> None:
        if not 1 <= len(self.labels) <= MAX_LABELS:
            raise ValueError(f"labels: {len(self.labels)} given, expected 1 to {MAX_LABELS}")
        if len(set(self.labels)) < len(self.labels):
            twice = next(name for name in self.labels if self.labels.count(name) > 1)
            raise ValueError(f"labels: {twice!r} is given twice")
        for label in self.labels:
            if not label.strip() or len(label) > MAX_LABEL_CHARS:
                raise ValueError(f"labels: {label!r:.80} is empty or over {MAX_LABEL_CHARS} chars")

    def __len__(self) -> int:
        return len(self.labels)


def named(name: str) -> LabelSet:
    """Return the label set called ``name``; raise ``ValueError`` when there is none."""
    if name not in NAMED:
        raise ValueError(f"label_set: unknown {name!r}, known: {', '.join(NAMED)}")
    return LabelSet(name, tuple(", ".join(NAMED[name]).split(", ")))


def custom(labels: Sequence[str]) -> LabelSet:
    """Return a label set of the user's own words."""
    return LabelSet("custom", tuple(label.strip() for label in labels))


ENCODER, TAUGHT, INHERITED = "encoder", "taught", "inherited"


@dataclass(frozen=True, slots=True)
class Label:
    """A name for an instance, with its probability ``p`` and cosine s; where it is from.

    ``source``: ``encoder`` = p is softmax(s / T) over the label set; ``taught`` = somebody said
    so; ``inherited`` = it looks like a thing that was taught, p is the calibrated chance that it
    is one of these too.
    """

    name: str
    p: float
    cosine: float
    source: str = ENCODER


class Labeller:
    """Names instances: cosine of descriptor and label text, softmax over the label set."""

    def __init__(self, label_set: LabelSet, encoder: Encoder) -> None:
        self.label_set = label_set
        self.temperature = encoder.temperature
        self.ceiling = encoder.ceiling
        self._encoder = encoder
        self.text_vectors: Float32 = encoder.encode_texts(label_set.labels)
        self.colour_vectors: Float32 = encoder.encode_texts(COLOUR_TERMS)

    def sized(self, descriptor: Float32, shape: Float64) -> Float32:
        """Return the descriptor (D,) given the shape (4,) of its thing, if the encoder can."""
        return sized(self._encoder, descriptor, shape)

    def familiarity(self, feature: Float32) -> float:
        """Return how much an image feature (F,) is like what the encoder was taught, 1 = same."""
        return familiarity(self._encoder, feature)

    def scores(self, descriptors: Float32) -> Float32:
        """Return the cosines float32 (N, C) of ``descriptors`` (N, D) with every label."""
        return descriptors @ self.text_vectors.T

    def best_of_scores(self, scores: Float32, k: int = 1) -> tuple[Label, ...]:
        """Return the ``k`` most probable labels, best first, of cosines (C,) with every label."""
        p = self.distribution(scores)
        order = np.argsort(-p, kind="stable")[:k]
        names = self.label_set.labels
        return tuple(Label(names[i], float(p[i]), float(scores[i])) for i in order)

    def distribution(self, scores: Float32) -> Float64:
        """Return p float64 (C,) over the label set for cosines ``scores`` (C,)."""
        return capped(softmax(scores.astype(np.float64), self.temperature), self.ceiling)
