"""What routing takes from the encoding node, and what cannot be its encoder's."""

import numpy as np
import pytest

from sceneq_core.encoding.looks import Looks, learn_looks
from sceneq_core.routing.labels import Labeller, named
from sceneq_core.routing.router import Router, RouterParams
from sceneq_core.teaching.album import Album
from sceneq_nodes._space import Space

from support.furnished import WordEncoder

TAUGHT = np.eye(6, dtype=np.float32)


class Remembers(WordEncoder):
    """An encoder that was taught with six things."""

    looks: Looks = learn_looks(TAUGHT)

    def familiarity(self, feature: np.ndarray) -> float:
        return self.looks.familiarity(feature)


def space_of(encoder: WordEncoder) -> Space:
    router = Router(RouterParams(), encoder, Labeller(named("scannet200"), encoder))
    return Space(encoder, router, None, Album("words", None))


DESCRIPTOR = WordEncoder().encode_texts(["lamp"])[0]


def test_it_says_how_familiar_a_feature_looks():
    assert space_of(Remembers()).familiarity(DESCRIPTOR, TAUGHT[2]) == pytest.approx(1.0, abs=1e-5)
    mixed = (TAUGHT[0] + TAUGHT[1]) / np.float32(np.sqrt(2))
    assert 0.5 < space_of(Remembers()).familiarity(DESCRIPTOR, mixed) < 0.9
    assert space_of(WordEncoder()).familiarity(DESCRIPTOR, mixed) == 1.0


@pytest.mark.parametrize(
    ("descriptor", "feature"),
    [
        (DESCRIPTOR[:-1], TAUGHT[0]),
        (np.full_like(DESCRIPTOR, np.nan), TAUGHT[0]),
        (DESCRIPTOR, TAUGHT[0][:5]),
        (DESCRIPTOR, np.full_like(TAUGHT[0], np.inf)),
    ],
    ids=["short descriptor", "descriptor not finite", "short feature", "feature not finite"],
)
def test_vectors_that_cannot_be_the_encoders_are_no_look(descriptor, feature):
    assert space_of(Remembers()).familiarity(descriptor, feature) is None
