"""A segmentation network as one ONNX file; what it gives says which kind it is.

detections (1, 4 + classes + M, N) and prototypes (1, M, h, w)   FastSAM, YOLO-seg as exported
whole numbers (1, h, w), (1, 1, h, w) or (h, w)                  a label image, 0 = no segment
"""

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import ClassVar, Literal

import numpy as np

from sceneq_core.arrays import Array, Float32, UInt16
from sceneq_core.checks import need_at_least, need_within
from sceneq_core.encoding.preprocess import scaled
from sceneq_core.frame import Frame
from sceneq_core.segmentation.label_image import MOST, compact
from sceneq_core.segmentation.letterbox import Letterbox, fitted, squashed
from sceneq_core.segmentation.prototype_masks import DetectionParams, detection_labels
from sceneq_nodes._model_error import ModelError
from sceneq_nodes._onnx_session import OnnxModel, Port, need_onnx_device
from sceneq_nodes._weights import need_file


@dataclass(frozen=True, slots=True)
class OnnxSegmenterParams:
    """``model``: the file. ``device``: auto, cpu or cuda; ``threads`` on a CPU. ``side_px``: of the
    input where the file leaves it open. ``fit``: ``letterbox`` keeps the aspect and fills with
    grey ``fill``, ``squash`` does not. Pixels 0..1 become (x - ``mean``) / ``std``.
    ``detections``: which ones are kept; of a label image, its ``least_px``.
    """

    model: str
    device: str = "auto"
    threads: int = 1
    side_px: int = 1024
    fit: Literal["letterbox", "squash"] = "letterbox"
    fill: int = 114
    mean: tuple[float, float, float] = (0.0, 0.0, 0.0)
    std: tuple[float, float, float] = (1.0, 1.0, 1.0)
    detections: DetectionParams = field(default_factory=DetectionParams)

    def __post_init__(self) -> None:
        need_onnx_device(self)
        need_at_least(self, 1, "threads", "side_px")
        need_within(self, 0, 255, "fill")
        if not min(self.std) > 0:
            raise ValueError(f"std: must be positive, got {self.std}")


class OnnxSegmenter:
    """Runs the network on every frame; it loads with the first one."""

    Params: ClassVar[type] = OnnxSegmenterParams

    def __init__(self, params: OnnxSegmenterParams) -> None:
        """Look for the file; raise ``ValueError`` when it does not exist."""
        self._params = params
        self._path = need_file(Path(params.model).expanduser(), "a segmentation network as ONNX")

    def segment(self, frame: Frame) -> UInt16:
        """Return the labels uint16 (H, W) of ``frame``, 0 = no segment.

        Raises:
            ModelError: not an ONNX model, or its input or output is of no kind known here.
            ValueError: labels of this frame that do not fit.
        """
        height, width = frame.rgb.shape[:2]
        size = self._size
        box = (
            fitted(height, width, size, centred=True)
            if self._params.fit == "letterbox"
            else squashed(height, width, size)
        )
        placed = box.placed(frame.rgb, size, self._params.fill)
        return self._labels(self._run(scaled(placed, self._params.mean, self._params.std)), box)

    def _run(self, pixels: Float32) -> list[Array]:
        port = self._model.inputs[0]
        kind = np.float16 if "float16" in port.kind else np.float32
        wanted = [output.name for output in self._model.outputs]
        return self._model.run({port.name: pixels[None].astype(kind)}, wanted)

    def _labels(self, told: list[Array], box: Letterbox) -> UInt16:
        whole = [one for one in told if np.issubdtype(one.dtype, np.integer)]
        if len(told) == 1 and whole and np.squeeze(whole[0]).ndim <= 2:
            return self._label_map(whole[0], box)
        flat = [one for one in told if one.ndim == 3 and len(one) == 1]
        deep = [one for one in told if one.ndim == 4 and len(one) == 1]
        if not flat or not deep or flat[0].shape[1] <= 4 + deep[0].shape[1]:
            shapes = ", ".join(f"{one.dtype} {one.shape}" for one in told)
            raise ModelError(
                f"{self._path}: expected detections (1, 4 + classes + M, N) with prototypes "
                f"(1, M, h, w), or whole numbers (1, h, w); it gives {shapes}"
            )
        detections, prototypes = flat[0][0].astype(np.float32), deep[0][0].astype(np.float32)
        return detection_labels(detections, prototypes, box, self._size, self._params.detections)

    def _label_map(self, told: Array, box: Letterbox) -> UInt16:
        labels = told.reshape(told.shape[-2:])
        if labels.min() < 0 or labels.max() > MOST:
            low, high = labels.min(), labels.max()
            raise ValueError(f"{self._path}: labels from {low} to {high} are not in 0 to {MOST}")
        restored = box.restored(labels.astype(np.uint16), self._size, nearest=True)
        return compact(restored, self._params.detections.least_px)

    @cached_property
    def _size(self) -> tuple[int, int]:
        """The height and width of the input in pixels."""
        port: Port = self._model.inputs[0]
        if len(port.shape) != 4 or (isinstance(port.shape[1], int) and port.shape[1] != 3):
            raise ModelError(
                f"{self._path}: expected the input (1, 3, H, W), has {port.name} {port.shape}"
            )
        height, width = (n if isinstance(n, int) else self._params.side_px for n in port.shape[2:])
        return height, width

    @cached_property
    def _model(self) -> OnnxModel:
        return OnnxModel(self._path, self._params.device, self._params.threads)
