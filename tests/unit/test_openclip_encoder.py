"""A folder and a checkpoint as open_clip writes them, against open_clip's own transforms."""

import json
import shutil

import numpy as np
import pytest

from sceneq_core.encoding.encoder import Crop
from sceneq_nodes._openclip_encoder import OpenclipEncoder, OpenclipParams

from support.tiny_towers import DIM, open_clip_or_skip, write_openclip

open_clip = open_clip_or_skip(at_module=True)

SIZES = ((40, 33), (32, 32), (20, 90))


def crop(height, width):
    y, x = np.mgrid[:height, :width]
    waves = [127 + 120 * np.sin(x / 5 + k) * np.cos(y / 6 - k) for k in range(3)]
    return Crop(np.stack(waves, axis=-1).astype(np.uint8), np.ones((height, width), bool))


CROPS = [crop(*size) for size in SIZES]


@pytest.fixture(autouse=True)
def own_cache(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return write_openclip(tmp_path_factory.mktemp("openclip"))


def encoder(folder, **changes):
    return OpenclipEncoder(OpenclipParams(model=str(folder), **changes))


def units(vectors):
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def test_crops_and_texts_are_where_open_clip_puts_them(folder):
    import torch
    from PIL import Image

    model, _, transform = open_clip.create_model_and_transforms(f"local-dir:{folder}")
    model.eval()
    texts = ["red mug", "", "word " * 50]
    with torch.inference_mode():
        seen = model.encode_image(torch.stack([transform(Image.fromarray(c.rgb)) for c in CROPS]))
        read = model.encode_text(open_clip.get_tokenizer(f"local-dir:{folder}")(texts))
    ours = encoder(folder)
    assert (ours.encode_crops(CROPS)[0] * units(seen.numpy())).sum(1) == pytest.approx(1, abs=1e-4)
    assert ours.encode_texts(texts) == pytest.approx(units(read.numpy()), abs=1e-5)
    assert ours.dim == DIM


def test_a_name_with_a_checkpoint_is_another_way_in(tmp_path):
    import torch

    weights = tmp_path / "rn50.pt"
    torch.manual_seed(0)
    torch.save(open_clip.create_model("RN50").state_dict(), weights)
    ours = encoder("RN50", checkpoint=str(weights), like="openai")
    assert ours.dim == 1024
    assert ours.model_id.startswith("openclip-rn50-")
    assert ours.encode_texts(["mug"]).shape == (1, 1024)


def test_the_id_says_which_weights_but_not_where(folder, tmp_path):
    copy = shutil.copytree(folder, tmp_path / "copy")
    assert encoder(copy).model_id == encoder(folder).model_id
    assert encoder(write_openclip(tmp_path / "b", seed=1)).model_id != encoder(folder).model_id


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"model": "ViT-Z-1", "checkpoint": "x"}, "no architecture 'ViT-Z-1'"),
        ({"model": "RN50", "checkpoint": "x"}, "'x' is no file and no tag of RN50"),
        ({"model": "RN50", "checkpoint": "/no/x.pt"}, "^checkpoint: no file /no/x.pt"),
        ({"model": "/no/where"}, "^model: no folder /no/where"),
        ({"model": "RN50", "like": "openai"}, "^like:"),
    ],
)
def test_what_cannot_be_had_is_named(changes, says):
    with pytest.raises(ValueError, match=says):
        OpenclipEncoder(OpenclipParams(**changes))


def test_a_folder_without_weights_or_dimension_is_named(folder, tmp_path):
    copy = shutil.copytree(folder, tmp_path / "copy")
    (copy / "open_clip_pytorch_model.bin").unlink()
    with pytest.raises(ValueError, match=r"no weights; expected open_clip_model.safetensors or"):
        encoder(copy)
    (copy / "open_clip_config.json").write_text(json.dumps({"model_cfg": {}}))
    with pytest.raises(ValueError, match=r"open_clip_config.json: KeyError: 'embed_dim'"):
        encoder(copy)
