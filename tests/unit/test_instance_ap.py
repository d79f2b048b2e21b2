"""Instance AP of scenes so small that every number can be worked out by hand."""

import numpy as np
import pytest

from sceneq_core.evaluation.annotation import Annotation, from_codes
from sceneq_core.evaluation.instance_ap import InstanceAp, instance_ap
from sceneq_core.evaluation.masks import PredictedMasks, disjoint_masks
from sceneq_core.evaluation.protocol import AGNOSTIC, MASKCLUSTERING, PROTOCOLS, SCANNET200
from sceneq_core.evaluation.scannet200_ids import INSTANCE_CLASSES, LABELS, SPLITS

CHAIR, TABLE, OUTSIDE = 2, 4, 9
CLASSES = {CHAIR: "chair", TABLE: "table"}
MIN_REGION = 10
STEPS = (0.5, 0.55, 0.6, 0.65, 0.7, 0.75, 0.8, 0.85, 0.9, 0.95, 0.25)


def truth(*runs: tuple[int, int]) -> Annotation:
    """Return points in runs of (how many, code)."""
    return from_codes(np.repeat([code for _, code in runs], [n for n, _ in runs]))


def masks(*predictions: tuple[range | list[int], int, float]) -> PredictedMasks:
    """Return masks of (points, label, score)."""
    points = [np.array(p, np.int64) for p, _, _ in predictions]
    return PredictedMasks(
        mask=np.repeat(np.arange(len(points)), [len(p) for p in points]),
        point=np.concatenate([np.zeros(0, np.int64), *points]),
        label=np.array([label for _, label, _ in predictions], np.int64),
        score=np.array([score for _, _, score in predictions], np.float64),
    )


def evaluated(predicted, annotated, protocol=SCANNET200) -> InstanceAp:
    return instance_ap([(predicted, annotated)], CLASSES, protocol, MIN_REGION)


def ap_at(result: InstanceAp, overlap: float, name: str = "chair") -> float:
    """Return the AP of a class at one threshold."""
    one = next(each for each in result.classes if each.name == name)
    return float(one.ap[list(result.protocol.overlaps).index(overlap)])


def test_two_predictions_on_one_object() -> None:
    # IoU 1.0 with score 0.5 and 0.8 with score 0.9: above both thresholds the better score is
    # right and the other wrong, but at a lower score, where recall is complete already.
    two = masks((range(100), CHAIR, 0.5), (range(80), CHAIR, 0.9))
    result = evaluated(two, truth((100, 2001)))
    assert ap_at(result, 0.5) == pytest.approx(1.0)
    # At 0.85 the surer one misses: precision 0 at recall 0, then 1/2 at recall 1.
    assert ap_at(result, 0.85) == pytest.approx(0.25)


def test_an_equal_overlap_is_not_enough() -> None:
    half = masks((range(50), CHAIR, 0.5))
    result = evaluated(half, truth((100, 2001)))
    assert ap_at(result, 0.5) == 0.0
    assert ap_at(result, 0.25) == pytest.approx(1.0)


def test_a_prediction_mostly_on_void_is_ignored() -> None:
    # 60 of its 100 points are void: ignored where the threshold is below 0.6, wrong from there on.
    astray = [*range(160, 200), *range(200, 260)]
    predicted = masks((range(200), CHAIR, 0.4), (astray, CHAIR, 0.9))
    result = evaluated(predicted, truth((200, 2001), (100, 0)))
    assert ap_at(result, 0.5) == pytest.approx(1.0)
    assert ap_at(result, 0.55) == pytest.approx(1.0)
    assert ap_at(result, 0.6) == pytest.approx(0.25)


def test_labels_outside_the_benchmark_are_void_and_other_classes_are_not() -> None:
    annotated = truth((100, 2001), (100, 9002), (100, 4003))
    right = (range(100), CHAIR, 0.4)
    assert ap_at(evaluated(masks(right, (range(100, 200), CHAIR, 0.9)), annotated), 0.5) == 1.0
    assert ap_at(evaluated(masks(right, (range(200, 300), CHAIR, 0.9)), annotated), 0.5) == 0.25


def test_ties_in_score_enter_the_curve_together() -> None:
    annotated = truth((100, 2001), (100, 4002))
    tied = masks((range(100), CHAIR, 0.5), (range(100, 200), CHAIR, 0.5))
    # One point only: precision 1/2 at recall 1; the area down from (0, 1) is 3/4.
    assert ap_at(evaluated(tied, annotated), 0.5) == pytest.approx(0.75)
    turned = masks((range(100, 200), CHAIR, 0.5), (range(100), CHAIR, 0.5))
    assert ap_at(evaluated(turned, annotated), 0.5) == pytest.approx(0.75)
    apart = masks((range(100), CHAIR, 0.6), (range(100, 200), CHAIR, 0.5))
    assert ap_at(evaluated(apart, annotated), 0.5) == pytest.approx(1.0)


def test_an_empty_prediction_has_ap_0() -> None:
    result = evaluated(masks(), truth((100, 2001)))
    assert result.means == pytest.approx([0.0, 0.0, 0.0])
    assert (result.objects, result.predictions) == (1, 0)


def test_an_empty_truth_has_no_ap() -> None:
    for annotated in (truth((100, 0)), truth()):
        predicted = masks((range(len(annotated)), CHAIR, 0.5)) if len(annotated) else masks()
        result = evaluated(predicted, annotated)
        assert np.isnan(result.means).all()
        assert result.as_dict()["ap"] is None


def test_predictions_of_a_class_without_objects_are_held_against_nobody() -> None:
    predicted = masks((range(100), CHAIR, 0.5), (range(100), TABLE, 0.9))
    result = evaluated(predicted, truth((100, 2001)))
    assert result.means == pytest.approx([1.0, 1.0, 1.0])
    assert result.as_dict()["classes"]["table"] == {
        "objects": 0,
        "predictions": 1,
        "ap": None,
        "ap50": None,
        "ap25": None,
    }


def test_regions_too_small_do_not_count() -> None:
    # The second object has 9 points: hitting it is neither right nor wrong.
    annotated = truth((100, 2001), (9, 2002), (1, 0))
    hits_small = masks((range(100), CHAIR, 0.4), (range(100, 110), CHAIR, 0.9))
    result = evaluated(hits_small, annotated)
    assert result.means == pytest.approx([1.0, 1.0, 1.0])
    assert result.objects == 1
    too_small = masks((range(100), CHAIR, 0.4), (range(9), CHAIR, 0.9))
    assert evaluated(too_small, annotated).predictions == 1


def test_points_on_small_objects_excuse_like_void() -> None:
    # 9 of 20 points on the small object: excused below 0.45, wrong above.
    annotated = truth((100, 2001), (9, 2002))
    mixed = masks((range(100), CHAIR, 0.4), (range(89, 109), CHAIR, 0.9))
    result = evaluated(mixed, annotated)
    assert ap_at(result, 0.25) == pytest.approx(1.0)
    assert ap_at(result, 0.5) == pytest.approx(0.25)


def test_the_first_prediction_takes_an_object_and_the_others_stay_free() -> None:
    # A covers half of both objects (IoU 1/3 with each), B all of the first.
    annotated = truth((60, 2001), (60, 2002))
    a, b = (range(30, 90), CHAIR, 0.3), (range(60), CHAIR, 0.9)
    # B takes object 1, A is a duplicate there and still takes object 2:
    # precision 1 up to recall 1/2, then down to 2/3 at recall 1.
    assert ap_at(evaluated(masks(b, a), annotated), 0.25) == pytest.approx(0.5 + 5 / 12)
    # A takes object 1 with B's score, and object 2 finds nobody.
    assert ap_at(evaluated(masks(a, b), annotated), 0.25) == pytest.approx(0.5)
    assert ap_at(evaluated(masks(a), annotated), 0.25) == pytest.approx(0.5)


def test_scenes_are_pooled_before_the_curve_is_drawn() -> None:
    good = (masks((range(100), CHAIR, 0.9)), truth((100, 2001), (50, 4002)))
    bad = (masks((range(100, 150), CHAIR, 0.5)), truth((100, 2001), (50, 4002)))
    result = instance_ap([good, bad], CLASSES, SCANNET200, MIN_REGION)
    assert ap_at(result, 0.5) == pytest.approx(0.5)
    assert result.scenes == 2


def test_unannotated_points_are_void_or_one_more_object() -> None:
    annotated = truth((100, 2001), (100, 0))
    predicted = masks((range(100), TABLE, 0.5))
    assert evaluated(predicted, annotated, AGNOSTIC).means == pytest.approx([1.0, 1.0, 1.0])
    both = evaluated(predicted, annotated, MASKCLUSTERING)
    assert both.objects == 2
    assert both.means == pytest.approx([0.5, 0.5, 0.5])


def test_what_has_a_number_is_an_object_without_classes_whatever_its_label() -> None:
    # A wall (label 0 or outside) is void for all but MaskClustering, which looks at numbers only.
    annotated = truth((100, 2001), (100, 9002), (100, 3))
    predicted = masks(
        (range(100), CHAIR, 0.5), (range(100, 200), CHAIR, 0.5), (range(200, 300), CHAIR, 0.5)
    )
    assert evaluated(predicted, annotated, AGNOSTIC).objects == 1
    every = evaluated(predicted, annotated, MASKCLUSTERING)
    assert (every.objects, every.means[0]) == (3, pytest.approx(1.0))


def test_maskclustering_stops_at_090() -> None:
    nearly = masks((range(92), CHAIR, 0.5))
    annotated = truth((100, 2001))
    assert evaluated(nearly, annotated, AGNOSTIC).means[0] == pytest.approx(0.9)
    assert evaluated(nearly, annotated, MASKCLUSTERING).means[0] == pytest.approx(1.0)
    ended = evaluated(nearly, annotated, AGNOSTIC.ending_at(0.9))
    assert ended.means[0] == pytest.approx(1.0)
    assert ended.protocol.name == "agnostic to 0.90"


def test_the_thresholds_of_every_protocol() -> None:
    assert SCANNET200.overlaps.tolist() == list(STEPS)
    assert MASKCLUSTERING.overlaps.tolist() == [*STEPS[:9], 0.25]
    assert set(PROTOCOLS) == {"scannet200", "own-labels", "agnostic", "maskclustering"}
    with pytest.raises(ValueError, match="last_overlap"):
        AGNOSTIC.ending_at(0.4)


def test_means_of_groups_leave_out_classes_without_objects() -> None:
    annotated = truth((100, 2001), (100, 4002))
    result = evaluated(masks((range(100), CHAIR, 0.5)), annotated)
    assert result.means[0] == pytest.approx(0.5)
    document = result.as_dict({"seats": {"chair", "sofa"}, "rest": {"lamp"}})
    assert document["splits"]["seats"]["ap"] == pytest.approx(1.0)
    assert document["splits"]["rest"]["ap"] is None
    assert document["protocol"] == "scannet200"


def test_without_labels_there_are_no_groups_of_classes() -> None:
    one = (masks((range(100), CHAIR, 0.5)), truth((100, 2001)))
    assert evaluated(*one, AGNOSTIC).as_dict({"head": {"object", "chair"}})["splits"] == {}
    assert evaluated(*one).as_dict({"head": {"chair"}})["splits"]["head"]["ap50"] == 1.0


def test_scannet200_has_198_classes_of_instances() -> None:
    assert len(LABELS) == 200
    assert len(INSTANCE_CLASSES) == 198
    assert {name: len(labels) for name, labels in SPLITS.items()} == {
        "head": 64,
        "common": 68,
        "tail": 66,
    }
    known = {1: "wall", 2: "chair", 3: "floor", 13: "pillow", 28: "lamp", 1191: "mattress"}
    assert {number: LABELS[number] for number in known} == known
    assert {1, 3}.isdisjoint(INSTANCE_CLASSES)


def test_masks_of_a_cloud_keep_the_order_of_the_ids() -> None:
    instance_id = np.array([5, 0, 3, 5, 7, 3, -1])
    found = disjoint_masks(instance_id, np.array([5, 3]), np.array([1, 2]), np.array([0.1, 0.2]))
    pairs = sorted(zip(found.mask.tolist(), found.point.tolist(), strict=True))
    assert pairs == [(0, 0), (0, 3), (1, 2), (1, 5)]
    assert found.size.tolist() == [2, 2]
    none = disjoint_masks(instance_id, np.zeros(0, int), np.zeros(0, int), np.zeros(0))
    assert len(none) == 0


def test_what_does_not_fit_is_refused() -> None:
    with pytest.raises(ValueError, match="masks reach beyond the 50 points"):
        evaluated(masks((range(60), CHAIR, 0.5)), truth((50, 2001)))
    with pytest.raises(ValueError, match="min_region"):
        instance_ap([], CLASSES, SCANNET200, 0)
    with pytest.raises(ValueError, match="score: not a number"):
        masks((range(5), CHAIR, float("nan")))
    with pytest.raises(ValueError, match=r"expected \(N,\)"):
        Annotation(np.zeros(3, np.int64), np.zeros(2, np.int64))
    with pytest.raises(ValueError, match="negative"):
        Annotation(np.array([-1]), np.array([0]))
