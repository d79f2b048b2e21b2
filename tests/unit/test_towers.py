"""Batches, unit length, remembered texts, and towers that misbehave."""

import numpy as np
import pytest

from sceneq_core.encoding.encoder import Crop
from sceneq_core.encoding.towers import TextCache, Towers

CROPS = [Crop(np.full((2, 3, 3), n, np.uint8), np.ones((2, 3), bool)) for n in range(1, 6)]


class Recorder:
    """Two towers of 3 dimensions that remember what they were asked."""

    def __init__(self, dim=3):
        self.seen, self.read_texts, self.dim = [], [], dim

    def see(self, inputs):
        self.seen.append(inputs)
        rows = np.array([[value, 1.0, 0.0][: self.dim] for value in inputs], np.float32)
        return rows, 2 * rows

    def read(self, texts):
        self.read_texts.append(texts)
        return np.array([[len(text), 2.0, 0.0][: self.dim] for text in texts], np.float32)


def towers(recorder, batch=2, text_cache=8):
    prepare = lambda rgb: int(rgb[0, 0, 0])  # noqa: E731
    return Towers(prepare, recorder.see, recorder.read, dim=3, batch=batch, text_cache=text_cache)


def test_crops_go_in_batches_and_come_out_as_units_beside_raw_features():
    recorder = Recorder()
    descriptors, features = towers(recorder).encode_crops(CROPS)
    assert recorder.seen == [[1, 2], [3, 4], [5]]
    assert descriptors[2] == pytest.approx(np.array([3, 1, 0]) / np.sqrt(10))
    assert features[2].tolist() == [6, 2, 0]


def test_each_text_is_read_once_and_remembered():
    recorder = Recorder()
    encode = towers(recorder).encode_texts
    first = encode(["mug", "chair", "mug", "a"])
    assert recorder.read_texts == [["mug", "chair"], ["a"]]
    assert np.array_equal(first[0], first[2])
    again = encode(["a", "sofa"])
    assert recorder.read_texts[2:] == [["sofa"]]
    assert np.array_equal(again[0], first[3])


def test_more_texts_than_the_cache_holds_are_answered_all_the_same():
    recorder = Recorder()
    assert towers(recorder, text_cache=2).encode_texts(["a", "bb", "ccc", "dddd"]).shape == (4, 3)


def test_the_texts_not_asked_for_longest_make_room():
    cache = TextCache(2)
    cache.keep({"a": np.ones(1), "b": np.ones(1)})
    cache.known(["a"])
    cache.keep({"c": np.ones(1)})
    assert set(cache.known(["a", "b", "c"])) == {"a", "c"}


def test_another_dimension_is_refused():
    with pytest.raises(ValueError, match=r"image tower: expected \(N, 3\), got \(5, 2\)"):
        towers(Recorder(dim=2)).encode_crops(CROPS)


def test_numbers_that_are_not_finite_are_refused():
    recorder = Recorder()
    recorder.read = lambda texts: np.full((len(texts), 3), np.inf, np.float32)
    with pytest.raises(ValueError, match="text tower gives numbers that are not finite"):
        towers(recorder).encode_texts(["a"])


def test_a_vector_of_zeros_stays_one():
    recorder = Recorder()
    recorder.read = lambda texts: np.zeros((len(texts), 3), np.float32)
    assert towers(recorder).encode_texts(["a"]).tolist() == [[0, 0, 0]]


def test_texts_are_read_within_the_prompt_and_remembered_without_it():
    recorder = Recorder()
    one = Towers(
        *(lambda rgb: 0, recorder.see, recorder.read),
        dim=3,
        batch=2,
        text_cache=8,
        prompt="a photo of a {}.",
    )
    one.encode_texts(["mug"])
    one.encode_texts(["mug"])
    assert recorder.read_texts == [["a photo of a mug."]]
