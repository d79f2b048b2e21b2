"""CLIP, SigLIP and SigLIP 2 in the format of transformers: a folder, or the name of a hub model.

Each tower loads when it is first used, from its part of the weights: routing needs the text only.
Pictures are prepared without torchvision.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from sceneq_core.arrays import Float32
from sceneq_core.encoding.preprocess import Patches
from sceneq_nodes._hub import model_folder
from sceneq_nodes._preprocess_file import read_preprocess
from sceneq_nodes._torch import need_device, need_dtype, pretrained, to_numpy
from sceneq_nodes._tower_encoder import TowerEncoder, TowerParams
from sceneq_nodes._weights import model_id, need_file, need_package

VOCABULARY = ("tokenizer.json", "spiece.model", "vocab.json")


@dataclass(frozen=True, slots=True)
class TransformersEncoderParams(TowerParams):
    """``model``: folder or hub name, at ``revision``. ``device`` may be cuda:N too; ``dtype``: auto
    (float16 on a GPU), float32, float16 or bfloat16.
    """

    revision: str = "main"
    dtype: str = "auto"

    def __post_init__(self) -> None:
        TowerParams.__post_init__(self)
        need_device(self)
        need_dtype(self)


@dataclass(frozen=True, slots=True)
class Family:
    """Classes of the towers, where the config says the dimension, and its default."""

    image: str
    text: str
    dim_at: tuple[str, ...]
    dim: int
    pads: bool
    """Texts fill the whole context, as in its training."""


FAMILIES = {
    "clip": Family(
        *("CLIPVisionModelWithProjection", "CLIPTextModelWithProjection"),
        ("projection_dim",),
        512,
        pads=False,
    ),
    "siglip": Family(
        "SiglipVisionModel", "SiglipTextModel", ("vision_config", "hidden_size"), 768, pads=True
    ),
    "siglip2": Family(
        "Siglip2VisionModel", "Siglip2TextModel", ("vision_config", "hidden_size"), 768, pads=True
    ),
}


class TransformersEncoder(TowerEncoder[Float32 | Patches]):
    """Both towers of a model in one folder."""

    Params: ClassVar[type] = TransformersEncoderParams

    def __init__(self, params: TransformersEncoderParams) -> None:
        """Look at the files; raise ``ValueError`` with the file and what was expected of it."""
        need_package("transformers", "transformers", "transformers")
        self._params = params
        self._folder = model_folder(params.model, params.revision)
        config = _config(self._folder)
        self._family = _family(config, self._folder)
        identity = model_id(config["model_type"], _files(self._folder), params.prompt)
        prepare = read_preprocess(self._folder, config["model_type"])
        super().__init__(params, identity, _dim(config, self._family), prepare)

    def _see(self, inputs: list[Float32 | Patches]) -> tuple[Float32, Float32]:
        import torch

        tower = self._image_tower
        with torch.inference_mode():
            fed = {name: torch.from_numpy(value) for name, value in _fed(inputs).items()}
            fed = {name: value.to(tower.device) for name, value in fed.items()}
            fed["pixel_values"] = fed["pixel_values"].to(tower.dtype)
            inner = getattr(tower, "vision_model", tower)
            feature = inner(**fed).pooler_output
            projected = getattr(tower, "visual_projection", _same)(feature)
        return to_numpy(projected), to_numpy(feature)

    def _read(self, texts: list[str]) -> Float32:
        import torch

        tower = self._text_tower
        tokens = self._tokenizer(
            [text.lower() for text in texts],
            padding="max_length" if self._family.pads else "longest",
            truncation=True,
            max_length=tower.config.max_position_embeddings,
            return_tensors="pt",
        )
        with torch.inference_mode():
            told = tower(**tokens.to(tower.device))
        return to_numpy(told.text_embeds if "text_embeds" in told else told.pooler_output)

    @cached_property
    def _image_tower(self) -> Any:
        with self._loading:
            return self._load(self._family.image, "vision_config")

    @cached_property
    def _text_tower(self) -> Any:
        with self._loading:
            return self._load(self._family.text, "text_config")

    @cached_property
    def _tokenizer(self) -> Any:
        from transformers import AutoTokenizer

        with self._loading:
            return AutoTokenizer.from_pretrained(self._folder)

    def _load(self, name: str, part: str) -> Any:
        import torch
        from transformers import AutoConfig

        params = self._params
        torch.set_num_threads(params.threads)
        own = getattr(AutoConfig.from_pretrained(self._folder), part)
        own.projection_dim = self.dim  # a part alone would take it for the default
        return pretrained(name, self._folder, params.device, params.dtype, config=own)


def _same(feature: Any) -> Any:
    return feature


def _fed(inputs: list[Float32 | Patches]) -> dict[str, Any]:
    """Return the tower's arguments for a batch: pictures, or patches with what is padding."""
    patches = [one for one in inputs if isinstance(one, Patches)]
    if not patches:
        return {"pixel_values": np.stack(inputs)}  # type: ignore[arg-type]
    counts = np.array([one.rows * one.columns for one in patches])
    places = np.arange(len(patches[0].values))
    return {
        "pixel_values": np.stack([one.values for one in patches]),
        "pixel_attention_mask": (places[None] < counts[:, None]).astype(np.int64),
        "spatial_shapes": np.array([(one.rows, one.columns) for one in patches], np.int64),
    }


def _config(folder: Path) -> dict[str, Any]:
    path = need_file(folder / "config.json", "the config of a model of transformers")
    try:
        config = json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise ValueError(f"{path}: no JSON: {error}") from error
    if not isinstance(config, dict):
        raise ValueError(f"{path}: expected an object, got {type(config).__name__}")
    return config


def _family(config: Mapping[str, Any], folder: Path) -> Family:
    kind = config.get("model_type")
    if kind not in FAMILIES:
        known = ", ".join(FAMILIES)
        raise ValueError(f"{folder / 'config.json'}: model_type: expected {known}, got {kind!r}")
    return FAMILIES[kind]


def _dim(config: Mapping[str, Any], family: Family) -> int:
    value: Any = config
    for name in family.dim_at:
        value = value.get(name, {}) if isinstance(value, Mapping) else {}
    return value if isinstance(value, int) else family.dim


def _files(folder: Path) -> list[Path]:
    """Return what vectors depend on: weights, vocabulary, config, preprocessing."""
    optional = (*VOCABULARY, "merges.txt", "preprocessor_config.json", "processor_config.json")
    present = [folder / name for name in optional if (folder / name).is_file()]
    if not any(path.name in VOCABULARY for path in present):
        raise ValueError(f"{folder}: no tokenizer; expected one of {', '.join(VOCABULARY)}")
    return [*_weights(folder), folder / "config.json", *present]


def _weights(folder: Path) -> list[Path]:
    if (folder / "model.safetensors").is_file():
        return [folder / "model.safetensors"]
    found = sorted(folder.glob("model-*-of-*.safetensors")) or [folder / "pytorch_model.bin"]
    need_file(found[0], "weights, such as model.safetensors")
    return found
