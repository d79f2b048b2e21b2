"""Problems with views, and their keyframes: for reasoners that look."""

import numpy as np

from sceneq_core.reasoning.reasoner import Candidate, Constraint, LabelProblem, Problem

FRAME_SHAPE = (120, 160, 3)


def keyframe(seq, timeout_s=2.0):
    """A grey picture, its brightness the seq."""
    return np.full(FRAME_SHAPE, 100 + seq % 100, np.uint8)


def thing(instance_id, p, *views, role="target", words="mug", centre=(0.0, 0.0, 0.0)):
    """A candidate seen in ``views``: (seq, box)."""
    T_world_box = np.eye(4)
    T_world_box[:3, 3] = centre
    return Candidate(
        instance_id=instance_id,
        role=role,
        words=words,
        label=words,
        p=p,
        cosine=p,
        centre_world=np.array(centre, float),
        T_world_box=T_world_box,
        box_size_m=np.array([0.2, 0.2, 0.2]),
        views=tuple(views),
    )


LEFT, MIDDLE, RIGHT = (10.0, 20.0, 40.0, 60.0), (60.0, 20.0, 90.0, 60.0), (110.0, 20.0, 150.0, 60.0)
MUGS = (
    thing(7, 0.4, (3, LEFT), (5, LEFT)),
    thing(4, 0.3, (3, RIGHT)),
    thing(9, 0.2, (8, MIDDLE)),
)
SINK = thing(2, 0.9, (3, MIDDLE), role="anchor", words="sink")


def which_mug(text="the mug next to the sink", time_s=5.0, candidates=(*MUGS, SINK)):
    """Boxes 1, 2, 3 mark the instances 7, 4, 9."""
    return Problem(
        text=text,
        target="mug",
        constraints=(Constraint("next_to", "sink"),),
        candidates=candidates,
        up_world=np.array([0.0, 0.0, 1.0]),
        viewpoint_world=np.zeros(3),
        time_s=time_s,
    )


def what_is_it(labels=(("mug", 0.5), ("cup", 0.3), ("bowl", 0.1)), time_s=5.0, seqs=(3, 5, 8)):
    return LabelProblem(7, tuple(labels), tuple((seq, LEFT) for seq in seqs), time_s)
