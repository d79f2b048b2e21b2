"""Which message belongs to which keyframe."""

from sceneq_schemas.topics import FEATURE_DELTA, FRAME, LABEL_DELTA, MAP_DELTA, MASK, VIEW_DELTA
from sceneq_tools.trace import STAGES, Heard, Tracer


def followed(most: int, *heard: tuple) -> Tracer:
    tracer = Tracer(most)
    for at_s, (topic, frame_seq) in enumerate(heard):
        tracer.take(Heard(topic, frame_seq, 1024, float(at_s)))
    return tracer


def test_a_keyframe_is_followed_from_its_frame_to_its_labels() -> None:
    tracer = followed(1, *((topic, 7) for topic in STAGES))
    assert tracer.is_done()
    rows = tracer.traces[7].rows()
    assert [row[2] for row in rows] == ["0.0", "1000.0", "2000.0", "3000.0", "4000.0", "5000.0"]
    assert rows[1] == ("7", "segmentation: masks", "1000.0", "1.0")


def test_what_names_a_later_keyframe_covers_the_earlier_one() -> None:
    tracer = followed(1, (FRAME, 7), (MASK, 7), (MAP_DELTA, 7), (VIEW_DELTA, 8), (LABEL_DELTA, 9))
    trace = tracer.traces[7]
    assert (trace.at_s[VIEW_DELTA], trace.at_s[LABEL_DELTA]) == (3.0, 4.0)
    assert not tracer.is_done()
    assert trace.rows()[4] == ("7", "encoding: descriptors", "-", "-")


def test_masks_and_maps_of_other_keyframes_are_not_taken_for_it() -> None:
    tracer = followed(1, (FRAME, 7), (MASK, 6), (MAP_DELTA, 8), (FEATURE_DELTA, 6))
    assert tracer.traces[7].at_s == {FRAME: 0.0}


def test_no_more_keyframes_than_asked_for_and_the_first_message_counts() -> None:
    tracer = followed(2, (FRAME, 1), (FRAME, 2), (FRAME, 3), (MASK, 1), (MASK, 1))
    assert sorted(tracer.traces) == [1, 2]
    assert tracer.traces[1].at_s[MASK] == 3.0
