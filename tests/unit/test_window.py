"""Keyframes in flight."""

from sceneq_nodes._window import Window


def filled(tries: int = 3) -> Window[str]:
    window: Window[str] = Window(size=2, resend_s=2.0, tries=tries)
    window.sent(0, "a", 0.0)
    window.sent(10, "b", 1.0)
    return window


def test_it_has_room_for_size() -> None:
    window = filled()
    assert not window.has_room()
    window.acknowledge(10, 1.5)
    assert window.has_room()
    assert len(window) == 1


def test_the_first_message_goes_alone() -> None:
    window: Window[str] = Window(size=3, resend_s=2.0, tries=2)
    window.sent(0, "a", 0.0)
    assert not window.has_room()
    assert window.overdue(2.0) == ["a"]
    window.acknowledge(0, 2.1)
    window.sent(10, "b", 2.2)
    window.sent(20, "c", 2.2)
    assert window.has_room()


def test_unknown_and_repeated_acknowledgements_are_no_matter() -> None:
    window = filled()
    window.acknowledge(99, 1.9)
    window.acknowledge(-1, 1.9)
    assert window.overdue(2.0) == ["a"]
    window.acknowledge(0, 2.1)
    window.acknowledge(0, 2.1)
    assert len(window) == 1


def test_silence_makes_messages_overdue() -> None:
    window = filled()
    assert window.overdue(1.9) == []
    assert window.overdue(3.5) == ["a", "b"]
    assert window.overdue(3.6) == []


def test_any_acknowledgement_gives_the_others_more_time() -> None:
    window = filled()
    window.acknowledge(0, 2.9)
    assert window.overdue(4.8) == []
    assert window.overdue(4.9) == ["b"]


def test_waits_double_and_then_the_message_is_lost() -> None:
    window = filled(tries=3)
    window.acknowledge(10, 0.0)
    times = [t / 2 for t in range(1, 60)]
    sent_again = [t for t in times if window.overdue(t) and not window.lost(t)]
    assert sent_again == [2.0, 6.0]
    assert window.lost(13.9) == []
    assert window.lost(14.0) == [0]
    assert window.has_room()
    assert window.lost(99.0) == []


def test_one_try_is_lost_without_a_second() -> None:
    window = filled(tries=1)
    assert window.overdue(5.0) == []
    assert window.lost(5.0) == [0, 10]
