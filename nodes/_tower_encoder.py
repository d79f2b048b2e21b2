"""What encoders made of two towers have in common."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from threading import RLock
from typing import Generic, TypeVar

from sceneq_core.arrays import Float32, UInt8
from sceneq_core.checks import need_at_least, need_between, need_positive
from sceneq_core.encoding.encoder import Crop
from sceneq_core.encoding.towers import Towers
from sceneq_nodes._weights import need_prompt

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class TowerParams:
    """``model``: which one. ``device``: auto, cpu or cuda; ``batch`` crops or texts at once;
    ``threads`` on a CPU; ``text_cache`` texts are remembered. ``prompt``: what a text is put into,
    such as ``a photo of a {}``. ``temperature`` T of softmax(s / T) and ``ceiling`` as in
    ``Encoder``: CLIP's training ends at T = 0.01, ``sceneq calibrate`` fits another.
    """

    model: str
    device: str = "auto"
    batch: int = 1
    threads: int = 1
    text_cache: int = 4096
    prompt: str = "{}"
    temperature: float = 0.01
    ceiling: float = 1.0

    def __post_init__(self) -> None:
        need_at_least(self, 1, "batch", "threads", "text_cache")
        need_prompt(self)
        need_positive(self, "temperature")
        need_between(self, 0, 1.0000001, "ceiling")


class TowerEncoder(ABC, Generic[T]):
    """An ``Encoder`` that says how a batch goes through each tower, and loads them when it does."""

    def __init__(
        self, params: TowerParams, model_id: str, dim: int, prepare: Callable[[UInt8], T]
    ) -> None:
        self.model_id = model_id
        self.dim = dim
        self.temperature = params.temperature
        self.ceiling = params.ceiling
        self._loading = RLock()
        self._towers: Towers[T] = Towers(
            prepare,
            self._see,
            self._read,
            dim=dim,
            batch=params.batch,
            text_cache=params.text_cache,
            prompt=params.prompt,
        )

    def encode_crops(self, crops: Sequence[Crop]) -> tuple[Float32, Float32]:
        """Return descriptors (N, dim), L2-normalised, and the image tower's features (N, F)."""
        return self._towers.encode_crops(crops)

    def encode_texts(self, texts: Sequence[str]) -> Float32:
        """Return (N, dim), L2-normalised."""
        return self._towers.encode_texts(texts)

    @abstractmethod
    def _see(self, inputs: list[T]) -> tuple[Float32, Float32]:
        """Return descriptors (N, dim) of any length, and features (N, F), of prepared crops."""

    @abstractmethod
    def _read(self, texts: list[str]) -> Float32:
        """Return descriptors (N, dim) of any length."""
