"""What looks alike, and which vanished thing a new one is."""

import numpy as np
import pytest

from sceneq_core.mapping.recognition import Appearance, Recognition, RecognitionParams
from sceneq_core.mapping.signature import likeness, signature_of

from support.furnished import UP, Thing, instance

RED, BLUE = (200, 30, 30), (40, 60, 190)


def box_of_voxels(size, rgb, turn_deg=0.0, seed=0):
    rng = np.random.default_rng(seed)
    points = rng.uniform(-0.5, 0.5, (600, 3)) * size
    c, s = np.cos(np.deg2rad(turn_deg)), np.sin(np.deg2rad(turn_deg))
    turned = points @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    colours = np.clip(rng.normal(rgb, 6, (600, 3)), 0, 255)
    return (turned + rng.uniform(-5, 5, 3)).astype(np.float32), colours.astype(np.uint8)


def signature(size=(0.4, 0.2, 0.3), rgb=RED, turn_deg=0.0, seed=0):
    return signature_of(*box_of_voxels(size, rgb, turn_deg, seed), UP)


def test_a_signature_is_the_size_and_does_not_depend_on_place_or_turn():
    one, other = signature(seed=1), signature(seed=2, turn_deg=50)
    assert one.size_m == pytest.approx([0.4, 0.2, 0.3], rel=0.1)
    assert one.colours.sum() == pytest.approx(1.0, abs=1e-4)
    assert likeness(one, other) > 0.9
    assert likeness(one, one) == pytest.approx(1.0, abs=1e-4)


def test_another_colour_or_size_is_not_alike():
    one = signature()
    assert likeness(one, signature(rgb=BLUE)) < 0.05
    assert likeness(one, signature(size=(0.8, 0.4, 0.9))) < 0.2
    assert likeness(one, signature(size=(0.4, 0.1, 0.3))) > 0.6  # its far side is not seen yet


def thing(instance_id, last_seen_ns=9_000):
    one = instance(instance_id, Thing("thing", (0, 0, 0), (1, 1, 1)))
    assert one.last_seen_ns == last_seen_ns
    return one


class Things:
    """Settled at once; times in ns."""

    def __init__(self):
        self.recognition = Recognition(RecognitionParams(settle_s=1e-6, recall_s=1.0))

    def see(self, instance_id, seen, born_ns=10_000):
        self.recognition.see(instance_id, Appearance(seen, born_ns))

    def vanish(self, instance_id, now_ns=20_000):
        self.recognition.vanish(thing(instance_id), 500, now_ns)

    def pairs(self, now_ns=30_000):
        found = self.recognition.decide(now_ns)
        return [(new, vanished.instance.instance_id) for new, vanished in found]


@pytest.mark.parametrize("seen_first", [True, False])
def test_what_vanished_and_came_elsewhere_is_recognised_in_either_order(seen_first):
    things = Things()
    things.see(1, signature(), born_ns=0)
    if not seen_first:
        things.vanish(1)
    things.see(2, signature(seed=3))
    assert things.pairs() == ([] if seen_first else [(2, 1)])
    if seen_first:
        things.vanish(1)
    assert things.pairs() == [(2, 1)]
    things.recognition.recognise(2, 1)
    assert things.pairs() == []
    assert things.recognition.knows(1)


def test_what_was_there_before_the_other_was_last_seen_is_not_it():
    things = Things()
    things.see(1, signature(), born_ns=0)
    things.see(2, signature(seed=3), born_ns=8_999)
    things.vanish(1)
    assert things.pairs() == []


def test_what_is_new_has_to_settle_and_what_vanished_is_forgotten_in_time():
    things = Things()
    things.see(1, signature(), born_ns=0)
    things.vanish(1)
    things.see(2, signature(seed=3))
    assert things.pairs(now_ns=10_500) == []
    assert things.pairs(now_ns=11_000) == [(2, 1)]
    assert things.pairs(now_ns=2_000_000_000) == []


def test_of_two_equal_things_none_is_recognised():
    things = Things()
    for instance_id in (1, 2):
        things.see(instance_id, signature(seed=instance_id), born_ns=0)
        things.vanish(instance_id)
    things.see(3, signature(seed=3))
    assert things.pairs() == []
    twins = Things()
    twins.see(1, signature(), born_ns=0)
    twins.vanish(1)
    for instance_id in (2, 3):
        twins.see(instance_id, signature(seed=instance_id))
    assert twins.pairs() == []


def test_a_rival_that_is_less_alike_does_not_matter():
    things = Things()
    things.see(1, signature(), born_ns=0)
    things.see(4, signature(rgb=BLUE), born_ns=0)
    things.vanish(1)
    things.vanish(4)
    things.see(2, signature(seed=3))
    things.see(3, signature(rgb=BLUE, seed=4))
    assert things.pairs() == [(2, 1), (3, 4)]


def test_what_was_merged_is_compared_no_more():
    things = Things()
    things.see(1, signature(), born_ns=0)
    things.vanish(1)
    things.see(2, signature(seed=3))
    things.recognition.forget(2)
    assert things.pairs() == []
    assert not things.recognition.knows(2)
