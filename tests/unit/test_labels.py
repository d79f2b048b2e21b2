"""Label sets and naming instances."""

import numpy as np
import pytest

from sceneq_core.routing.labels import Labeller, LabelSet, custom, named

from support.furnished import WordEncoder


def test_scannet200_has_the_benchmarks_labels():
    full = named("scannet200")
    assert len(full) == 200
    assert {"wall", "coffee table", "trash can", "mattress"} <= set(full.labels)
    parts = [len(named(f"scannet200-{part}")) for part in ("head", "common", "tail")]
    assert parts == [66, 68, 66]


def test_an_unknown_set_names_the_known_ones():
    with pytest.raises(ValueError, match="unknown 'coco', known: scannet200"):
        named("coco")


@pytest.mark.parametrize(
    ("labels", "message"),
    [
        ((), "0 given"),
        (("cup", "cup"), "'cup' is given twice"),
        (("cup", " "), "is empty"),
        (("x" * 65,), "over 64 chars"),
    ],
)
def test_bad_label_sets_are_refused(labels, message):
    with pytest.raises(ValueError, match=message):
        LabelSet("mine", labels)


def test_custom_labels_are_stripped():
    assert custom([" robot arm ", "gripper"]).labels == ("robot arm", "gripper")


def test_an_instance_gets_the_label_of_its_words():
    encoder = WordEncoder()
    labeller = Labeller(custom(["cup", "chair", "lamp"]), encoder)
    (best, second) = labeller.best_of_scores(
        labeller.scores(encoder.encode_texts(["chair"]))[0], k=2
    )
    assert best.name == "chair"
    assert best.cosine == pytest.approx(1.0)
    assert best.p > 0.99
    assert second.p < 0.01


def test_probabilities_add_up_to_one():
    encoder = WordEncoder()
    labeller = Labeller(named("scannet200"), encoder)
    descriptor = np.full(encoder.dim, encoder.dim**-0.5, np.float32)
    labels = labeller.best_of_scores(labeller.scores(descriptor[None])[0], k=200)
    assert sum(label.p for label in labels) == pytest.approx(1.0)
    assert [label.p for label in labels] == sorted((label.p for label in labels), reverse=True)
