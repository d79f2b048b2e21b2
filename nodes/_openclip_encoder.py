"""CLIP, EVA-CLIP, SigLIP, MobileCLIP and whatever else open_clip knows by name and checkpoint.

The model loads, both towers at once, when it is first used; pictures are prepared here. open_clip
itself imports torchvision, so that has to fit the installed torch.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from importlib.util import find_spec
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import numpy as np

from sceneq_core.arrays import Float32, UInt8
from sceneq_core.encoding.preprocess import Preprocess
from sceneq_nodes._hub import model_folder
from sceneq_nodes._torch import chosen_device, chosen_dtype, need_device, need_dtype, to_numpy
from sceneq_nodes._tower_encoder import TowerEncoder, TowerParams
from sceneq_nodes._weights import model_id, need_file, need_package

CONFIG = "open_clip_config.json"
WEIGHTS = ("open_clip_model.safetensors", "open_clip_pytorch_model.bin")
FITS = {"shortest": "crop", "squash": "squash", "longest": "pad"}


@dataclass(frozen=True, slots=True)
class OpenclipParams(TowerParams):
    """``model``: a name such as ``ViT-B-32`` with a ``checkpoint`` (file, or published tag such as
    ``laion2b_s34b_b79k``), or a folder or hub repository with ``open_clip_config.json``. A file
    does not say how pictures were prepared: ``like`` names the published tag it is prepared like,
    "" = as OpenAI's. ``device`` may be cuda:N too; ``dtype`` as in ``TransformersEncoderParams``.
    """

    checkpoint: str = ""
    like: str = ""
    dtype: str = "auto"

    def __post_init__(self) -> None:
        TowerParams.__post_init__(self)
        need_device(self)
        need_dtype(self)
        if self.like and not self.checkpoint:
            raise ValueError("like: is for a checkpoint file; a folder says it itself")


class _Model(NamedTuple):
    """What open_clip is asked for, and what the files say before it is."""

    name: str
    config: Mapping[str, Any]
    files: tuple[Path, ...]
    arguments: Mapping[str, Any]


class OpenclipEncoder(TowerEncoder[Float32]):
    """Both towers of one open_clip model."""

    Params: ClassVar[type] = OpenclipParams

    def __init__(self, params: OpenclipParams) -> None:
        """Look at the files; raise ``ValueError`` with the file and what was expected of it."""
        need_package("open_clip", "openclip", "openclip")
        self._params = params
        self._model = _named(params) if params.checkpoint else _foldered(params)
        name = f"openclip-{params.model}" if params.checkpoint else "openclip"
        settings = f"{params.like}\0{params.prompt}"
        identity = model_id(name, self._model.files, settings)
        super().__init__(params, identity, int(self._model.config["embed_dim"]), self._prepare)

    def _prepare(self, rgb: UInt8) -> Float32:
        return self._preprocess(rgb)

    def _see(self, inputs: list[Float32]) -> tuple[Float32, Float32]:
        import torch

        with torch.inference_mode():
            weight = next(self._loaded.parameters())
            pixels = torch.from_numpy(np.stack(inputs)).to(weight.device, weight.dtype)
            vectors = to_numpy(self._loaded.encode_image(pixels))
        return vectors, vectors

    def _read(self, texts: list[str]) -> Float32:
        import torch

        with torch.inference_mode():
            device = next(self._loaded.parameters()).device
            return to_numpy(self._loaded.encode_text(self._tokenize(texts).to(device)))

    @cached_property
    def _preprocess(self) -> Preprocess:
        from open_clip import get_model_preprocess_cfg

        return _preprocess(get_model_preprocess_cfg(self._loaded))

    @cached_property
    def _tokenize(self) -> Any:
        from open_clip import get_tokenizer

        with self._loading:
            return get_tokenizer(self._model.name)

    @cached_property
    def _loaded(self) -> Any:
        with self._loading:
            return self._load()

    def _load(self) -> Any:
        import open_clip
        import torch

        device = chosen_device(self._params.device)
        dtype = chosen_dtype(self._params.dtype, device)
        torch.set_num_threads(self._params.threads)
        like = self._params.like
        given = open_clip.get_pretrained_cfg(self._params.model, like) if like else {}
        if like and not given:
            raise ValueError(f"like: open_clip knows no {like!r} of {self._params.model}")
        prepared = {key: given[key] for key in ("mean", "std", "interpolation") if key in given}
        if "resize_mode" in given:
            prepared["resize_mode"] = given["resize_mode"]
        model = open_clip.create_model(
            self._model.name, **self._model.arguments, force_preprocess_cfg=prepared
        )
        return model.to(device, dtype).eval()


def _named(params: OpenclipParams) -> _Model:
    """Return a model that open_clip has the architecture of."""
    folders = find_spec("open_clip").submodule_search_locations  # type: ignore[union-attr]
    architecture = Path(folders[0], "model_configs", f"{params.model.replace('/', '-')}.json")  # type: ignore[index]
    if not architecture.is_file():
        raise ValueError(f"model: open_clip has no architecture {params.model!r}")
    config = json.loads(architecture.read_text(encoding="utf-8"))
    weights = _checkpoint(params)
    return _Model(params.model, config, (weights,), {"pretrained": str(weights)})


def _checkpoint(params: OpenclipParams) -> Path:
    """Return the file with the weights; a tag is resolved by open_clip, which fetches it once."""
    path = Path(params.checkpoint).expanduser()
    if path.is_file():
        return path
    if len(path.parts) > 1 or path.suffix:
        raise ValueError(f"checkpoint: no file {path}")
    import open_clip

    known = open_clip.get_pretrained_cfg(params.model, params.checkpoint)
    if not known:
        tags = ", ".join(open_clip.list_pretrained_tags_by_model(params.model)) or "none"
        raise ValueError(
            f"checkpoint: {params.checkpoint!r} is no file and no tag of {params.model} "
            f"(its tags: {tags})"
        )
    return Path(open_clip.download_pretrained(known))


def _foldered(params: OpenclipParams) -> _Model:
    """Return a model whose folder says everything."""
    folder = model_folder(params.model)
    path = need_file(folder / CONFIG, "open_clip's config, or a checkpoint beside the model's name")
    try:
        config = json.loads(path.read_text(encoding="utf-8"))["model_cfg"]
        config["embed_dim"] = int(config["embed_dim"])
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(f"{path}: {type(error).__name__}: {error}") from error
    weights = next((folder / name for name in WEIGHTS if (folder / name).is_file()), None)
    if weights is None:
        raise ValueError(f"{folder}: no weights; expected {' or '.join(WEIGHTS)}")
    return _Model(f"local-dir:{folder}", config, (weights, path), {})


def _preprocess(told: Mapping[str, Any]) -> Preprocess:
    size, mode = told["size"], told.get("resize_mode", "shortest")
    height, width = (size, size) if isinstance(size, int) else size
    kernel = told.get("interpolation", "bicubic")
    if mode not in FITS or kernel not in ("bicubic", "bilinear"):
        raise ValueError(f"preprocessing of this model is not known: {mode}, {kernel}")
    fill = told.get("fill_color", 0)
    mean, std = (tuple(map(float, told[name])) for name in ("mean", "std"))
    return Preprocess(int(height), int(width), mean, std, FITS[mode], kernel, fill=int(fill))  # type: ignore[arg-type]
