"""CLIP, SigLIP and SigLIP 2 from folders as transformers writes them, against its own models."""

import json
import re
import shutil

import numpy as np
import pytest

from sceneq_core.encoding.encoder import Crop
from sceneq_nodes._transformers_encoder import TransformersEncoder, TransformersEncoderParams

from support.tiny_towers import CONTEXT, DIM, write_clip, write_siglip, write_siglip2

transformers = pytest.importorskip("transformers", reason="transformers is not installed")

WRITERS = {"clip": write_clip, "siglip": write_siglip, "siglip2": write_siglip2}
TEXTS = ["red mug", "a Chair!", "", "tasse à café", "word " * 50]
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
def folders(tmp_path_factory):
    transformers.logging.disable_progress_bar()
    return {kind: write(tmp_path_factory.mktemp(kind)) for kind, write in WRITERS.items()}


@pytest.fixture(params=WRITERS)
def folder(request, folders):
    return folders[request.param]


def encoder(folder, **changes):
    return TransformersEncoder(TransformersEncoderParams(model=str(folder), **changes))


def units(vectors):
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def whole_model(folder):
    import torch

    torch.set_grad_enabled(False)
    return transformers.AutoModel.from_pretrained(folder).eval()


def test_crops_are_where_the_whole_model_puts_them(folder):
    config = json.loads((folder / "config.json").read_text())
    processor = {
        "clip": transformers.CLIPImageProcessorPil,
        "siglip": transformers.SiglipImageProcessorPil,
        "siglip2": transformers.Siglip2ImageProcessorPil,
    }[config["model_type"]].from_pretrained(folder)
    fed = processor([crop.rgb for crop in CROPS], return_tensors="pt")
    wanted = whole_model(folder).get_image_features(**fed).pooler_output.numpy()
    got, features = encoder(folder).encode_crops(CROPS)
    assert (got * units(wanted)).sum(axis=1) == pytest.approx(1, abs=1e-4)
    assert features.shape == (len(CROPS), 16)


def test_texts_are_where_the_whole_model_puts_them(folder):
    tokenizer = transformers.AutoTokenizer.from_pretrained(folder)
    pads = "siglip" in json.loads((folder / "config.json").read_text())["model_type"]
    lower = [text.lower() for text in TEXTS]
    fed = tokenizer(
        lower,
        padding="max_length" if pads else "longest",
        truncation=True,
        max_length=CONTEXT,
        return_tensors="pt",
    )
    wanted = whole_model(folder).get_text_features(**fed).pooler_output.numpy()
    assert encoder(folder).encode_texts(TEXTS) == pytest.approx(units(wanted), abs=1e-5)


def test_batches_give_the_same_to_a_rounding(folder):
    one, many = encoder(folder), encoder(folder, batch=3)
    assert one.encode_crops(CROPS)[0] == pytest.approx(many.encode_crops(CROPS)[0], abs=1e-5)
    assert one.encode_texts(TEXTS) == pytest.approx(many.encode_texts(TEXTS), abs=1e-5)


def test_half_precision_is_near(folder):
    full, half = encoder(folder), encoder(folder, dtype="bfloat16")
    assert half.model_id == full.model_id
    cosines = (full.encode_crops(CROPS)[0] * half.encode_crops(CROPS)[0]).sum(axis=1)
    assert cosines.min() > 0.99
    assert half.encode_crops(CROPS)[0].dtype == np.float32


def test_what_it_says_before_anything_is_loaded(folders, monkeypatch):
    clip, siglip = encoder(folders["clip"]), encoder(folders["siglip"])
    assert (clip.dim, siglip.dim) == (DIM, 16)
    assert re.fullmatch(r"clip-[0-9a-f]{10}", clip.model_id)
    assert re.fullmatch(r"siglip-[0-9a-f]{10}", siglip.model_id)


def test_other_weights_are_another_model_wherever_they_lie(folders, tmp_path):
    copy = shutil.copytree(folders["clip"], tmp_path / "copy")
    assert encoder(copy).model_id == encoder(folders["clip"]).model_id
    other = write_clip(tmp_path / "other", seed=1)
    assert encoder(other).model_id != encoder(folders["clip"]).model_id


@pytest.mark.parametrize(
    ("gone", "says"),
    [
        ("config.json", r"config\.json: no such file"),
        ("model.safetensors", "expected weights, such as model.safetensors"),
        ("tokenizer.json", "no tokenizer; expected one of tokenizer.json"),
        ("preprocessor_config.json", "no preprocessor_config.json"),
    ],
)
def test_a_missing_file_is_named(gone, says, folders, tmp_path):
    copy = shutil.copytree(folders["clip"], tmp_path / "copy")
    (copy / gone).unlink()
    with pytest.raises(ValueError, match=says):
        encoder(copy)


@pytest.mark.parametrize(
    ("file", "text", "says"),
    [
        ("config.json", "{", "config.json: no JSON"),
        ("config.json", "[]", "config.json: expected an object"),
        ("config.json", '{"model_type": "bert"}', "expected clip, siglip, siglip2, got 'bert'"),
        ("preprocessor_config.json", "{}", "preprocessor_config.json: KeyError: 'size'"),
        (
            "preprocessor_config.json",
            '{"size": 32, "image_mean": [0.5], "image_std": [1, 1, 1]}',
            "image_mean: expected three numbers",
        ),
        (
            "preprocessor_config.json",
            '{"size": 32, "image_mean": [0, 0, 0], "image_std": [1, 1, 1], "resample": 0}',
            r"resample: expected 2 \(bilinear\) or 3 \(bicubic\), got 0",
        ),
    ],
)
def test_a_wrong_file_is_named_with_what_was_expected(file, text, says, folders, tmp_path):
    copy = shutil.copytree(folders["clip"], tmp_path / "copy")
    (copy / file).write_text(text)
    with pytest.raises(ValueError, match=says):
        encoder(copy)


def test_a_folder_that_is_not_there_is_named():
    with pytest.raises(ValueError, match=r"^model: no folder /no/where"):
        encoder("/no/where")


@pytest.mark.parametrize(
    ("name", "value"),
    [("device", "tpu"), ("dtype", "int8"), ("batch", 0), ("temperature", 0.0), ("ceiling", 1.5)],
)
def test_bad_parameters_are_named(name, value):
    with pytest.raises(ValueError, match=f"^{name}:"):
        TransformersEncoderParams(**{"model": "m", name: value})


def test_a_gpu_that_is_not_there_is_named(folders):
    import torch

    absent = f"cuda:{torch.cuda.device_count()}"
    with pytest.raises(ValueError, match=f"^device: no {absent}"):
        encoder(folders["clip"], device=absent).encode_texts(["mug"])


def test_a_prompt_is_part_of_the_model(folders):
    plain, photo = encoder(folders["clip"]), encoder(folders["clip"], prompt="photo of a {}")
    assert photo.model_id != plain.model_id
    assert photo.encode_texts(["mug"]) == pytest.approx(plain.encode_texts(["photo of a mug"]))
    with pytest.raises(ValueError, match=r"^prompt: needs \{\} where the text goes"):
        TransformersEncoderParams(model="m", prompt="a photo")


def test_weights_that_are_not_there_are_not_made_up(folders, tmp_path):
    from safetensors.numpy import load_file, save_file

    copy = shutil.copytree(folders["clip"], tmp_path / "copy")
    weights = load_file(copy / "model.safetensors")
    del weights["text_projection.weight"]
    save_file(weights, copy / "model.safetensors", metadata={"format": "pt"})
    ours = encoder(copy)
    assert ours.encode_crops(CROPS)[0].shape == (len(CROPS), DIM)
    with pytest.raises(ValueError, match=r"copy: 1 weights of CLIPText.* such as text_projection"):
        ours.encode_texts(["mug"])
