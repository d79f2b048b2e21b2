"""Descriptors take account of sizes, in the scene that questions are answered from."""

from dataclasses import replace

import numpy as np
import pytest

from sceneq_core.mapping.delta import FLOOR, Instance
from sceneq_core.routing.described import describe
from sceneq_core.routing.labels import Labeller, custom
from sceneq_core.routing.measured import Measured

UP = np.array([0.0, 0.0, 1.0])
BARE = np.array([0.6, 0.8], np.float32)


class TwoNames:
    """Dimensions "long" and "short"; a thing over a metre long is called so."""

    model_id, dim, temperature, ceiling = "two", 2, 0.1, 1.0

    def __init__(self):
        self.shapes = []

    def encode_crops(self, crops):
        raise NotImplementedError

    def encode_texts(self, texts):
        return np.array([[1.0, 0.0] if t == "long" else [0.0, 1.0] for t in texts], np.float32)

    def sized(self, descriptor, shape):
        self.shapes.append(shape)
        return np.array([1.0, 0.0] if shape[0] > 0 else [0.0, 1.0], np.float32)


def thing(size, bottom=0.0, role="object", number=1):
    centre = np.array([0.0, 0.0, bottom + size[2] / 2])
    T_world_box = np.eye(4)
    T_world_box[:3, 3] = centre
    half = np.array(size) / 2
    return Instance(
        instance_id=number,
        state="confirmed",
        merged_into=0,
        parent=0,
        superpoint_id=np.array([number], np.int32),
        voxel_count=10,
        centre_world=centre,
        aabb_world=np.stack([centre - half, centre + half]),
        T_world_box=T_world_box,
        box_size_m=np.array(size, np.float64),
        first_seen_ns=0,
        last_seen_ns=0,
        role=role,
    )


@pytest.fixture
def encoder():
    return TwoNames()


@pytest.fixture
def labeller(encoder):
    return Labeller(custom(["long", "short"]), encoder)


def test_a_label_follows_the_size(labeller):
    measured, bare = Measured(labeller), describe(BARE, labeller)
    assert bare.label.name == "short"
    assert measured.of(bare, thing((2.0, 0.5, 0.5))).label.name == "long"
    assert measured.of(bare, thing((0.4, 0.5, 0.5))).label.name == "short"


def test_nothing_is_worked_out_again_while_nothing_changes(labeller, encoder):
    measured, bare = Measured(labeller), describe(BARE, labeller)
    first = measured.of(bare, thing((2.0, 0.5, 0.5)))
    assert measured.of(bare, thing((2.01, 0.5, 0.5))) is first
    assert len(encoder.shapes) == 1
    assert measured.of(describe(BARE, labeller), thing((2.0, 0.5, 0.5))) is not first


def test_heights_are_above_the_floor_that_the_map_knows(labeller, encoder):
    measured, bare = Measured(labeller), describe(BARE, labeller)
    floor = thing((4.0, 4.0, 0.0), bottom=-1.3, role=FLOOR, number=2)
    cupboard = thing((1.0, 0.4, 0.5), bottom=-0.3)
    assert measured.see([floor, cupboard], UP, full=True)
    assert not measured.see([cupboard], UP, full=False)
    measured.of(bare, cupboard)
    assert encoder.shapes[-1][3] == pytest.approx(1.0)


def test_a_box_may_lie_on_its_side(labeller, encoder):
    measured, bare = Measured(labeller), describe(BARE, labeller)
    lying = thing((0.3, 0.6, 2.0))
    R_world_box = np.array([[0, 0, 1.0], [1.0, 0, 0], [0, 1.0, 0]])
    T_world_box = lying.T_world_box.copy()
    T_world_box[:3, :3] = R_world_box
    measured.of(bare, replace(lying, T_world_box=T_world_box))
    assert np.exp(encoder.shapes[-1][:3]) == pytest.approx([2.0, 0.3, 0.6], rel=0.06)


class NoSizes:
    """An encoder that looks at pictures only."""

    model_id, dim, temperature, ceiling = "no-sizes", 2, 0.1, 1.0

    def encode_crops(self, crops):
        raise NotImplementedError

    def encode_texts(self, texts):
        return TwoNames().encode_texts(texts)


def test_an_encoder_without_sizes_changes_nothing():
    labeller = Labeller(custom(["long", "short"]), NoSizes())
    bare = describe(BARE, labeller)
    assert Measured(labeller).of(bare, thing((2.0, 0.5, 0.5))) is bare
