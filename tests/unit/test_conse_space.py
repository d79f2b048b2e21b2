"""The joint space, with towers made of numbers."""

import numpy as np
import pytest

from sceneq_core.encoding.colour import COLOUR_TERMS
from sceneq_core.encoding.conse import Conse, classifier_input
from sceneq_core.encoding.dead_leaves import dead_leaves
from sceneq_core.encoding.joint import CLASSES, dimensions, image_vector, text_vector
from sceneq_core.encoding.lessons import Lessons
from sceneq_core.encoding.prior import indoor_prior
from sceneq_core.encoding.probe import Probe
from sceneq_core.encoding.usual_sizes import UsualSizes

MUG, CHAIR = 504, 559
NO_PRIOR = np.zeros(CLASSES, np.float32)
NO_COLOUR = np.zeros(11, np.float32)
NO_WORDS = np.zeros(CLASSES, np.float32)
NO_PROBE = np.zeros(0, np.float32)
DIM = dimensions(0)


def peak(index, height=10.0):
    vector = np.zeros(CLASSES, np.float32)
    vector[index] = height
    return vector


def colour(term):
    return np.eye(11, dtype=np.float32)[COLOUR_TERMS.index(term)]


def red_mug():
    return image_vector(peak(MUG), NO_PRIOR, NO_PROBE, colour("red"))


def test_the_right_class_wins():
    mug, chair = (text_vector(peak(i, 1.0), NO_COLOUR) for i in (MUG, CHAIR))
    assert red_mug() @ mug > 0.9
    assert abs(red_mug() @ chair) < 0.01


def test_a_colour_counts_beside_the_class_and_alone():
    red, blue = (text_vector(peak(MUG, 1.0), colour(c)) for c in ("red", "blue"))
    assert red_mug() @ red > red_mug() @ blue + 0.1
    assert red_mug() @ text_vector(NO_WORDS, colour("red")) == pytest.approx(0.2, abs=0.01)
    assert red_mug() @ text_vector(NO_WORDS, colour("blue")) == pytest.approx(0, abs=1e-6)


def test_without_colour_words_the_colour_part_is_zero():
    assert not text_vector(peak(MUG, 1.0), NO_COLOUR)[CLASSES + 1 :].any()


def test_a_text_no_class_can_say_is_far_from_every_image():
    vague = text_vector(np.full(CLASSES, 0.3, np.float32), NO_COLOUR)
    assert vague[CLASSES] > 0.9
    assert abs(red_mug() @ vague) < 0.05
    assert text_vector(NO_WORDS, NO_COLOUR)[CLASSES] == 1.0


def test_what_every_crop_shows_says_nothing():
    prior = peak(CHAIR, 5.0)
    vector = image_vector(peak(CHAIR, 5.0) + peak(MUG), prior, NO_PROBE, colour("red"))
    assert vector @ text_vector(peak(CHAIR, 1.0), NO_COLOUR) < 0.05


def test_equal_logits_leave_the_colour_only():
    vector = image_vector(NO_PRIOR, NO_PRIOR, NO_PROBE, colour("red"))
    assert vector @ text_vector(NO_WORDS, colour("red")) == pytest.approx(1)


def test_the_prior_is_a_thousand_centred_numbers():
    prior = indoor_prior()
    assert prior.shape == (CLASSES,)
    assert abs(float(prior.mean())) < 1e-3
    assert np.isfinite(prior).all()


def test_the_classifier_sees_the_whole_crop_scaled():
    rgb = np.full((10, 20, 3), 255, np.uint8)
    rgb[:, 10:] = 127
    image = classifier_input(rgb, 260)
    assert image.shape == (1, 3, 260, 260)
    assert image.dtype == np.float32
    assert image[0, :, 130, 20] == pytest.approx(1.0)
    assert image[0, :, 130, 240] == pytest.approx(0.0)


NO_LESSONS = Lessons(
    Probe((), np.zeros((1280, 0), np.float32), np.zeros(0, np.float32)),
    UsualSizes(np.zeros((0, 4)), np.zeros((0, 4))),
    np.zeros((0, CLASSES), np.float32),
    np.zeros(0, np.int64),
)


def test_texts_are_embedded_once():
    asked = []

    def embed(text):
        asked.append(text)
        return peak(MUG, 1.0)

    conse = Conse(
        classify=lambda image: (peak(MUG), np.ones(1280, np.float32)),
        embed=embed,
        class_vectors=lambda: np.eye(CLASSES, dtype=np.float32),
        prior=NO_PRIOR,
        lessons=NO_LESSONS,
        side_px=260,
        text_cache=8,
    )
    first = conse.encode_texts(["red mug", "mug", "red mug", "red"])
    assert first.shape == (4, DIM)
    assert np.array_equal(conse.encode_texts(["mug"])[0], first[1])
    assert asked == ["mug", "mug"]
    assert conse.encode_texts([]).shape == (0, DIM)


def test_calibration_images_are_the_same_every_time():
    assert np.array_equal(dead_leaves(3, 64), dead_leaves(3, 64))
    assert not np.array_equal(dead_leaves(3, 64), dead_leaves(4, 64))
    assert dead_leaves(3, 64).std() > 20
