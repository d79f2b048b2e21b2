"""The archive keeps what views refer to and the newest, and no more than its capacity."""

import numpy as np
import pytest

from sceneq_core.views.archive import ArchiveParams, ImageArchive
from sceneq_core.views.keyframe import Keyframe


def keyframe(seq: int) -> Keyframe:
    nothing = np.full((1, 1), -1, np.int32)
    return Keyframe(
        seq, seq, b"jpeg %d" % seq, (2, 2), np.zeros(3), nothing, nothing[0], nothing[0]
    )


def filled(newest: int, capacity: int, count: int) -> ImageArchive:
    archive = ImageArchive(ArchiveParams(newest, capacity))
    for seq in range(count):
        archive.add(keyframe(seq))
    return archive


def seqs(archive: ImageArchive) -> list[int]:
    return [kept.seq for kept in archive]


def test_old_keyframes_without_views_go_first():
    archive = filled(newest=3, capacity=10, count=6)
    archive.refer(1, (1, 4))
    assert archive.make_room() == (0, 2, 3)
    assert seqs(archive) == [1, 4, 5]
    assert (archive.dropped_unused, archive.dropped_used) == (3, 0)


def test_at_capacity_the_least_used_goes_though_it_is_used():
    archive = filled(newest=1, capacity=3, count=4)
    archive.refer(1, (0, 1))
    archive.refer(2, (0, 2))
    archive.refer(3, (0, 2, 3))
    assert archive.make_room() == (1, 3)
    assert seqs(archive) == [0, 2]
    assert (archive.dropped_unused, archive.dropped_used) == (0, 2)


def test_the_newest_stay_unreferred():
    archive = filled(newest=4, capacity=4, count=3)
    assert archive.make_room() == ()
    assert seqs(archive) == [0, 1, 2]


def test_an_instance_that_lets_go_frees_its_keyframes():
    archive = filled(newest=1, capacity=9, count=3)
    archive.refer(1, (0, 1))
    archive.refer(1, (1,))
    archive.refer(2, (2,))
    archive.refer(2, ())
    assert archive.make_room() == (0, 2)


def test_images_are_found_by_seq():
    archive = filled(newest=1, capacity=9, count=2)
    assert archive.jpeg(1) == b"jpeg 1"
    assert archive.jpeg(7) is None


@pytest.mark.parametrize(("newest", "capacity"), [(0, 5), (6, 5)])
def test_parameters_are_checked(newest, capacity):
    with pytest.raises(ValueError, match=r"newest|capacity"):
        ArchiveParams(newest, capacity)
