"""The linear probe: what it says, how it is taught, and its file."""

from dataclasses import replace

import numpy as np
import pytest

from sceneq_core.encoding.colour import COLOUR_TERMS
from sceneq_core.encoding.joint import CLASSES, dimensions, image_vector, text_vector
from sceneq_core.encoding.lessons import Lessons
from sceneq_core.encoding.probe import Probe
from sceneq_core.encoding.probe_training import ProbeTrainingParams, train_probe
from sceneq_core.encoding.usual_sizes import UsualSizes
from sceneq_nodes._probe_file import HOUSEHOLD, read_probe, write_probe
from sceneq_tools.probe_examples import as_arrays, examples

from support.questioned import hash_setup, write_questioned

NAMES = ("cup", "desk", "lamp")


def probe(bias=(0.0, 0.0, 0.0)):
    return Probe(NAMES, np.eye(4, 3, dtype=np.float32), np.array(bias, np.float32))


def clusters(count=40, seed=3):
    rng = np.random.default_rng(seed)
    centre = rng.normal(size=(3, 16))
    which = np.arange(count) % 3
    features = centre[which] + 0.3 * rng.normal(size=(count, 16))
    return features.astype(np.float32), [NAMES[i] for i in which]


def test_its_probabilities_are_a_softmax_of_the_unit_feature():
    said = probe().probabilities(np.array([0.0, 3.0, 0.0, 4.0], np.float32))
    raw = np.exp(np.array([0.0, 0.6, 0.0]))
    assert said == pytest.approx(raw / raw.sum(), abs=1e-6)


def test_a_probe_without_names_says_nothing():
    empty = Probe((), np.zeros((4, 0), np.float32), np.zeros(0, np.float32))
    assert empty.probabilities(np.ones(4, np.float32)).shape == (0,)


def test_parts_that_do_not_fit_are_refused():
    with pytest.raises(ValueError, match="3 names do not fit"):
        Probe(NAMES, np.zeros((4, 2), np.float32), np.zeros(3, np.float32))
    with pytest.raises(ValueError, match="not finite"):
        probe(bias=(np.nan, 0.0, 0.0))


def test_it_learns_to_tell_clusters_apart():
    taught = train_probe(*clusters())
    fresh, names = clusters(30, seed=3)
    said = [taught.names[int(taught.probabilities(f).argmax())] for f in fresh]
    assert taught.names == NAMES
    assert said == names


def test_the_same_lesson_gives_the_same_probe_and_leaves_no_trace():
    import torch

    torch.manual_seed(11)
    wanted = torch.rand(1).item()
    torch.manual_seed(11)
    first = train_probe(*clusters(), ProbeTrainingParams(rounds=3))
    assert torch.rand(1).item() == wanted
    second = train_probe(*clusters(), ProbeTrainingParams(rounds=3))
    assert np.array_equal(first.weights, second.weights)
    assert np.array_equal(first.bias, second.bias)


def test_one_kind_of_thing_teaches_nothing():
    with pytest.raises(ValueError, match="1 kinds"):
        train_probe(np.ones((2, 4), np.float32), ["cup", "cup"])


def test_a_name_of_the_probe_finds_its_crop():
    shares = np.zeros(len(COLOUR_TERMS), np.float32)
    logits, probed = np.zeros(CLASSES, np.float32), np.array([0.9, 0.05, 0.05], np.float32)
    crop = image_vector(logits, logits, probed, shares)
    similarity = np.zeros((2, CLASSES + 3), np.float32)
    similarity[0, CLASSES], similarity[1, CLASSES + 1] = 1.0, 1.0
    cup, desk = (text_vector(row, shares) for row in similarity)
    assert crop.shape == cup.shape == (dimensions(3),)
    assert crop @ cup > 0.9 > 0.3 > crop @ desk


def lessons(text_vectors=None):
    sizes = UsualSizes(np.zeros((3, 4)), np.array([[1.0] * 4, [2.0] * 4, [np.inf] * 4]))
    vectors = np.eye(4, 384, dtype=np.float32) if text_vectors is None else text_vectors
    return Lessons(probe((0.5, 0.0, -0.5)), sizes, vectors, np.array([0, 1, 2, 0]))


TEXTS = ("cup", "desk", "lamp", "mug")


def test_a_file_comes_back_as_it_was_written(tmp_path):
    path = tmp_path / "probe.npz"
    write_probe(path, lessons(), TEXTS, "0123")
    back = read_probe(path)
    assert (back.lessons.probe.names, back.taught_with) == (NAMES, "0123")
    assert np.array_equal(back.lessons.probe.weights, np.eye(4, 3))
    assert np.array_equal(back.lessons.sizes.spread, lessons().sizes.spread)
    assert np.array_equal(back.lessons.text_vectors, np.eye(4, 384))
    assert back.lessons.text_of.tolist() == [0, 1, 2, 0]
    first = path.read_bytes()
    write_probe(path, lessons(), TEXTS, "0123")
    assert path.read_bytes() == first


def test_a_name_is_as_close_to_words_as_the_closest_of_its_texts():
    mug = np.eye(384, dtype=np.float32)[3]
    assert lessons().similarity(mug).tolist() == [1.0, 0.0, 0.0]


def test_lessons_that_do_not_fit_are_refused():
    with pytest.raises(ValueError, match="not every one of 3 names has a text"):
        replace(lessons(), text_of=np.array([0, 1, 1, 0]))
    with pytest.raises(ValueError, match="text_of: 3 rows for 4 texts"):
        replace(lessons(), text_of=np.array([0, 1, 2]))
    with pytest.raises(ValueError, match="sizes: of 2 names, the probe has 3"):
        replace(lessons(), sizes=UsualSizes(np.zeros((2, 4)), np.ones((2, 4))))


def test_what_is_no_probe_is_named(tmp_path):
    with pytest.raises(ValueError, match=r"gone\.npz: No such file"):
        read_probe(tmp_path / "gone.npz")
    bad = tmp_path / "bad.npz"
    bad.write_bytes(b"nothing of the kind")
    with pytest.raises(ValueError, match=r"bad\.npz: no probe file"):
        read_probe(bad)
    write_probe(bad, lessons(np.zeros((4, 7), np.float32)), TEXTS, "")
    with pytest.raises(ValueError, match=r"text_vectors: expected rows of 384, got \(4, 7\)"):
        read_probe(bad)


def test_the_household_probe_comes_with_the_program():
    household = read_probe(HOUSEHOLD).lessons
    assert {"coffee mug", "sofa", "chandelier", "air conditioner"} <= set(household.probe.names)
    assert len(household.probe) > 250
    assert np.linalg.norm(household.text_vectors, axis=1) == pytest.approx(1, abs=1e-2)
    assert HOUSEHOLD.stat().st_size < 3e6
    of = dict(zip(household.probe.names, np.exp(household.sizes.mean[:, 0]), strict=True))
    assert of["sofa"] > of["armchair"] > of["coffee mug"]


def test_examples_are_the_crops_of_true_things_with_their_names(tmp_path):
    setup, advanced = hash_setup(), []
    found = list(examples(write_questioned(tmp_path), setup, lambda n=1: advanced.append(n)))
    names, features = as_arrays(found)
    assert {"ball", "box", "table"} <= set(names)
    assert "floor" not in names
    assert len(features) == len(names) == setup.describe.levels * len(found)
    assert len(advanced) >= 3
