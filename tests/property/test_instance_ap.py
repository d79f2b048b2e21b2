"""The fast evaluation gives what the published rules give, whatever the scene."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sceneq_core.evaluation.annotation import from_codes
from sceneq_core.evaluation.instance_ap import instance_ap
from sceneq_core.evaluation.masks import PredictedMasks
from sceneq_core.evaluation.protocol import AGNOSTIC, MASKCLUSTERING, SCANNET200

from support.scannet_reference import (
    Prediction,
    annotated_only,
    reference_ap,
    without_classes,
)

CLASSES = {2: "chair", 4: "table", 7: "cabinet"}
LABELS = (0, 2, 4, 7, 9)
TIGHT = 1e-9


def random_scene(rng: np.random.Generator) -> tuple[list[Prediction], np.ndarray]:
    """Return few points, many overlaps: objects of all sizes, predictions close to them or not."""
    n = int(rng.integers(1, 240))
    cuts = np.sort(rng.integers(0, n + 1, int(rng.integers(0, 12))))
    number = np.searchsorted(cuts, np.arange(n), side="right")
    label_of = rng.choice(LABELS, len(cuts) + 1)
    codes = np.where(number == 0, 0, label_of[number] * 1000 + number)
    count = int(rng.integers(0, 16))
    predictions = [
        Prediction(random_mask(rng, number), int(rng.choice(LABELS)), float(rng.integers(0, 5)) / 4)
        for _ in range(count)
    ]
    return predictions, codes


def random_mask(rng: np.random.Generator, number: np.ndarray) -> np.ndarray:
    """Return one or two objects with some points lost and some too many."""
    chosen = np.isin(number, rng.integers(0, number.max() + 1, int(rng.integers(1, 3))))
    lost = rng.random(len(number)) < rng.choice([0.0, 0.1, 0.5])
    gained = rng.random(len(number)) < rng.choice([0.0, 0.05, 0.3])
    return (chosen & ~lost) | gained


def masks(predictions: list[Prediction]) -> PredictedMasks:
    points = [np.flatnonzero(p.mask) for p in predictions]
    sizes = [len(p) for p in points]
    return PredictedMasks(
        mask=np.repeat(np.arange(len(predictions)), sizes),
        point=np.concatenate([np.zeros(0, np.int64), *points]),
        label=np.array([p.label for p in predictions], np.int64),
        score=np.array([p.score for p in predictions], np.float64),
    )


def fast_ap(scenes, protocol, min_region) -> dict[str, np.ndarray]:
    pairs = [(masks(predictions), from_codes(codes)) for predictions, codes in scenes]
    result = instance_ap(pairs, CLASSES, protocol, min_region)
    return {one.name: one.ap for one in result.classes}


def random_scenes(seed: int, count: int):
    rng = np.random.default_rng(seed)
    return [random_scene(rng) for _ in range(count)], int(rng.choice([1, 5, 20]))


SEEDS = st.integers(0, 2**32 - 1)
COUNTS = st.integers(1, 3)


@given(SEEDS, COUNTS)
def test_labelled_ap_is_the_published_one(seed: int, count: int) -> None:
    scenes, min_region = random_scenes(seed, count)
    expected = reference_ap(scenes, CLASSES, SCANNET200.overlaps, min_region)
    actual = fast_ap(scenes, SCANNET200, min_region)
    for row, name in zip(expected, CLASSES.values(), strict=True):
        absent = np.full(len(row), np.nan)
        np.testing.assert_allclose(actual.get(name, absent), row, atol=TIGHT, rtol=0)


@given(SEEDS, COUNTS)
def test_class_agnostic_ap_is_the_published_one_of_a_single_class(seed: int, count: int) -> None:
    scenes, min_region = random_scenes(seed, count)
    one_class = annotated_only(scenes, CLASSES, 2)
    expected = reference_ap(one_class, {2: "object"}, AGNOSTIC.overlaps, min_region)[0]
    actual = fast_ap(scenes, AGNOSTIC, min_region).get("object", np.full(len(expected), np.nan))
    np.testing.assert_allclose(actual, expected, atol=TIGHT, rtol=0)


@given(SEEDS, COUNTS)
def test_no_class_ap_is_the_published_one(seed: int, count: int) -> None:
    scenes, min_region = random_scenes(seed, count)
    one_class = without_classes(scenes, 2)
    expected = reference_ap(one_class, {2: "object"}, MASKCLUSTERING.overlaps, min_region)[0]
    actual = fast_ap(scenes, MASKCLUSTERING, min_region)["object"]
    np.testing.assert_allclose(actual, expected, atol=TIGHT, rtol=0)


@given(SEEDS)
def test_only_the_order_of_scores_counts(seed: int) -> None:
    scenes, min_region = random_scenes(seed, 1)
    stretched = [
        ([Prediction(p.mask, p.label, np.exp(3 * p.score) - 7) for p in predictions], codes)
        for predictions, codes in scenes
    ]
    for protocol in (SCANNET200, AGNOSTIC, MASKCLUSTERING):
        before = fast_ap(scenes, protocol, min_region)
        after = fast_ap(stretched, protocol, min_region)
        for name, ap in before.items():
            np.testing.assert_array_equal(after[name], ap)


@given(SEEDS)
def test_perfect_predictions_have_ap_1(seed: int) -> None:
    scenes, min_region = random_scenes(seed, 1)
    _, codes = scenes[0]
    perfect = [
        Prediction(codes == code, int(code // 1000), 0.5) for code in np.unique(codes[codes > 0])
    ]
    for ap in fast_ap([(perfect, codes)], SCANNET200, min_region).values():
        assert np.isnan(ap).all() or ap == pytest.approx(1.0)
