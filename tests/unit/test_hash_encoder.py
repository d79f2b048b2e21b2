"""The encoder without weights knows colours."""

import numpy as np

from sceneq_core.encoding.encoder import Crop
from sceneq_core.encoding.hash import HashEncoder, HashParams

ENCODER = HashEncoder(HashParams())


def crop(rgb):
    return Crop(np.full((6, 6, 3), rgb, np.uint8), np.ones((6, 6), bool))


def test_colour_words_find_crops_of_that_colour():
    crops = ENCODER.encode_crops([crop((205, 25, 35)), crop((40, 140, 60)), crop((30, 85, 190))])[0]
    texts = ENCODER.encode_texts(["red", "green", "blue"])
    assert (crops @ texts.T).argmax(axis=1).tolist() == [0, 1, 2]
    assert (crops * texts).sum(axis=1).min() > 0.9


def test_a_colour_keeps_half_a_say_beside_a_noun():
    red = ENCODER.encode_crops([crop((205, 25, 35))])[0][0]
    with_noun, noun, other = ENCODER.encode_texts(["red mug", "mug", "chair"])
    assert 0.6 < red @ with_noun < 0.8
    assert red @ noun == 0
    assert abs(noun @ other) < 0.01
