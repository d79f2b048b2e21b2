"""Questions and texts are read once; what is known waits for nobody."""

import threading

import numpy as np
import pytest

from sceneq_core.encoding.hash import HashEncoder, HashParams
from sceneq_core.routing.labels import Labeller, custom
from sceneq_core.routing.question import Reader, TextTower


class Counted:
    """The hash encoder, with a list of what it read and a way to make it wait."""

    def __init__(self):
        plain = HashEncoder(HashParams())
        self.model_id, self.dim = plain.model_id, plain.dim
        self.temperature, self.ceiling = plain.temperature, plain.ceiling
        self._plain = plain
        self.read: list[str] = []
        self.may_go = threading.Event()
        self.may_go.set()
        self.begun = threading.Event()

    def encode_crops(self, crops):
        return self._plain.encode_crops(crops)

    def encode_texts(self, texts):
        self.begun.set()
        assert self.may_go.wait(10)
        self.read += texts
        return self._plain.encode_texts(texts)


@pytest.fixture
def encoder():
    return Counted()


@pytest.fixture
def reader(encoder):
    labels = custom(["table", "coffee table", "cup", "lamp"])
    return Reader(TextTower(encoder), Labeller(labels, encoder), synonym_cosine=0.99)


def test_a_question_is_read_once(encoder, reader):
    first = reader.read("the cup on the coffee table")
    count = len(encoder.read)
    assert reader.read("the cup on the coffee table") is first
    assert reader.read("a lamp on the coffee table").phrase.target == "lamp"
    assert encoder.read[count:] == ["lamp"]


def test_what_is_no_question_is_refused_each_time(reader):
    for _ in range(2):
        with pytest.raises(ValueError, match="no words"):
            reader.read("?")


def test_labels_that_end_the_words_are_no_rivals(reader):
    wanted = reader.read("round coffee table").wanted["round coffee table"]
    assert wanted.rivals.tolist() == [False, False, True, True]
    assert reader.read("cup").wanted["cup"].rivals.tolist() == [True, True, False, True]


def test_known_texts_do_not_wait_for_new_ones_of_others(encoder):
    tower = TextTower(encoder)
    known = tower.encode(["cup"])
    encoder.may_go.clear()
    encoder.begun.clear()
    other = threading.Thread(target=tower.encode, args=(["lamp"],))
    other.start()
    assert encoder.begun.wait(10)
    again = tower.encode(["cup", "cup"])
    encoder.may_go.set()
    other.join(10)
    assert np.array_equal(again, np.concatenate([known, known]))
    assert encoder.read == ["cup", "lamp"]


def test_the_texts_not_asked_for_longest_are_forgotten(encoder):
    tower = TextTower(encoder, capacity=2)
    for text in ("cup", "lamp", "cup", "table", "cup", "lamp"):
        tower.encode([text])
    assert encoder.read == ["cup", "lamp", "table", "lamp"]
