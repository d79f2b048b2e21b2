"""Any pair of towers as ONNX: a folder that holds

    image.onnx      float pictures (N, 3, H, W) -> descriptors (N, dim)
    text.onnx       token ids (N, L), and attention_mask if it has one -> descriptors (N, dim)
    tokenizer.json  of the package tokenizers
    encoder.json    how pictures and texts are prepared: ``EncoderFile``

Each tower loads when it is first used. torch is not needed.
"""

import json
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from sceneq_core.arrays import Array, Float32
from sceneq_core.checks import need_at_least
from sceneq_core.encoding.preprocess import Fit, Preprocess
from sceneq_core.encoding.resample import Kernel
from sceneq_nodes._onnx_session import OnnxModel, Port, need_onnx_device
from sceneq_nodes._params import ParamError, validate
from sceneq_nodes._tower_encoder import TowerEncoder, TowerParams
from sceneq_nodes._weights import model_id, need_file

IMAGE, TEXT, TOKENIZER, SETTINGS = "image.onnx", "text.onnx", "tokenizer.json", "encoder.json"
INTEGERS = {"tensor(int64)": np.int64, "tensor(int32)": np.int32}


@dataclass(frozen=True, slots=True)
class OnnxEncoderParams(TowerParams):
    """``model``: the folder."""

    def __post_init__(self) -> None:
        TowerParams.__post_init__(self)
        need_onnx_device(self)


@dataclass(frozen=True, slots=True)
class EncoderFile:
    """What encoder.json says. ``height_px`` to ``kernel`` as in ``Preprocess``.

    ``context``: most tokens of a text. ``pad_id``: fills short texts up to ``context``, for towers
    trained so (SigLIP); without it texts have the length they have. ``lower``: texts become lower
    case. ``image_output``, ``text_output``: which output is the descriptor, "" = the first of
    shape (N, dim); ``feature_output``: which one is the raw image feature, "" = the descriptor.
    """

    dim: int
    height_px: int
    width_px: int
    mean: tuple[float, float, float]
    std: tuple[float, float, float]
    context: int
    fit: Fit = "crop"
    kernel: Kernel = "bicubic"
    pad_id: int | None = None
    lower: bool = False
    image_output: str = ""
    text_output: str = ""
    feature_output: str = ""

    def __post_init__(self) -> None:
        need_at_least(self, 1, "dim", "context")

    def preprocess(self) -> Preprocess:
        """Return how pictures are prepared."""
        return Preprocess(self.height_px, self.width_px, self.mean, self.std, self.fit, self.kernel)


class OnnxEncoder(TowerEncoder[Float32]):
    """Both towers of a folder."""

    Params: ClassVar[type] = OnnxEncoderParams

    def __init__(self, params: OnnxEncoderParams) -> None:
        """Look at the files; raise ``ValueError`` with the file and what was expected of it."""
        self._params = params
        self._folder = Path(params.model).expanduser()
        if not self._folder.is_dir():
            raise ValueError(f"model: no folder {self._folder}")
        need_file(self._folder / IMAGE, "the image tower")
        need_file(self._folder / TEXT, "the text tower")
        need_file(self._folder / TOKENIZER, "the tokenizer of the text tower")
        self._file = _settings(self._folder / SETTINGS)
        identity = model_id("onnx", _files(self._folder), params.prompt)
        super().__init__(params, identity, self._file.dim, self._file.preprocess())

    def _see(self, inputs: list[Float32]) -> tuple[Float32, Float32]:
        model, file = self._image_tower, self._file
        port = model.inputs[0]
        pixels = np.stack(inputs).astype(np.float16 if "float16" in port.kind else np.float32)
        wanted = self._output(model, file.image_output, IMAGE)
        names = [wanted, file.feature_output or wanted]
        vectors, features = model.run({port.name: pixels}, names)
        return vectors.astype(np.float32), features.astype(np.float32)

    def _read(self, texts: list[str]) -> Float32:
        model, file = self._text_tower, self._file
        given = [text.lower() for text in texts] if file.lower else texts
        tokens = self._tokenizer.encode_batch(given)
        ids = np.array([one.ids for one in tokens])
        mask = np.array([one.attention_mask for one in tokens])
        wanted = self._output(model, file.text_output, TEXT)
        vectors: Float32 = model.run(_fed(model.inputs, ids, mask), [wanted])[0]
        return vectors.astype(np.float32)

    def _output(self, model: OnnxModel, name: str, file: str) -> str:
        names = [port.name for port in model.outputs]
        if name in names:
            return name
        fitting = [p.name for p in model.outputs if len(p.shape) == 2 and _may_be(p, self.dim)]
        if name or not fitting:
            wanted = name or f"one of shape (N, {self.dim})"
            shown = ", ".join(f"{p.name} {p.shape}" for p in model.outputs)
            raise ValueError(f"{self._folder / file}: expected the output {wanted}, has {shown}")
        return fitting[0]

    @cached_property
    def _image_tower(self) -> OnnxModel:
        return self._load(IMAGE)

    @cached_property
    def _text_tower(self) -> OnnxModel:
        return self._load(TEXT)

    def _load(self, name: str) -> OnnxModel:
        with self._loading:
            return OnnxModel(self._folder / name, self._params.device, self._params.threads)

    @cached_property
    def _tokenizer(self) -> Any:
        from tokenizers import Tokenizer

        path, file = self._folder / TOKENIZER, self._file
        try:
            tokenizer = Tokenizer.from_file(str(path))
        except Exception as error:  # the package raises nothing more specific
            raise ValueError(f"{path}: no tokenizer of the package tokenizers: {error}") from error
        tokenizer.enable_truncation(file.context)
        if file.pad_id is None:
            tokenizer.enable_padding()
        else:
            tokenizer.enable_padding(pad_id=file.pad_id, length=file.context)
        return tokenizer


def _fed(inputs: list[Port], ids: Array, mask: Array) -> dict[str, Array]:
    """Return ids and, where the tower takes it, the mask, in the integers it takes."""
    given = {port.name: mask if "mask" in port.name else ids for port in inputs}
    return {port.name: given[port.name].astype(INTEGERS[port.kind]) for port in inputs}


def _may_be(port: Port, dim: int) -> bool:
    return port.shape[1] == dim or not isinstance(port.shape[1], int)


def _settings(path: Path) -> EncoderFile:
    need_file(path, "how pictures and texts are prepared")
    try:
        told = json.loads(path.read_text(encoding="utf-8"))
        if not isinstance(told, dict):
            raise ValueError(f"expected an object, got {type(told).__name__}")
        file = validate(EncoderFile, told)
        file.preprocess()
    except ParamError as error:
        raise ValueError(f"{path}: {error}") from error
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error
    return file


def _files(folder: Path) -> list[Path]:
    """Return what vectors depend on; weights of large models lie in files beside the graphs."""
    parts = sorted(path for path in folder.iterdir() if ".onnx" in path.name)
    return [*parts, folder / TOKENIZER, folder / SETTINGS]
