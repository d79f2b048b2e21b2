"""Teaching without some of the furniture: which, what is left of the names, and what looks how."""

import hashlib

import numpy as np
import pytest

from sceneq_core.encoding.joint import unit
from sceneq_nodes._probe_file import read_probe, write_probe
from sceneq_tools.probe_examples import QUARTERS, Example, as_things, quarter, without_quarter
from sceneq_tools.probe_lessons import learn, meanings

SHAPE = np.array([0.0, -0.5, -0.2, 0.1])
MODELS = {"cup": "Test#cup", "desk": "Test#desk", "lamp": "Test#lamp", "plant": ""}


def seen(name: str, thing: str, *views: list[list[float]]) -> list[Example]:
    """One example a view, each with its levels."""
    model = MODELS[name]
    return [Example((name,), np.array(v, np.float32), SHAPE, model, thing) for v in views]


CORNERS = np.eye(4, dtype=np.float32)
FOUND = [
    example
    for number, name in enumerate(MODELS)
    for copy in range(2)
    for example in seen(name, f"{name} {copy}", [CORNERS[number].tolist()] * 2)
]


def embed(texts: list[str]) -> np.ndarray:
    return np.eye(len(texts), 384, dtype=np.float32)


def test_a_model_is_always_of_the_same_quarter():
    for model in MODELS.values():
        digest = hashlib.md5(model.encode(), usedforsecurity=False).hexdigest()
        assert quarter(model) == int(digest, 16) % 4 + 1
    many = [quarter(f"model {number}") for number in range(400)]
    assert min(many.count(k) for k in range(1, QUARTERS + 1)) > 70
    assert set(many) == {1, 2, 3, 4}


def test_a_quarter_of_the_models_is_left_out_and_what_has_none_stays():
    assert without_quarter(FOUND, None) == (FOUND, [])
    left_out = []
    for number in range(1, QUARTERS + 1):
        taught, withheld = without_quarter(FOUND, number)
        assert withheld == sorted(m for m in set(MODELS.values()) if m and quarter(m) == number)
        assert [one for one in FOUND if one.model not in withheld] == taught
        assert sum(one.names == ("plant",) for one in taught) == 2
        left_out += withheld
    assert sorted(left_out) == sorted(model for model in MODELS.values() if model)


def test_a_thing_looks_like_the_mean_of_its_views_which_are_means_of_their_levels():
    found = [
        *seen("cup", "room/1", [[4, 0], [0, 4]], [[0, 2], [0, 2]]),
        *seen("desk", "room/2", [[3, 4]]),
        *seen("cup", "other/1", [[0, 1]]),
        *seen("cup", "room/1", [[1, 1]]),
    ]
    first = unit(np.array([2 + 0 + 1, 2 + 2 + 1], np.float32))  # three views count alike
    assert as_things(found) == pytest.approx(np.array([first, [0.6, 0.8], [0, 1]]), abs=1e-6)


def test_a_name_without_examples_keeps_its_place_and_is_never_meant(tmp_path):
    texts = meanings(FOUND)
    taught = [one for one in FOUND if one.names != ("desk",)]
    whole, less = (learn(some, texts, embed, rounds=5) for some in (FOUND, taught))
    assert less.probe.names == whole.probe.names == tuple(sorted(MODELS))
    assert less.probe.weights.shape == whole.probe.weights.shape
    assert np.array_equal(less.text_of, whole.text_of)
    at = less.probe.names.index("desk")
    assert not less.probe.weights[:, at].any()
    others = np.delete(less.probe.bias, at)
    assert less.probe.bias[at] == pytest.approx(others.min() - 30)
    for corner in CORNERS:
        said = less.probe.probabilities(corner)
        assert said[at] < 1e-12
        assert said.sum() == pytest.approx(1)
    assert np.isinf(less.sizes.spread[at]).all()
    assert less.sizes.evidence(SHAPE)[at] == 0
    assert np.isfinite(whole.sizes.spread).all()
    file = tmp_path / "probe.npz"
    write_probe(file, less, [text for text, _ in texts], "0123", ["Test#desk"])
    back = read_probe(file)
    assert back.withheld == ("Test#desk",)
    assert back.lessons.probe.probabilities(CORNERS[0])[at] < 1e-12


def test_only_what_teaches_looks_familiar():
    texts = meanings(FOUND)
    less = learn([one for one in FOUND if one.names != ("desk",)], texts, embed, rounds=1).looks
    whole = learn(FOUND, texts, embed, rounds=1).looks
    assert less is not None
    assert whole is not None
    assert (len(less.things), len(whole.things)) == (6, 8)
    desk, cup = CORNERS[1], CORNERS[0]
    assert whole.familiarity(desk) == pytest.approx(1, abs=1e-5)
    assert less.familiarity(cup) == pytest.approx(1, abs=1e-5)
    assert less.familiarity(desk) < 0.7


def test_one_thing_is_nothing_to_learn_from():
    with pytest.raises(ValueError, match="1 kinds"):
        learn(FOUND[:2], meanings(FOUND), embed, rounds=1)
