"""The linear probe: what it says, how it is taught, and its file."""

import json
from dataclasses import replace

import numpy as np
import pytest

from sceneq_core.encoding.colour import COLOUR_TERMS
from sceneq_core.encoding.joint import CLASSES, dimensions, image_vector, text_vector
from sceneq_core.encoding.lessons import Lessons
from sceneq_core.encoding.looks import learn_looks
from sceneq_core.encoding.probe import Probe
from sceneq_core.encoding.probe_training import ProbeTrainingParams, train_probe
from sceneq_core.encoding.usual_sizes import UsualSizes
from sceneq_nodes._probe_file import HOUSEHOLD, read_probe, write_probe
from sceneq_tools.probe_examples import (
    Example,
    as_arrays,
    as_things,
    digest,
    examples,
    quarter,
    without_quarter,
)
from sceneq_tools.probe_lessons import learn

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


def test_looks_and_what_was_withheld_come_back_and_may_be_missing(tmp_path):
    path = tmp_path / "probe.npz"
    write_probe(path, lessons(), TEXTS, "0123")
    assert (read_probe(path).lessons.looks, read_probe(path).withheld) == (None, ())
    features = np.eye(5, 8, dtype=np.float32)
    written = learn_looks(features)
    write_probe(path, replace(lessons(), looks=written), TEXTS, "0123", ["desk-7", "lamp-2"])
    back = read_probe(path)
    assert back.withheld == ("desk-7", "lamp-2")
    assert np.array_equal(back.lessons.looks.centre, written.centre)
    assert back.lessons.looks.axes == pytest.approx(written.axes, abs=1e-3)
    assert back.lessons.looks.things == pytest.approx(written.things, abs=1e-3)
    assert back.lessons.looks.familiarity(features[2]) == pytest.approx(1.0, abs=1e-2)


def test_a_file_older_than_looks_is_read(tmp_path):
    path, old = tmp_path / "probe.npz", tmp_path / "old.npz"
    write_probe(path, lessons(), TEXTS, "0123")
    with np.load(path) as arrays:
        np.savez(old, **{key: arrays[key] for key in arrays.files if key != "withheld"})
    assert (read_probe(old).lessons.looks, read_probe(old).withheld) == (None, ())


def test_looks_that_are_damaged_are_named(tmp_path):
    path, bad = tmp_path / "probe.npz", tmp_path / "bad.npz"
    looks = learn_looks(np.eye(5, 8, dtype=np.float32))
    write_probe(path, replace(lessons(), looks=looks), TEXTS, "0123")
    with np.load(path) as arrays:
        np.savez(bad, **{**arrays, "looks_centre": np.zeros(7, np.float32)})
    with pytest.raises(ValueError, match=r"bad\.npz: no probe file: .*axes: shape \(8, 4\)"):
        read_probe(bad)


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
    assert {one.thing.rpartition("/")[0] for one in found} == {str(tmp_path)}
    assert {one.model for one in found} == {""}


MODELS = {"cup": "cup-1", "desk": "desk-1", "lamp": "lamp-1"}
TEXTS_OF_NAMES = [("cup", "cup"), ("mug", "cup"), ("desk", "desk"), ("lamp", "lamp")]


def taught_examples(count=60):
    """Two things of every name, of one model, from many sides; and a cup of no model."""
    features, names = clusters(count)
    shape = np.zeros(4)
    return [
        Example((name,), rows, shape, MODELS[name] if i % 2 else "", f"room/{name}{i % 2}")
        for i, (name, rows) in enumerate(zip(names, features[:, None], strict=True))
    ]


def learned(found):
    return learn(found, TEXTS_OF_NAMES, lambda said: np.ones((len(said), 384), np.float32), 15)


def test_every_model_falls_into_one_of_four_quarters():
    models = [f"chair-{number}" for number in range(200)]
    found = [Example(("chair",), np.ones((1, 2)), np.zeros(4), one, one) for one in ["", *models]]
    withheld = [without_quarter(found, number)[1] for number in (1, 2, 3, 4)]
    assert sorted(one for part in withheld for one in part) == sorted(models)
    assert all(30 < len(part) < 70 and part == sorted(part) for part in withheld)
    assert {quarter(one) for one in withheld[2]} == {3}
    taught, left_out = without_quarter(found, 2)
    assert {one.model for one in taught} == {"", *models} - set(left_out)
    assert without_quarter(found, None) == (found, [])


def test_a_withheld_name_stays_and_is_never_meant():
    found = taught_examples()
    less = [one for one in found if one.names[0] != "desk"]
    whole, strange = learned(found), learned(less)
    assert whole.probe.names == strange.probe.names == NAMES
    assert strange.text_of.tolist() == whole.text_of.tolist() == [0, 0, 1, 2]
    said = np.stack([strange.probe.probabilities(one.features[0]) for one in found])
    assert said[:, 1].max() < 1e-9
    is_cup = np.array([one.names[0] == "cup" for one in less])
    of_less = np.stack([strange.probe.probabilities(one.features[0]) for one in less])
    assert (of_less.argmax(axis=1) == np.where(is_cup, 0, 2)).all()
    assert not strange.probe.weights[:, 1].any()
    assert strange.probe.bias[1] == pytest.approx(strange.probe.bias[[0, 2]].min() - 30)
    assert not strange.sizes.mean[1].any()
    assert np.isinf(strange.sizes.spread[1]).all()
    assert np.isfinite(strange.sizes.spread[[0, 2]]).all()
    assert digest(less) != digest(found)


def test_looks_are_of_things_not_of_views():
    found = taught_examples()
    things = list(dict.fromkeys(one.thing for one in found))
    assert len(learned(found).looks.things) == len(things) == 6
    means = [
        np.mean([one.features.mean(axis=0) for one in found if one.thing == thing], axis=0)
        for thing in things
    ]
    features = as_things(found)
    assert features == pytest.approx(np.stack([m / np.linalg.norm(m) for m in means]), abs=1e-6)
    looks = learned(found[::-1]).looks
    assert looks.familiarity(features[0]) == pytest.approx(1.0, abs=1e-5)
    without_desks = learned([one for one in found if one.names[0] != "desk"]).looks
    desk = next(i for i, thing in enumerate(things) if thing.startswith("room/desk"))
    assert without_desks.familiarity(features[desk]) < 0.9


def test_a_recording_may_tell_the_model_of_a_thing(tmp_path):
    path = write_questioned(tmp_path) / "instances.json"
    document = json.loads(path.read_text())
    for record in document["instances"]:
        record["model"] = "Test#table" if record["name"] == "table" else None
    path.write_text(json.dumps(document))
    found = list(examples(tmp_path, hash_setup(), lambda n=1: None))
    assert {(one.names[0], one.model) for one in found} >= {("table", "Test#table"), ("ball", "")}
    table = {one.thing for one in found if one.names[0] == "table"}
    assert table == {f"{tmp_path}/3"}
