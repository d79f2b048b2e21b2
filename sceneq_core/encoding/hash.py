"""An encoder without weights, for tests: it knows colours and the spelling of words."""

import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sceneq_core.arrays import Float32
from sceneq_core.encoding.colour import COLOUR_TERMS, colour_shares, split_colours
from sceneq_core.encoding.encoder import Crop
from sceneq_core.encoding.joint import unit

WORDS = 53
COLOURS = len(COLOUR_TERMS)


@dataclass(frozen=True, slots=True)
class HashParams:
    """No parameters."""


class HashEncoder:
    """Texts that name a colour lie near crops of that colour; other words near nothing."""

    Params: ClassVar[type] = HashParams

    def __init__(self, params: HashParams) -> None:
        self.model_id = "hash-v1"
        self.dim = COLOURS + WORDS
        self.temperature = 0.1
        self.ceiling = 1.0

    def encode_crops(self, crops: Sequence[Crop]) -> tuple[Float32, Float32]:
        """Return the colours of the crops (N, 64), twice: the feature is the descriptor."""
        rows = [np.sqrt(colour_shares(crop.rgb, crop.mask)) for crop in crops]
        vectors = np.zeros((len(rows), self.dim), np.float32)
        for vector, colours in zip(vectors, rows, strict=True):
            vector[:COLOURS] = unit(colours)
        return vectors, vectors.copy()

    def encode_texts(self, texts: Sequence[str]) -> Float32:
        """Return (N, 64): the colours a text names, one hashed direction for each other word."""
        vectors = np.zeros((len(texts), self.dim), np.float32)
        for vector, text in zip(vectors, texts, strict=True):
            rest, colours = split_colours(text)
            vector[:COLOURS] = np.sqrt(colours)
            for word in rest.split() or ([] if colours.any() else [""]):
                vector[COLOURS + zlib.crc32(word.encode()) % WORDS] += 1
        return np.stack([unit(v) for v in vectors]) if texts else vectors
