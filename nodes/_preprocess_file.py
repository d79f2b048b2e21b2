"""How pictures were prepared for a model of transformers, read from beside its weights."""

import json
from pathlib import Path
from typing import Any

from sceneq_core.encoding.preprocess import PatchPreprocess, Preprocess

NAMES = ("preprocessor_config.json", "processor_config.json")
KERNELS = {2: "bilinear", 3: "bicubic"}
"""Pillow's numbers."""


def read_preprocess(folder: Path, model_type: str) -> Preprocess | PatchPreprocess:
    """Return the preprocessing of the model in ``folder``.

    Raises:
        ValueError: the file is missing, or says something no tower here was trained with; the
            message names file and key.
    """
    path = next((folder / name for name in NAMES if (folder / name).is_file()), None)
    if path is None:
        raise ValueError(f"{folder}: no {NAMES[0]}, which says how pictures are prepared")
    try:
        told = json.loads(path.read_text(encoding="utf-8"))
        told = told.get("image_processor", told)
        return _patches(told) if model_type == "siglip2" else _picture(told)
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        raise ValueError(f"{path}: {type(error).__name__}: {error}") from error


def _patches(told: dict[str, Any]) -> PatchPreprocess:
    return PatchPreprocess(
        patch_px=int(told.get("patch_size", 16)),
        patches=int(told.get("max_num_patches", 256)),
        mean=_colour(told, "image_mean"),
        std=_colour(told, "image_std"),
        kernel=_kernel(told, 2),
    )


def _picture(told: dict[str, Any]) -> Preprocess:
    size, mean, std = told["size"], _colour(told, "image_mean"), _colour(told, "image_std")
    kernel = _kernel(told, 3)
    edge = size if isinstance(size, int) else size.get("shortest_edge")
    if edge is None:
        height, width = int(size["height"]), int(size["width"])
        return Preprocess(height, width, mean, std, fit="squash", kernel=kernel)
    crop = told.get("crop_size", edge)
    height, width = (
        (crop, crop) if isinstance(crop, int) else (int(crop["height"]), int(crop["width"]))
    )
    return Preprocess(height, width, mean, std, kernel=kernel, edge_px=int(edge))


def _kernel(told: dict[str, Any], default: int) -> Any:
    number = told.get("resample", default)
    if number not in KERNELS:
        raise ValueError(f"resample: expected 2 (bilinear) or 3 (bicubic), got {number!r}")
    return KERNELS[number]


def _colour(told: dict[str, Any], name: str) -> tuple[float, float, float]:
    value = told[name]
    if not isinstance(value, list) or len(value) != 3:
        raise ValueError(f"{name}: expected three numbers, got {value!r}")
    return float(value[0]), float(value[1]), float(value[2])
