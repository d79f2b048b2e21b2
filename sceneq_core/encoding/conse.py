"""An open-vocabulary encoder made of a classifier and a sentence encoder."""

from collections.abc import Callable, Sequence
from functools import lru_cache

import cv2
import numpy as np

from sceneq_core.arrays import Float32, Float64, UInt8
from sceneq_core.encoding.colour import colour_shares, split_colours
from sceneq_core.encoding.encoder import Crop
from sceneq_core.encoding.joint import (
    CLASSES,
    dimensions,
    given_evidence,
    image_vector,
    text_vector,
)
from sceneq_core.encoding.lessons import Lessons
from sceneq_core.encoding.looks import FAMILIAR

Classify = Callable[[Float32], tuple[Float32, Float32]]
"""(1, 3, side, side) scaled image -> logits (1000,), pooled feature (F,)."""
Embed = Callable[[str], Float32]
"""Text -> sentence vector, length 1."""


class Conse:
    """Both towers of the joint space of ``sceneq_core.encoding.joint``.

    One crop and one text at a time: quantised models may round a batch differently than its
    parts, and a descriptor must not depend on what it was computed beside.
    """

    def __init__(
        self,
        classify: Classify,
        embed: Embed,
        class_vectors: Callable[[], Float32],
        prior: Float32,
        lessons: Lessons,
        side_px: int,
        text_cache: int,
    ) -> None:
        self._classify = classify
        self._embed = embed
        self._class_vectors = class_vectors
        self._prior = prior
        self._lessons = lessons
        self.dim = dimensions(len(lessons.probe))
        self._side_px = side_px
        self._text = lru_cache(maxsize=text_cache)(self._encode_text)

    def encode_crops(self, crops: Sequence[Crop]) -> tuple[Float32, Float32]:
        """Return descriptors (N, dim), L2-normalised, and the classifier's features (N, F)."""
        pairs = [self._encode_crop(crop) for crop in crops]
        if not pairs:
            return np.zeros((0, self.dim), np.float32), np.zeros((0, 0), np.float32)
        descriptors, features = zip(*pairs, strict=True)
        return np.stack(descriptors), np.stack(features)

    def sized(self, descriptor: Float32, shape: Float64) -> Float32:
        """Return the descriptor (D,) of a thing that has this shape (4,), length 1."""
        return given_evidence(descriptor, self._lessons.sizes.evidence(shape))

    def familiarity(self, feature: Float32) -> float:
        """Return how much a feature (F,) is like one of the lessons, 1 = the same."""
        looks = self._lessons.looks
        return FAMILIAR if looks is None else looks.familiarity(feature)

    def encode_texts(self, texts: Sequence[str]) -> Float32:
        """Return (N, dim), L2-normalised."""
        if not texts:
            return np.zeros((0, self.dim), np.float32)
        return np.stack([self._text(text) for text in texts])

    def _encode_crop(self, crop: Crop) -> tuple[Float32, Float32]:
        logits, feature = self._classify(classifier_input(crop.rgb, self._side_px))
        probed = self._lessons.probe.probabilities(feature)
        shares = colour_shares(crop.rgb, crop.mask)
        return image_vector(logits, self._prior, probed, shares), feature

    def _encode_text(self, text: str) -> Float32:
        rest, colours = split_colours(text)
        similarity = np.zeros(CLASSES + len(self._lessons.probe), np.float32)
        if rest:
            embedded = self._embed(rest)
            similarity[:CLASSES] = self._class_vectors() @ embedded
            similarity[CLASSES:] = self._lessons.similarity(embedded)
        return text_vector(similarity, colours)


def classifier_input(rgb: UInt8, side_px: int) -> Float32:
    """Return an image (h, w, 3) as (1, 3, side, side) float32, scaled (x - 127) / 128.

    What surrounds the object stays: masks made of voxels are rougher than a mug's handle.
    """
    shrinks = max(rgb.shape[:2]) > side_px
    square = cv2.resize(
        rgb,
        (side_px, side_px),
        interpolation=cv2.INTER_AREA if shrinks else cv2.INTER_CUBIC,
    )
    scaled = (square.astype(np.float32) - 127.0) / 128.0
    return np.ascontiguousarray(scaled.transpose(2, 0, 1)[None])
