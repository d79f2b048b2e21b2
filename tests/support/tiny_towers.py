"""Encoders with random weights in the formats that published ones come in: small, real files."""

import importlib
import json
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

PIXELS = 32
DIM = 24
CONTEXT = 12
CLIP_MEAN = [0.48145466, 0.4578275, 0.40821073]
CLIP_STD = [0.26862954, 0.26130258, 0.27577711]
SPECIAL = ("<pad>", "<eos>", "<bos>", "<unk>")
TOWER = {
    "hidden_size": 16,
    "intermediate_size": 32,
    "num_hidden_layers": 2,
    "num_attention_heads": 2,
}


def encoder_spec(kind: str, folder: Path) -> dict:
    """Return the spec of an encoder of ``kind``, with files made in ``folder``; may skip the test.

    Kinds that need no files get none.
    """
    if kind == "transformers":
        pytest.importorskip("transformers", reason="transformers is not installed")
        return {"kind": kind, "model": str(write_clip(folder))}
    if kind == "openclip":
        open_clip_or_skip()
        return {"kind": kind, "model": str(write_openclip(folder))}
    return {"kind": kind, "model": str(write_onnx(folder))} if kind == "onnx" else {"kind": kind}


def open_clip_or_skip(*, at_module: bool = False):
    """Return the module; it imports torchvision, of which there is no build for every torch."""
    if find_spec("open_clip") is None:
        pytest.skip("open_clip_torch is not installed", allow_module_level=at_module)
    try:
        return importlib.import_module("open_clip")
    except (ImportError, RuntimeError) as error:
        pytest.skip(f"open_clip does not import: {error}", allow_module_level=at_module)


def write_openclip(folder: Path, seed: int = 0) -> Path:
    """A CLIP as open_clip keeps it on the hub."""
    import torch

    text = {"context_length": CONTEXT, "vocab_size": 49408, "width": 16, "heads": 2, "layers": 1}
    vision = {"image_size": PIXELS, "layers": 1, "width": 32, "head_width": 16, "patch_size": 8}
    config = {"embed_dim": DIM, "vision_cfg": vision, "text_cfg": text}
    _seeded(seed)
    folder.mkdir(parents=True, exist_ok=True)
    state = open_clip_or_skip().CLIP(**config).state_dict()
    torch.save(state, folder / "open_clip_pytorch_model.bin")
    told = {"size": PIXELS, "mean": CLIP_MEAN, "std": CLIP_STD, "resize_mode": "shortest"}
    document = {"model_cfg": config, "preprocess_cfg": {**told, "interpolation": "bicubic"}}
    (folder / "open_clip_config.json").write_text(json.dumps(document), encoding="utf-8")
    return folder


def write_clip(folder: Path, seed: int = 0) -> Path:
    """CLIP as transformers saves it, with its byte-pair tokenizer."""
    from transformers import CLIPConfig, CLIPImageProcessorPil, CLIPModel, CLIPTokenizer

    letters = [chr(n) for n in range(33, 127)]
    entries = [*letters, *(f"{one}</w>" for one in letters), "<|startoftext|>", "<|endoftext|>"]
    vocabulary = {entry: i for i, entry in enumerate(entries)}
    tokenizer = CLIPTokenizer(vocab=vocabulary, merges=[])
    ends = {"bos_token_id": len(entries) - 2, "eos_token_id": len(entries) - 1}
    text = {**TOWER, "vocab_size": len(entries), "max_position_embeddings": CONTEXT, **ends}
    vision = {**TOWER, "image_size": PIXELS, "patch_size": 8}
    config = CLIPConfig(
        text_config=text,
        vision_config=vision,
        projection_dim=DIM,
        **ends,
        pad_token_id=ends["eos_token_id"],
    )
    _seeded(seed)
    CLIPModel(config).save_pretrained(folder)
    tokenizer.save_pretrained(folder)
    CLIPImageProcessorPil(
        size={"shortest_edge": PIXELS}, crop_size={"height": PIXELS, "width": PIXELS}
    ).save_pretrained(folder)
    return folder


def write_siglip(folder: Path, seed: int = 0) -> Path:
    """SigLIP, or SigLIP 2 of a fixed size: both are saved as this."""
    from transformers import SiglipConfig, SiglipImageProcessorPil, SiglipModel

    text = {**TOWER, "vocab_size": 300, "max_position_embeddings": CONTEXT, "projection_size": 16}
    vision = {**TOWER, "image_size": PIXELS, "patch_size": 8}
    _seeded(seed)
    SiglipModel(SiglipConfig(text_config=text, vision_config=vision)).save_pretrained(folder)
    _byte_tokenizer(folder)
    SiglipImageProcessorPil(size={"height": PIXELS, "width": PIXELS}).save_pretrained(folder)
    return folder


def write_siglip2(folder: Path, seed: int = 0) -> Path:
    """SigLIP 2 that keeps the aspect of its pictures (NaFlex)."""
    from transformers import Siglip2Config, Siglip2ImageProcessorPil, Siglip2Model

    text = {**TOWER, "vocab_size": 300, "max_position_embeddings": CONTEXT, "projection_size": 16}
    vision = {**TOWER, "num_patches": 16, "patch_size": 8}
    _seeded(seed)
    Siglip2Model(Siglip2Config(text_config=text, vision_config=vision)).save_pretrained(folder)
    _byte_tokenizer(folder)
    Siglip2ImageProcessorPil(patch_size=8, max_num_patches=16).save_pretrained(folder)
    return folder


def write_onnx(folder: Path, seed: int = 0, *, dim: int = DIM) -> Path:
    """A pair of graphs: mean colours, and mean token vectors, each times a random matrix."""
    import onnx

    rng = np.random.default_rng(seed)
    folder.mkdir(parents=True, exist_ok=True)
    onnx.save(_image_graph(rng, dim), str(folder / "image.onnx"))
    onnx.save(_text_graph(rng, dim), str(folder / "text.onnx"))
    _byte_tokens().save(str(folder / "tokenizer.json"))
    told = {
        "dim": dim,
        "height_px": PIXELS,
        "width_px": PIXELS,
        "context": CONTEXT,
        "mean": [0.5] * 3,
        "std": [0.5] * 3,
        "fit": "squash",
        "feature_output": "colours",
    }
    (folder / "encoder.json").write_text(json.dumps(told), encoding="utf-8")
    return folder


def _image_graph(rng: np.random.Generator, dim: int):
    from onnx import helper

    nodes = [
        helper.make_node("ReduceMean", ["pixels", "axes"], ["means"], keepdims=0),
        helper.make_node("Concat", ["means", "one"], ["colours_1"], axis=1),
        helper.make_node("Identity", ["means"], ["colours"]),
        helper.make_node("MatMul", ["colours_1", "weight"], ["image_embeds"]),
    ]
    constants = {
        "axes": np.array([2, 3], np.int64),
        "one": np.ones((1, 1), np.float32),
        "weight": rng.normal(size=(4, dim)).astype(np.float32),
    }
    pixels = _port("pixels", [1, 3, PIXELS, PIXELS])
    outputs = [_port("image_embeds", [1, dim]), _port("colours", [1, 3])]
    return _model(nodes, [pixels], outputs, constants)


def _text_graph(rng: np.random.Generator, dim: int):
    from onnx import TensorProto, helper

    nodes = [
        helper.make_node("Gather", ["table", "input_ids"], ["vectors"]),
        helper.make_node("Cast", ["attention_mask"], ["mask"], to=TensorProto.FLOAT),
        helper.make_node("Unsqueeze", ["mask", "last"], ["mask_1"]),
        helper.make_node("Mul", ["vectors", "mask_1"], ["meant"]),
        helper.make_node("ReduceSum", ["meant", "tokens"], ["text_embeds"], keepdims=0),
    ]
    constants = {
        "table": rng.normal(size=(300, dim)).astype(np.float32),
        "last": np.array([2], np.int64),
        "tokens": np.array([1], np.int64),
    }
    inputs = [
        _port(name, ["N", "L"], TensorProto.INT64) for name in ("input_ids", "attention_mask")
    ]
    return _model(nodes, inputs, [_port("text_embeds", ["N", dim])], constants)


def _model(nodes, inputs, outputs, constants):
    from onnx import helper, numpy_helper

    stored = [numpy_helper.from_array(value, name) for name, value in constants.items()]
    graph = helper.make_graph(nodes, "tiny", inputs, outputs, stored)
    return helper.make_model(graph, opset_imports=[helper.make_opsetid("", 18)], ir_version=9)


def _port(name, shape, kind=1):
    from onnx import helper

    return helper.make_tensor_value_info(name, kind, shape)


def _byte_tokens():
    """A tokenizer with one token a byte, and an end."""
    from tokenizers import Tokenizer, models, pre_tokenizers, processors

    letters = sorted(pre_tokenizers.ByteLevel.alphabet())
    entries = [*SPECIAL, *letters]
    vocabulary = {entry: i for i, entry in enumerate(entries)}
    tokenizer = Tokenizer(models.BPE(vocabulary, [], unk_token="<unk>"))
    tokenizer.pre_tokenizer = pre_tokenizers.ByteLevel(add_prefix_space=False)
    tokenizer.post_processor = processors.TemplateProcessing(
        single="$A <eos>", special_tokens=[("<eos>", SPECIAL.index("<eos>"))]
    )
    return tokenizer


def _byte_tokenizer(folder: Path) -> None:
    from transformers import PreTrainedTokenizerFast

    PreTrainedTokenizerFast(
        tokenizer_object=_byte_tokens(), pad_token="<pad>", eos_token="<eos>", unk_token="<unk>"
    ).save_pretrained(folder)


def _seeded(seed: int) -> None:
    import torch

    torch.manual_seed(seed)
