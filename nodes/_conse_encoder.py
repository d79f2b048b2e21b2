"""The embedded default encoder: weights from installed packages, ONNX Runtime, no download."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from threading import RLock
from typing import Any, ClassVar

import numpy as np

from sceneq_core.arrays import Float32, Float64
from sceneq_core.encoding.conse import Conse
from sceneq_core.encoding.encoder import Crop
from sceneq_core.encoding.prior import indoor_prior
from sceneq_nodes._assets import Assets, assets
from sceneq_nodes._classifier_onnx import FEATURE, INPUT, LOGITS, SIDE_PX
from sceneq_nodes._probe_file import HOUSEHOLD, read_probe
from sceneq_nodes._sentence import SentenceTower, session


@dataclass(frozen=True, slots=True)
class ConseParams:
    """``threads`` a model may use; ``text_cache`` texts are remembered.

    ``probe``: file of ``sceneq train-probe``; default: what comes with the program.
    """

    threads: int = 1
    text_cache: int = 4096
    probe: str | None = None

    def __post_init__(self) -> None:
        if self.threads < 1:
            raise ValueError(f"threads: must be at least 1, got {self.threads}")
        if self.text_cache < 1:
            raise ValueError(f"text_cache: must be at least 1, got {self.text_cache}")


class ConseEncoder:
    """``Conse`` on files. Each tower loads when it is first used: routing needs the text only."""

    Params: ClassVar[type] = ConseParams

    def __init__(self, params: ConseParams) -> None:
        """Read the probe; raise ``ValueError`` naming its file when that cannot be used."""
        taught = read_probe(Path(params.probe) if params.probe else HOUSEHOLD)
        self._conse = Conse(
            classify=self._run_classifier,
            embed=lambda text: self._sentence.embed(text),
            class_vectors=lambda: self._class_vectors,
            prior=indoor_prior(),
            lessons=taught.lessons,
            side_px=SIDE_PX,
            text_cache=params.text_cache,
        )
        self.model_id = f"conse-lite2-minilm-v3-{taught.digest}"
        self.dim = self._conse.dim
        self.temperature = 0.033
        # Of its most confident quarter of names 40 to 50 % are right (real, blurred kitchen).
        self.ceiling = 0.45
        self._threads = params.threads
        self._loading = RLock()

    def encode_crops(self, crops: Sequence[Crop]) -> tuple[Float32, Float32]:
        """Return descriptors (N, dim), L2-normalised, and the classifier's features (N, 1280)."""
        return self._conse.encode_crops(crops)

    def encode_texts(self, texts: Sequence[str]) -> Float32:
        """Return (N, dim), L2-normalised."""
        return self._conse.encode_texts(texts)

    def sized(self, descriptor: Float32, shape: Float64) -> Float32:
        """Return the descriptor (D,) of a thing that has this shape (4,), length 1."""
        return self._conse.sized(descriptor, shape)

    def familiarity(self, feature: Float32) -> float:
        """Return how much an image feature (F,) is like what was taught, 1 = the same."""
        return self._conse.familiarity(feature)

    def _run_classifier(self, image: Float32) -> tuple[Float32, Float32]:
        logits, feature = self._classifier.run([LOGITS, FEATURE], {INPUT: image})
        return logits[0], feature[0]

    @cached_property
    def _assets(self) -> Assets:
        return assets()

    @cached_property
    def _classifier(self) -> Any:
        with self._loading:
            return session(self._assets.classifier, self._threads)

    @cached_property
    def _sentence(self) -> SentenceTower:
        with self._loading:
            files = self._assets
            return SentenceTower(files.sentence_model, files.tokenizer, self._threads)

    def embed_all(self, texts: Sequence[str]) -> Float32:
        """Return the sentence vectors of texts as they are, float32 (N, 384), length 1."""
        return np.stack([self._sentence.embed(text) for text in texts])

    @cached_property
    def _class_vectors(self) -> Float32:
        vectors: Float32 = np.load(self._assets.class_vectors, allow_pickle=False)
        return vectors
