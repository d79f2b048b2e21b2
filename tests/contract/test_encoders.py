"""What every encoder promises, whatever is inside."""

import re

import numpy as np
import pytest

from sceneq_core.encoding.encoder import Crop
from sceneq_nodes._backends import build, kinds

from support.tiny_towers import encoder_spec

TEXTS = ["red mug", "chair", "", "  ", "Tasse à café 咖啡杯 ☕", "a" * 5000, "something to sit on"]


KINDS = sorted(kinds("encoder"))
UNTAUGHT = {"onnx", "openclip", "transformers"}
"""What they know is in the weights they are given; here those are random."""


@pytest.fixture(scope="module", params=KINDS)
def encoder(request, tmp_path_factory):
    return built(request.param, tmp_path_factory)


@pytest.fixture(scope="module", params=[kind for kind in KINDS if kind not in UNTAUGHT])
def taught(request, tmp_path_factory):
    return built(request.param, tmp_path_factory)


def built(kind, tmp_path_factory):
    spec = encoder_spec(kind, tmp_path_factory.mktemp(kind))
    with pytest.MonkeyPatch.context() as patch:
        if kind in UNTAUGHT:  # the user's cache is for weights that stay
            patch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.mktemp("cache")))
        return build("encoder", spec)


@pytest.fixture(scope="module")
def crops():
    rng = np.random.default_rng(5)
    sizes = ((1, 1), (1, 40), (37, 3), (120, 90), (300, 400))
    return [
        Crop(rng.integers(0, 256, (h, w, 3), np.uint8), rng.random((h, w)) < 0.5) for h, w in sizes
    ] + [Crop(np.zeros((20, 20, 3), np.uint8), np.zeros((20, 20), bool))]


def test_it_says_what_it_is(encoder):
    assert re.fullmatch(r"[a-z0-9_-]+", encoder.model_id)
    assert encoder.dim > 0
    assert encoder.temperature > 0
    assert 0 < encoder.ceiling <= 1


def test_texts_become_unit_vectors(encoder):
    vectors = encoder.encode_texts(TEXTS)
    assert vectors.shape == (len(TEXTS), encoder.dim)
    assert vectors.dtype == np.float32
    assert np.linalg.norm(vectors, axis=1) == pytest.approx(1, abs=1e-5)


def test_crops_become_unit_vectors_and_features(encoder, crops):
    descriptors, features = encoder.encode_crops(crops)
    assert descriptors.shape == (len(crops), encoder.dim)
    assert features.shape[0] == len(crops)
    assert descriptors.dtype == features.dtype == np.float32
    assert np.linalg.norm(descriptors, axis=1) == pytest.approx(1, abs=1e-5)
    assert np.isfinite(features).all()


def test_the_same_input_gives_the_same_bits_alone_or_in_company(encoder, crops):
    together = encoder.encode_crops(crops)[0]
    alone = encoder.encode_crops(crops[3:4])[0]
    assert alone.tobytes() == together[3:4].tobytes()
    assert encoder.encode_texts(TEXTS)[1:2].tobytes() == encoder.encode_texts(["chair"]).tobytes()


def test_nothing_in_nothing_out(encoder):
    descriptors, features = encoder.encode_crops([])
    assert len(descriptors) == len(features) == 0
    assert encoder.encode_texts([]).shape == (0, encoder.dim)


def test_a_colour_word_ranks_crops_of_that_colour_first(taught):
    patches = [np.full((64, 64, 3), rgb, np.uint8) for rgb in ((200, 25, 35), (30, 85, 190))]
    crops = [Crop(patch, np.ones((64, 64), bool)) for patch in patches]
    scores = taught.encode_crops(crops)[0] @ taught.encode_texts(["red", "blue"]).T
    assert scores.argmax(axis=1).tolist() == [0, 1]


def test_like_texts_are_close(taught):
    mug, same, sky = taught.encode_texts(["blue mug", "blue mug", "red rocket"])
    assert mug @ same == pytest.approx(1)
    assert mug @ sky < 0.9
