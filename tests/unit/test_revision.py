"""The time of a revision, where robots' clocks do not agree."""

from dataclasses import replace

import pytest

from sceneq_core.routing.revision import Revision

from support.furnished import ROOM, instance


def seen_at(stamp_ns):
    return replace(instance(1, ROOM[0]), last_seen_ns=stamp_ns)


@pytest.mark.parametrize(
    ("before", "changed", "expected"),
    [
        (Revision(epoch=7, stamp_ns=10), (), 20),
        (Revision(epoch=7, stamp_ns=90), (), 90),  # of a robot whose clock is ahead
        (Revision(epoch=6, stamp_ns=90), (), 20),  # of another map
        (Revision(epoch=7, stamp_ns=10), (30, 60, 50), 60),
    ],
)
def test_nothing_was_seen_later_than_now(before, changed, expected):
    newer = Revision(epoch=7, seq=3, frame_seq=5, stamp_ns=20)
    after = newer.after(before, [seen_at(stamp_ns) for stamp_ns in changed])
    assert after == Revision(epoch=7, seq=3, frame_seq=5, stamp_ns=expected)
