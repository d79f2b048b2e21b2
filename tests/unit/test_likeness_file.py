"""What ships with the program says who inherits names, for which encoder."""

import json

import numpy as np
import pytest

from sceneq_core.teaching.evidence import PLACE, Judgement
from sceneq_core.teaching.logistic import Logistic, fit_logistic
from sceneq_nodes._likeness_file import SHIPPED, judgement_of, logistic_json


def test_the_embedded_encoder_is_measured_whatever_its_probe():
    judgement = judgement_of("conse-lite2-minilm-v2-0123abcd")
    p = judgement.of_category(np.array([0.5, 0.82, 0.99]))
    assert p[0] < 0.01 < p[1] < 0.6 < p[2]
    same = judgement.of_same(np.array([0.0, 0.5, 0.5]), np.array([0.99, 0.9, 0.5]))
    assert max(same[0], same[2]) < 0.1 < 0.9 < same[1]


def test_what_ships_says_where_it_is_from():
    (entry,) = json.loads(SHIPPED.read_text())["encoders"].values()
    assert all(len(sha256) == 64 for sha256 in entry["recordings"].values())
    assert entry["tested"]["again"]["right"] <= entry["tested"]["again"]["passed"]


def test_an_encoder_that_was_not_measured_passes_nothing_on():
    judgement = judgement_of("other")
    assert judgement.of_category(np.array([1.0])).tolist() == [0.0]
    assert judgement.of_same(np.array([0.9]), np.array([0.1]))[0] == PLACE.p(np.array([[0.9]]))[0]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "not JSON"),
        ('{"format": "x"}', "format"),
        ('{"format": "sceneq.likeness.v1"}', "encoders"),
        ('{"format": "sceneq.likeness.v1", "encoders": {"*": {"alike": 1}}}', "subscriptable"),
        (
            '{"format":"sceneq.likeness.v1","encoders":{"*":{"alike":{"weights":[-1],"bias":0}}}}',
            "prefers what is less alike",
        ),
        (
            '{"format":"sceneq.likeness.v1","encoders":{"*":{"again":{"weights":[1],"bias":0}}}}',
            "again: expected 2 weights",
        ),
    ],
)
def test_a_file_that_cannot_be_used_is_named(tmp_path, text, message):
    path = tmp_path / "likeness.json"
    path.write_text(text)
    with pytest.raises(ValueError, match=r"likeness\.json: .*" + message):
        judgement_of("any", str(path))
    with pytest.raises(ValueError, match="cannot be read"):
        judgement_of("any", str(tmp_path / "none.json"))


def test_a_logistic_is_fitted_to_what_pairs_say():
    rng = np.random.default_rng(0)
    truth = Logistic((12.0,), -8.0)
    x = rng.random((20_000, 1))
    fitted = fit_logistic(x, rng.random(20_000) < truth.p(x))
    assert fitted.weights[0] == pytest.approx(12.0, rel=0.1)
    assert fitted.bias == pytest.approx(-8.0, rel=0.1)
    assert logistic_json(truth) == {"weights": [12.0], "bias": -8.0}


def test_pairs_that_can_be_told_apart_without_error_give_finite_weights():
    x = np.array([[0.0], [0.1], [0.9], [1.0]])
    fitted = fit_logistic(x, np.array([False, False, True, True]))
    assert np.isfinite(fitted.weights).all()
    assert (fitted.p(x) > 0.5).tolist() == [False, False, True, True]


def test_pairs_of_one_kind_teach_nothing():
    with pytest.raises(ValueError, match="3 of 3 are the same"):
        fit_logistic(np.zeros((3, 1)), np.ones(3, np.bool_))
    with pytest.raises(ValueError, match="not finite"):
        Logistic((np.nan,), 0.0)
    with pytest.raises(ValueError, match="alike: expected 1 weights"):
        Judgement(alike=Logistic((1.0, 2.0), 0.0))
