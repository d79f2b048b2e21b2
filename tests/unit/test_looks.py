"""How familiar a picture looks to an encoder that remembers what it was taught with."""

import numpy as np
import pytest

from sceneq_core.encoding.looks import FAMILIAR, Looks, familiarity, learn_looks

from support.furnished import WordEncoder

RNG = np.random.default_rng(3)


def unit(rows: np.ndarray) -> np.ndarray:
    return (rows / np.linalg.norm(rows, axis=-1, keepdims=True)).astype(np.float32)


TAUGHT = unit(np.abs(RNG.normal(size=(12, 20))))


def test_what_was_taught_is_as_familiar_as_can_be():
    looks = learn_looks(TAUGHT)
    assert [looks.familiarity(one) for one in TAUGHT] == pytest.approx([1.0] * 12, abs=1e-5)


def test_what_is_like_something_taught_is_more_familiar_than_what_is_like_nothing():
    looks = learn_looks(TAUGHT)
    near = unit(TAUGHT[4] + np.float32(0.02) * RNG.normal(size=20))
    far = unit(np.abs(RNG.normal(size=20)))
    assert looks.familiarity(near) > 0.9 > 0.7 > looks.familiarity(far)


def test_familiarity_is_the_cosine_with_the_nearest_thing_seen_from_the_middle():
    looks = learn_looks(TAUGHT)
    one = unit(np.abs(RNG.normal(size=20)))
    middle = TAUGHT.mean(axis=0)
    span = np.linalg.svd(TAUGHT - middle, full_matrices=False)[2][:11]  # what twelve things span
    seen, things = unit((one - middle) @ span.T), unit((TAUGHT - middle) @ span.T)
    assert looks.familiarity(one) == pytest.approx(float((things @ seen).max()), abs=1e-4)


def test_only_so_many_axes_are_kept():
    looks = learn_looks(TAUGHT, axes=5)
    assert (looks.axes.shape, looks.things.shape) == ((20, 5), (12, 5))
    assert looks.things.dtype == looks.axes.dtype == looks.centre.dtype == np.float32
    assert np.linalg.norm(looks.things, axis=1) == pytest.approx(np.ones(12), abs=1e-6)


def test_an_encoder_that_does_not_tell_finds_nothing_strange():
    assert familiarity(WordEncoder(), TAUGHT[0]) == FAMILIAR == 1.0


def test_what_cannot_be_is_refused():
    looks = learn_looks(TAUGHT)
    with pytest.raises(ValueError, match=r"feature: shape \(19,\), expected \(20,\)"):
        looks.familiarity(TAUGHT[0][:19])
    with pytest.raises(ValueError, match="of 1 things, two at least"):
        learn_looks(TAUGHT[:1])
    with pytest.raises(ValueError, match="axes: shape"):
        Looks(looks.centre[:5], looks.axes, looks.things)
    with pytest.raises(ValueError, match="things: shape"):
        Looks(looks.centre, looks.axes, looks.things[:, :3])
