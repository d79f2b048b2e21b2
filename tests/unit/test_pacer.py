"""Playing at a fixed rate."""

from sceneq_nodes._pacer import Pacer


def test_the_first_frame_is_due_at_once_and_starts_the_schedule() -> None:
    pacer = Pacer(10.0)
    assert pacer.is_due(100.0)
    assert not pacer.take(100.0)
    assert not pacer.is_due(100.09)
    assert pacer.is_due(100.11)


def test_frames_follow_at_the_rate_whatever_the_polling() -> None:
    pacer, taken = Pacer(30.0), []
    for tick in range(1000):
        now_s = tick * 0.007
        if pacer.is_due(now_s):
            assert not pacer.take(now_s)
            taken.append(now_s)
    assert len(taken) == 210  # 7 s


def test_after_a_delay_the_missed_frames_follow_at_once_and_are_late() -> None:
    pacer = Pacer(10.0)
    pacer.take(0.0)
    late = []
    while pacer.is_due(0.55):
        late.append(pacer.take(0.55))
    assert late == [True, True, True, True, False]
    assert pacer.is_due(0.61)
