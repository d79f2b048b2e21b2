"""SAM and SAM 2 through transformers: automatic masks from a grid of points.

The network loads with the first frame, and needs a GPU to keep up with a camera. Pictures are
prepared and masks filtered here: transformers' own processors of SAM 2 need torchvision.
"""

import json
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar, NamedTuple

import numpy as np

from sceneq_core.arrays import Float32, UInt8, UInt16
from sceneq_core.checks import need_at_least
from sceneq_core.encoding.preprocess import scaled
from sceneq_core.frame import Frame
from sceneq_core.segmentation.automatic_masks import AutomaticParams, automatic_labels
from sceneq_core.segmentation.letterbox import Letterbox, fitted, squashed
from sceneq_nodes._hub import model_folder
from sceneq_nodes._model_error import ModelError
from sceneq_nodes._torch import need_device, need_dtype, pretrained, to_numpy
from sceneq_nodes._weights import need_file, need_package

MEAN = (0.485, 0.456, 0.406)
STD = (0.229, 0.224, 0.225)
"""Of ImageNet: what both were trained with."""


@dataclass(frozen=True, slots=True)
class SamParams:
    """``model``: folder or hub name, such as ``facebook/sam2.1-hiera-tiny``, at ``revision``.
    ``device``: auto, cpu, cuda or cuda:N; ``dtype``: auto (float16 on a GPU), float32, float16 or
    bfloat16; ``threads`` on a CPU; ``masks``: grid and filters.
    """

    model: str
    revision: str = "main"
    device: str = "auto"
    dtype: str = "auto"
    threads: int = 1
    masks: AutomaticParams = field(default_factory=AutomaticParams)

    def __post_init__(self) -> None:
        need_device(self)
        need_dtype(self)
        need_at_least(self, 1, "threads")


class _Kind(NamedTuple):
    model: str
    keeps_aspect: bool


KINDS = {
    "sam": _Kind("SamModel", keeps_aspect=True),
    "sam2": _Kind("Sam2Model", keeps_aspect=False),
    "sam2_video": _Kind("Sam2Model", keeps_aspect=False),
}
"""Published SAM 2 checkpoints call themselves ``sam2_video``; their image part is what is used."""


class SamSegmenter:
    """Asks the network at a grid of points of every frame."""

    Params: ClassVar[type] = SamParams

    def __init__(self, params: SamParams) -> None:
        """Look at the files; raise ``ValueError`` with the file and what was expected of it."""
        need_package("transformers", "transformers", "sam")
        self._params = params
        self._folder = model_folder(params.model, params.revision)
        path = need_file(self._folder / "config.json", "the config of a model of transformers")
        try:
            kind = json.loads(path.read_text(encoding="utf-8")).get("model_type")
        except (AttributeError, ValueError) as error:
            raise ValueError(f"{path}: no JSON object: {error}") from error
        if kind not in KINDS:
            raise ValueError(f"{path}: model_type: expected {', '.join(KINDS)}, got {kind!r}")
        self._kind = KINDS[kind]

    def segment(self, frame: Frame) -> UInt16:
        """Return the labels uint16 (H, W) of ``frame``, 0 = no segment.

        Raises:
            ModelError: the weights or the device are not there.
        """
        import torch

        size = (self._side_px, self._side_px)
        height, width = frame.rgb.shape[:2]
        box = (
            fitted(height, width, size, centred=False)
            if self._kind.keeps_aspect
            else squashed(height, width, size)
        )
        with torch.inference_mode():
            seen = self._model.get_image_embeddings(self._tensor(_pixels(frame.rgb, box, size)))
            return automatic_labels(
                lambda points: self._prompt(seen, points), box, size, self._params.masks
            )

    def _prompt(self, seen: Any, points: Float32) -> tuple[Float32, Float32]:
        told = self._model(
            image_embeddings=seen,
            input_points=self._tensor(points[None, :, None]),
            multimask_output=True,
        )
        return to_numpy(told.pred_masks[0]), to_numpy(told.iou_scores[0])

    def _tensor(self, values: Float32) -> Any:
        import torch

        return torch.from_numpy(values).to(self._model.device, self._model.dtype)

    @property
    def _side_px(self) -> int:
        return int(self._model.config.prompt_encoder_config.image_size)

    @cached_property
    def _model(self) -> Any:
        import torch

        params = self._params
        torch.set_num_threads(params.threads)
        try:
            return pretrained(self._kind.model, self._folder, params.device, params.dtype)
        except ValueError as error:  # which would pass for a frame without masks
            raise ModelError(str(error)) from error


def _pixels(rgb: UInt8, box: Letterbox, size: tuple[int, int]) -> Float32:
    """Return (1, 3, H, W): the scaled picture, and zeros beside it."""
    pixels = np.zeros((1, 3, *size), np.float32)
    pixels[0, :, : box.inner_height, : box.inner_width] = scaled(box.inner(rgb), MEAN, STD)
    return pixels
