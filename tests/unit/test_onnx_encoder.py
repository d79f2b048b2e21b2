"""A pair of towers as ONNX, of which every number is known."""

import json
import shutil

import numpy as np
import onnx
import pytest

from sceneq_core.encoding.encoder import Crop
from sceneq_nodes._model_error import ModelError
from sceneq_nodes._onnx_encoder import OnnxEncoder, OnnxEncoderParams

from support.tiny_towers import CONTEXT, DIM, write_onnx


@pytest.fixture(autouse=True)
def own_cache(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return write_onnx(tmp_path_factory.mktemp("onnx"))


@pytest.fixture
def copy(folder, tmp_path):
    return shutil.copytree(folder, tmp_path / "copy")


def encoder(folder, **changes):
    return OnnxEncoder(OnnxEncoderParams(model=str(folder), **changes))


def constant(path, name):
    stored = onnx.load(str(path)).graph.initializer
    return next(onnx.numpy_helper.to_array(one) for one in stored if one.name == name)


def crop(colour):
    return Crop(np.full((9, 17, 3), colour, np.uint8), np.ones((9, 17), bool))


def test_a_crop_goes_through_the_graph(folder):
    descriptors, features = encoder(folder).encode_crops([crop((255, 0, 51))])
    assert features[0] == pytest.approx([1.0, -1.0, -0.6], abs=1e-5)
    wanted = np.array([1.0, -1.0, -0.6, 1.0]) @ constant(folder / "image.onnx", "weight")
    assert descriptors[0] == pytest.approx(wanted / np.linalg.norm(wanted), abs=1e-5)


def test_a_text_is_the_sum_of_its_tokens(folder):
    from tokenizers import Tokenizer

    ids = Tokenizer.from_file(str(folder / "tokenizer.json")).encode("red mug").ids
    assert len(ids) == len("red mug") + 1
    wanted = constant(folder / "text.onnx", "table")[ids].sum(axis=0)
    got = encoder(folder).encode_texts(["red mug"])[0]
    assert got == pytest.approx(wanted / np.linalg.norm(wanted), abs=1e-5)


def test_texts_in_company_are_padded_where_the_mask_says_so(folder):
    texts = ["a", "longer", "word " * 30]
    together = encoder(folder, batch=3).encode_texts(texts)
    assert together == pytest.approx(encoder(folder).encode_texts(texts), abs=1e-5)


def test_long_texts_end_at_the_context(folder):
    long, longer = encoder(folder).encode_texts(["x" * CONTEXT, "x" * 3 * CONTEXT])
    assert long == pytest.approx(longer, abs=1e-6)


def test_texts_fill_the_context_when_the_tower_was_trained_so(copy):
    settings(copy, pad_id=0)
    ids = [*([0] * (CONTEXT - 2))]
    table = constant(copy / "text.onnx", "table")
    tokens = [encoder(copy)._tokenizer.encode("a").ids]
    assert len(tokens[0]) == CONTEXT
    assert tokens[0][2:] == ids
    assert table.shape == (300, DIM)


def settings(folder, **changes):
    path = folder / "encoder.json"
    told = json.loads(path.read_text()) | changes
    path.write_text(json.dumps({key: value for key, value in told.items() if value is not None}))


def test_any_file_changes_the_id(folder, copy):
    assert encoder(copy).model_id == encoder(folder).model_id
    settings(copy, lower=True)
    assert encoder(copy).model_id != encoder(folder).model_id


@pytest.mark.parametrize("gone", ["image.onnx", "text.onnx", "tokenizer.json", "encoder.json"])
def test_a_missing_file_is_named(gone, copy):
    (copy / gone).unlink()
    with pytest.raises(ValueError, match=f"{gone}: no such file; expected "):
        encoder(copy)


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"dim": None}, "encoder.json: dim: missing key"),
        ({"dims": 3}, "encoder.json: dims: unknown key"),
        ({"fit": "stretch"}, "encoder.json: fit: .*'crop', 'squash' or 'pad'"),
        ({"std": [1, 0, 1]}, "encoder.json: std: must be positive"),
        ({"context": 0}, "encoder.json: .*context: must be at least 1"),
    ],
)
def test_a_wrong_setting_is_named(changes, says, copy):
    settings(copy, **changes)
    with pytest.raises(ValueError, match=says):
        encoder(copy)


def test_settings_that_are_no_json_object_are_named(copy):
    (copy / "encoder.json").write_text("[1]")
    with pytest.raises(ValueError, match=r"encoder\.json: expected an object, got list"):
        encoder(copy)


def test_a_graph_that_is_none_is_named_when_it_is_needed(copy):
    (copy / "image.onnx").write_bytes(b"no graph")
    ours = encoder(copy)
    assert ours.encode_texts(["mug"]).shape == (1, DIM)
    with pytest.raises(ModelError, match=r"image\.onnx: no usable ONNX model"):
        ours.encode_crops([crop(9)])


def test_a_graph_of_another_dimension_is_named(copy):
    settings(copy, dim=DIM + 1)
    wanted = rf"text\.onnx: expected the output one of shape \(N, {DIM + 1}\), has text_embeds"
    with pytest.raises(ValueError, match=wanted):
        encoder(copy).encode_texts(["mug"])


def test_an_output_that_is_not_there_is_named(copy):
    settings(copy, image_output="embedding")
    with pytest.raises(ValueError, match="expected the output embedding, has image_embeds"):
        encoder(copy).encode_crops([crop(9)])


def test_a_picture_the_graph_does_not_take_is_told_with_its_shape(copy):
    settings(copy, height_px=16)
    with pytest.raises(ValueError, match=r"image\.onnx: fed \{'pixels': \(1, 3, 16, 32\)\}"):
        encoder(copy).encode_crops([crop(9)])


def test_a_tokenizer_that_is_none_is_named(copy):
    (copy / "tokenizer.json").write_text("{}")
    with pytest.raises(ValueError, match=r"tokenizer\.json: no tokenizer of the package"):
        encoder(copy).encode_texts(["mug"])


def test_a_gpu_without_its_runtime_is_named(folder):
    import onnxruntime

    if "CUDAExecutionProvider" in onnxruntime.get_available_providers():
        pytest.skip("this ONNX Runtime has CUDA")
    with pytest.raises(ModelError, match=r"^device: this ONNX Runtime has no CUDA"):
        encoder(folder, device="cuda").encode_texts(["mug"])
