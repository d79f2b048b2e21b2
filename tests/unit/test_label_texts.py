"""Vectors of fixed texts on disk: the same vectors, without the encoder."""

import numpy as np
import pytest

from sceneq_nodes._known_texts import KnownTexts

from support.furnished import WordEncoder


class CountingEncoder(WordEncoder):
    def __init__(self) -> None:
        super().__init__()
        self.encoded: list[str] = []

    def encode_texts(self, texts):
        self.encoded += texts
        return super().encode_texts(texts)


@pytest.fixture(autouse=True)
def cache(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return tmp_path / "sceneq"


TEXTS = ("cup", "chair", "cup")


def test_a_second_start_encodes_nothing():
    first, second = CountingEncoder(), CountingEncoder()
    vectors = KnownTexts(first, TEXTS).encode_texts(TEXTS)
    again = KnownTexts(second, TEXTS).encode_texts(TEXTS)
    assert first.encoded == ["cup", "chair"]
    assert second.encoded == []
    assert np.array_equal(vectors, again)
    assert np.array_equal(vectors, WordEncoder().encode_texts(TEXTS))


def test_other_texts_go_to_the_encoder():
    encoder = CountingEncoder()
    known = KnownTexts(encoder, TEXTS)
    vectors = known.encode_texts(["lamp", "cup", "lamp"])
    assert encoder.encoded == ["cup", "chair", "lamp"]
    assert np.array_equal(vectors, WordEncoder().encode_texts(["lamp", "cup", "lamp"]))
    assert known.encode_texts([]).shape == (0, known.dim)


def test_other_labels_have_another_file(cache):
    KnownTexts(CountingEncoder(), ("cup",))
    KnownTexts(CountingEncoder(), ("lamp",))
    assert len(list(cache.iterdir())) == 2


@pytest.mark.parametrize("damage", [b"", b"garbage", b"\x93NUMPY\x01\x00"])
def test_a_damaged_file_is_made_anew(cache, damage):
    KnownTexts(CountingEncoder(), TEXTS)
    (path,) = cache.iterdir()
    path.write_bytes(damage)
    encoder = CountingEncoder()
    vectors = KnownTexts(encoder, TEXTS).encode_texts(["chair"])
    assert encoder.encoded == ["cup", "chair"]
    assert np.array_equal(vectors, WordEncoder().encode_texts(["chair"]))


def test_a_cache_that_cannot_be_written_is_no_error(monkeypatch, tmp_path):
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    assert len(KnownTexts(CountingEncoder(), TEXTS).encode_texts(TEXTS)) == 3
