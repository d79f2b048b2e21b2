"""An encoder made of any two towers that end in the same space."""

from collections import OrderedDict
from collections.abc import Callable, Iterator, Sequence
from threading import Lock
from typing import Generic, TypeVar

import numpy as np

from sceneq_core.arrays import Float32, UInt8
from sceneq_core.encoding.encoder import Crop

T = TypeVar("T")


class Towers(Generic[T]):
    """Feeds crops and texts in batches, checks and normalises what comes out, remembers texts.

    ``prepare`` makes the input of one crop, ``see`` maps inputs to descriptors (N, dim) and
    features (N, F), ``read`` maps texts to descriptors (N, dim); a text is put in the place of
    ``{}`` in ``prompt`` first. In batches of 1 a vector does not depend, to the last bit, on what
    it was computed beside.
    """

    def __init__(
        self,
        prepare: Callable[[UInt8], T],
        see: Callable[[list[T]], tuple[Float32, Float32]],
        read: Callable[[list[str]], Float32],
        *,
        dim: int,
        batch: int,
        text_cache: int,
        prompt: str = "{}",
    ) -> None:
        self._prompt = prompt
        self._prepare = prepare
        self._see = see
        self._read = read
        self._dim = dim
        self._batch = batch
        self._texts = TextCache(text_cache)

    def encode_crops(self, crops: Sequence[Crop]) -> tuple[Float32, Float32]:
        """Return descriptors (N, dim), L2-normalised, and the image tower's features (N, F).

        Raises:
            ValueError: the tower gives another dimension, or numbers that are not finite.
        """
        if not crops:
            return np.zeros((0, self._dim), np.float32), np.zeros((0, 0), np.float32)
        seen = [self._see([self._prepare(c.rgb) for c in few]) for few in self._batches(crops)]
        descriptors, features = zip(*seen, strict=True)
        return self._units(np.concatenate(descriptors), "image"), np.concatenate(features)

    def encode_texts(self, texts: Sequence[str]) -> Float32:
        """Return (N, dim), L2-normalised; raises ``ValueError`` as ``encode_crops``."""
        if not texts:
            return np.zeros((0, self._dim), np.float32)
        known = self._texts.known(texts)
        new = [text for text in dict.fromkeys(texts) if text not in known]
        for few in self._batches(new):
            asked = [self._prompt.replace("{}", text) for text in few]
            known |= zip(few, self._units(self._read(asked), "text"), strict=True)
        self._texts.keep({text: known[text] for text in new})
        return np.stack([known[text] for text in texts])

    def _batches(self, items: Sequence[Crop] | Sequence[str]) -> Iterator[Sequence]:  # type: ignore[type-arg]
        return (items[i : i + self._batch] for i in range(0, len(items), self._batch))

    def _units(self, vectors: Float32, tower: str) -> Float32:
        if vectors.ndim != 2 or vectors.shape[1] != self._dim:
            raise ValueError(f"the {tower} tower: expected (N, {self._dim}), got {vectors.shape}")
        if not np.isfinite(vectors).all():
            raise ValueError(f"the {tower} tower gives numbers that are not finite: use float32")
        lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
        return np.asarray(vectors / np.maximum(lengths, 1e-12), np.float32)


class TextCache:
    """The vectors of the texts used last; any thread may ask."""

    def __init__(self, size: int) -> None:
        self._size = size
        self._lock = Lock()
        self._vectors: OrderedDict[str, Float32] = OrderedDict()

    def known(self, texts: Sequence[str]) -> dict[str, Float32]:
        """Return the vectors at hand among those of ``texts``."""
        with self._lock:
            found = {text: self._vectors[text] for text in texts if text in self._vectors}
            for text in found:
                self._vectors.move_to_end(text)
            return found

    def keep(self, vectors: dict[str, Float32]) -> None:
        """Remember ``vectors``; the ones not asked for longest make room."""
        with self._lock:
            self._vectors |= vectors
            while len(self._vectors) > self._size:
                self._vectors.popitem(last=False)
