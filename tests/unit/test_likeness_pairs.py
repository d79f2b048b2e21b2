"""Pairs of things in a recording with truth, and the logistics that are fitted to them."""

import json
import shutil

import numpy as np
import pytest

from sceneq_core.teaching.logistic import Logistic
from sceneq_nodes._likeness_file import judgement_of
from sceneq_tools.evaluation.likeness import Pairs, RoomPairs, pairs_in
from sceneq_tools.evaluation.likeness_fit import document, fit_likeness, score

from support.questioned import hash_setup, write_questioned


@pytest.fixture(scope="module")
def room(tmp_path_factory):
    folder = write_questioned(tmp_path_factory.mktemp("room"), frames=8)
    for path in folder.glob("frame-*.instance.png"):
        shutil.copyfile(path, path.with_name(path.name.replace("instance", "mask")))
    return folder


def test_a_recording_tells_what_is_alike_and_what_is_the_same_again(room):
    found = pairs_in(room, hash_setup())
    things = round(np.sqrt(len(found.alike.same)) + 0.5)
    assert len(found.alike.same) == things * (things - 1)
    assert found.alike.same.sum() == 4  # two balls and two boxes, each way round
    assert found.again.same.sum() >= 2
    overlap, cosine = found.again.measures.T
    assert overlap[found.again.same].min() > overlap[~found.again.same].max()
    assert (np.abs(cosine) <= 1.0 + 1e-6).all()
    assert len(found.sha256) == 64


def pairs(seed, count=4000):
    rng = np.random.default_rng(seed)
    cosine, overlap = rng.uniform(0.5, 1.0, count), rng.uniform(0.0, 1.0, count)
    alike = rng.random(count) < Logistic((30.0,), -25.0).p(cosine[:, None])
    both = np.column_stack([overlap, cosine])
    again = rng.random(count) < Logistic((20.0, 10.0), -15.0).p(both)
    return RoomPairs(f"room{seed}", "0" * 64, Pairs(cosine[:, None], alike), Pairs(both, again))


def test_what_is_fitted_is_read_back_by_the_routing_node(tmp_path):
    fit = fit_likeness([pairs(1), pairs(2)], [pairs(3)])
    assert fit.logistics["alike"].weights[0] == pytest.approx(30.0, rel=0.15)
    assert fit.logistics["again"].weights == pytest.approx((20.0, 10.0), rel=0.15)
    assert fit.tested["alike"].ece < 0.03
    path = tmp_path / "likeness.json"
    path.write_text(json.dumps(document(fit, "words*", [pairs(1), pairs(2)])))
    judgement = judgement_of("words-v2", str(path))
    assert judgement.alike.weights[0] == pytest.approx(fit.logistics["alike"].weights[0], abs=1e-3)
    assert judgement.place.weights[0] == pytest.approx(fit.logistics["place"].weights[0], abs=1e-3)


def test_scores_count_what_passes():
    measured = Pairs(np.array([[0.0], [1.0], [1.0]]), np.array([False, True, False]))
    one = score(Logistic((20.0,), -10.0), measured)
    assert (one.pairs, one.same, one.passed, one.right) == (3, 1, 2, 1)
    assert one.log_loss == pytest.approx(10.0 / 3, rel=1e-3)
    assert one.as_dict()["passed"] == 2


def test_rooms_without_two_alike_things_teach_nothing():
    lonely = RoomPairs("r", "0" * 64, Pairs.of([], 1), Pairs.of([], 2))
    with pytest.raises(ValueError, match="0 of 0 are the same"):
        fit_likeness([lonely], [])
