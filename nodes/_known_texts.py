"""The vectors of texts that never change, kept on disk: a restarted node answers at once.

A label set of 200 names costs a sentence encoder about a second; the file costs a millisecond. It
lives in ``$XDG_CACHE_HOME/sceneq`` and is named after the encoder's model and the texts.
"""

import hashlib
import json
import logging
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from sceneq_core.arrays import Float32, Float64
from sceneq_core.encoding.encoder import Crop, Encoder
from sceneq_core.encoding.looks import familiarity
from sceneq_core.encoding.usual_sizes import sized
from sceneq_nodes._cache import cache_path, write_whole

log = logging.getLogger(__name__)


class KnownTexts:
    """An encoder that has the vectors of ``texts`` at hand and leaves all else to ``encoder``."""

    def __init__(self, encoder: Encoder, texts: Sequence[str]) -> None:
        self.model_id = encoder.model_id
        self.dim = encoder.dim
        self.temperature = encoder.temperature
        self.ceiling = encoder.ceiling
        self._encoder = encoder
        distinct = list(dict.fromkeys(texts))
        self._vectors = dict(zip(distinct, _vectors(encoder, distinct), strict=True))

    def encode_crops(self, crops: Sequence[Crop]) -> tuple[Float32, Float32]:
        """Return descriptors (N, dim) and features (N, F) of the encoder."""
        return self._encoder.encode_crops(crops)

    def sized(self, descriptor: Float32, shape: Float64) -> Float32:
        """Return the encoder's descriptor (D,) of a thing that has this shape (4,)."""
        return sized(self._encoder, descriptor, shape)

    def familiarity(self, feature: Float32) -> float:
        """Return how much an image feature (F,) is like what the encoder was taught, 1 = same."""
        return familiarity(self._encoder, feature)

    def encode_texts(self, texts: Sequence[str]) -> Float32:
        """Return (N, dim), L2-normalised."""
        new = [text for text in dict.fromkeys(texts) if text not in self._vectors]
        fresh = dict(zip(new, self._encoder.encode_texts(new), strict=True)) if new else {}
        rows = [fresh[text] if text in fresh else self._vectors[text] for text in texts]
        return np.stack(rows) if rows else np.zeros((0, self.dim), np.float32)


def _vectors(encoder: Encoder, texts: list[str]) -> Float32:
    """Return the vectors from the file, or encode and file them."""
    path = _path(encoder, texts)
    stored = _load(path, (len(texts), encoder.dim))
    if stored is not None:
        return stored
    vectors = encoder.encode_texts(texts)
    try:
        write_whole(path, lambda file: np.save(file, vectors, allow_pickle=False))
    except OSError as error:
        log.warning("%s: not kept, the next start is slower: %s", path, error)
    return vectors


def _path(encoder: Encoder, texts: list[str]) -> Path:
    digest = hashlib.sha256(json.dumps(texts).encode()).hexdigest()[:12]
    return cache_path() / f"texts-{encoder.model_id}-{digest}.npy"


def _load(path: Path, shape: tuple[int, int]) -> Float32 | None:
    """Return the stored vectors, ``None`` when there are none or they are damaged."""
    if not path.is_file():
        return None
    try:
        stored = np.load(path, allow_pickle=False)
    except (OSError, ValueError, EOFError) as error:
        log.warning("%s: unreadable, made anew: %s", path, error)
        return None
    usable = stored.shape == shape and stored.dtype == np.float32 and np.isfinite(stored).all()
    return stored if usable else None
