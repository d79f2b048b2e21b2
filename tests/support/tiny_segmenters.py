"""Segmenters with made-up weights in the formats that published ones come in."""

from pathlib import Path

import numpy as np
import pytest

SIDE = 64
LOW = SIDE // 4


def network_spec(kind: str, folder: Path) -> dict:
    """Return the parameters of a segmenter of ``kind``, with files made once in ``folder``.

    May skip the test. Random networks are unsure: what they give is kept all the same.
    """
    if kind == "sam":
        pytest.importorskip("transformers", reason="transformers is not installed")
        path = folder / "sam2"
        masks = {"points_per_side": 3, "iou_min": 0, "stability_min": 0, "least_px": 4}
        made = path if path.is_dir() else write_sam2(path)
        return {"model": str(made), "masks": masks}
    if kind == "onnx":
        return {"model": str(write_detector(folder / "detector.onnx"))}
    return {}


def write_sam(folder: Path, seed: int = 0) -> Path:
    """SAM as transformers saves it."""
    import torch
    from transformers import SamConfig, SamModel

    torch.manual_seed(seed)
    config = SamConfig(
        vision_config={
            "hidden_size": 16,
            "output_channels": 16,
            "num_hidden_layers": 2,
            "num_attention_heads": 2,
            "image_size": SIDE,
            "patch_size": 16,
            "mlp_dim": 32,
            "window_size": 2,
            "global_attn_indexes": [1],
            "num_pos_feats": 8,
        },
        prompt_encoder_config={
            "hidden_size": 16,
            "image_size": SIDE,
            "patch_size": 16,
            "mask_input_channels": 4,
        },
        mask_decoder_config={
            "hidden_size": 16,
            "mlp_dim": 32,
            "num_hidden_layers": 1,
            "num_attention_heads": 2,
            "iou_head_hidden_dim": 16,
        },
    )
    SamModel(config).save_pretrained(folder)
    return folder


def write_sam2(folder: Path, seed: int = 0) -> Path:
    """SAM 2 as transformers saves it."""
    import torch
    from transformers import Sam2Config, Sam2Model

    torch.manual_seed(seed)
    backbone = {
        "hidden_size": 8,
        "num_attention_heads": 1,
        "image_size": [SIDE, SIDE],
        "blocks_per_stage": [1, 2, 1, 1],
        "embed_dim_per_stage": [8, 16, 32, 64],
        "num_attention_heads_per_stage": [1, 1, 2, 2],
        "window_size_per_stage": [8, 4, 4, 4],
        "global_attention_blocks": [2],
        "query_stride": [2, 2],
        "num_query_pool_stages": 3,
        "window_positional_embedding_background_size": [4, 4],
    }
    config = Sam2Config(
        vision_config={
            "backbone_config": {"model_type": "sam2_hiera_det_model", **backbone},
            "backbone_channel_list": [64, 32, 16, 8],
            "backbone_feature_sizes": [[16, 16], [8, 8], [4, 4]],
            "fpn_hidden_size": 32,
            "num_feature_levels": 3,
        },
        prompt_encoder_config={"hidden_size": 32, "image_size": SIDE, "patch_size": 16},
        mask_decoder_config={
            "hidden_size": 32,
            "mlp_dim": 32,
            "num_hidden_layers": 1,
            "num_attention_heads": 2,
            "iou_head_hidden_dim": 16,
        },
    )
    Sam2Model(config).save_pretrained(folder)
    return folder


def write_sam2_video(folder: Path) -> Path:
    """SAM 2 with its memory of a video, as published checkpoints are saved."""
    from transformers import Sam2Config, Sam2VideoConfig, Sam2VideoModel

    image = Sam2Config.from_pretrained(write_sam2(folder / "image"))
    parts = ("vision_config", "prompt_encoder_config", "mask_decoder_config")
    config = Sam2VideoConfig(
        **{part: getattr(image, part).to_dict() for part in parts},
        image_size=SIDE,
        memory_attention_hidden_size=32,
        memory_attention_num_layers=1,
        memory_attention_feed_forward_hidden_size=32,
        memory_encoder_hidden_size=32,
        memory_encoder_output_channels=16,
        mask_downsampler_embed_dim=32,
        memory_fuser_embed_dim=32,
        memory_fuser_intermediate_dim=32,
        memory_fuser_num_layers=1,
    )
    Sam2VideoModel(config).save_pretrained(folder)
    return folder


def write_detector(path: Path) -> Path:
    """A network of FastSAM's form that sees two things, one of them twice, and a weak third.

    In the input of 64 x 64: prototype 0 is positive in the left half, prototype 1 everywhere.
    Detections: A, all of the picture, prototype 0; B, (40, 16)-(56, 32), prototype 1; C, B again
    with a lower score; D, below any threshold.
    """
    prototypes = np.full((1, 2, LOW, LOW), 1.0, np.float32)
    prototypes[0, 0, :, LOW // 2 :] = -1.0
    detections = np.array(
        [
            [32, 32, 64, 64, 0.9, 4.0, 0.0],
            [48, 24, 16, 16, 0.8, 0.0, 4.0],
            [48, 24, 16, 15, 0.7, 0.0, 4.0],
            [10, 10, 8, 8, 0.1, 0.0, 4.0],
        ],
        np.float32,
    ).T[None]
    constants = {"prototypes": prototypes, "detections": np.ascontiguousarray(detections)}
    return _constant_network(path, constants)


def write_label_map(path: Path, labels: np.ndarray) -> Path:
    """A network that gives ``labels`` (1, h, w) for any picture."""
    return _constant_network(path, {"labels": labels})


def _constant_network(path, outputs):
    """A network of any input (1, 3, 64, 64); each output is a constant that waits for it."""
    import onnx
    from onnx import helper, numpy_helper

    ports, stored = [], [numpy_helper.from_array(np.array(0, np.float32), "zero")]
    nodes = [
        helper.make_node("ReduceMean", ["images"], ["mean"], keepdims=0),
        helper.make_node("Mul", ["mean", "zero"], ["nothing"]),
    ]
    for name, value in outputs.items():
        kind = helper.np_dtype_to_tensor_dtype(value.dtype)
        stored.append(numpy_helper.from_array(value, f"{name}_is"))
        nodes.append(helper.make_node("Cast", ["nothing"], [f"{name}_0"], to=kind))
        nodes.append(helper.make_node("Add", [f"{name}_is", f"{name}_0"], [name]))
        ports.append(helper.make_tensor_value_info(name, kind, value.shape))
    images = helper.make_tensor_value_info("images", 1, [1, 3, SIDE, SIDE])
    graph = helper.make_graph(nodes, "tiny", [images], ports, stored)
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 18)], ir_version=9)
    onnx.save(model, str(path))
    return path
