"""A reasoner that looks gets the recording's frames when it is evaluated."""

from dataclasses import replace

import numpy as np
import pytest

from sceneq_core.reasoning.reasoner import UnansweredError
from sceneq_core.routing.answer import FALLBACK
from sceneq_core.views.jpeg import jpeg_from_rgb
from sceneq_tools.errors import UserError
from sceneq_tools.evaluation.recording_pictures import pictures_of
from sceneq_tools.evaluation.retrieval_asking import ALWAYS, Asking
from sceneq_tools.evaluation.retrieval_queries import Query

from support.furnished import router, snapshot
from support.questioned import hash_setup


def test_a_frame_is_read_by_its_number(tmp_path):
    (tmp_path / "frame-000007.color.jpg").write_bytes(jpeg_from_rgb(np.full((6, 8, 3), 90, "u1")))
    picture = pictures_of(tmp_path)
    assert picture(7, 1.0).shape == (6, 8, 3)
    assert picture(8, 1.0) is None


def test_a_broken_frame_is_named(tmp_path):
    (tmp_path / "frame-000007.color.jpg").write_bytes(b"no picture")
    with pytest.raises(UserError, match=r"frame-000007.color.jpg: 10 bytes are no JPEG"):
        pictures_of(tmp_path)(7, 1.0)


class Looking:
    """Remembers what it was shown."""

    def __init__(self):
        self.seen = []

    def solve(self, problem, pictures):
        self.seen.append(pictures(problem.candidates[0].views[0][0], 1.0))
        raise UnansweredError("looked", 1)


def test_they_reach_the_reasoner():
    looking = Looking()
    setup = replace(hash_setup(), router=router(), reasoner=looking)
    asking = Asking(setup, snapshot(), lambda seq, timeout_s: f"frame {seq}")
    answered = asking.ask(Query("lamp", "category", frozenset([16])), ALWAYS)
    assert (answered.route, answered.vlm_calls) == (FALLBACK, 1)
    assert answered.reason.startswith("looked; ")
    assert looking.seen == ["frame 160"]
