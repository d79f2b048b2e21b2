"""Questions for what is not there: labels that name nothing in a room, purposes nothing serves.

A recording asks for a few absent things only, and never for a purpose in vain.
"""

from collections.abc import Sequence

import numpy as np

from sceneq_core.mapping.delta import OBJECT
from sceneq_core.routing.router import Router
from sceneq_tools.evaluation.retrieval_queries import ABSENT, Query
from sceneq_tools.evaluation.true_things import TrueThing
from sceneq_tools.room.truth.phrases import PURPOSES

MANY = 60
"""So many questions a room, evenly spread over the label set, say as much as all of them."""


def absent_names(
    router: Router, things: Sequence[TrueThing], many: int = MANY
) -> tuple[Query, ...]:
    """Return questions for at most ``many`` labels that none of ``things`` can be called.

    What means the same as a name in the room, or shares a word with one, is not asked for: whether
    a bookshelf is a shelf is no question of calibration. Nor are parts of the building.
    """
    names = sorted({name.lower() for thing in things for name in thing.names})
    labels = router.labeller.label_set.labels
    strange = np.ones(len(labels), np.bool_)
    for name in names:
        question = router.read(name)
        strange &= question.wanted[question.phrase.target].rivals
    known = {word for name in names for word in name.split()}
    absent = [
        label
        for label, is_strange in zip(labels, strange, strict=True)
        if is_strange and known.isdisjoint(label.lower().split()) and _is_object(router, label)
    ]
    spread = np.unique(np.linspace(0, len(absent) - 1, min(many, len(absent))).astype(np.int64))
    return tuple(Query(absent[place], ABSENT, frozenset()) for place in spread.tolist())


def absent_purposes(things: Sequence[TrueThing]) -> tuple[Query, ...]:
    """Return questions for what none of ``things`` is good for; none where nobody says what is."""
    served = {purpose for thing in things for purpose in thing.affordances}
    vain = [text for text, purposes in PURPOSES if purposes.isdisjoint(served)] if served else []
    return tuple(Query(text, ABSENT, frozenset()) for text in vain)


def _is_object(router: Router, label: str) -> bool:
    question = router.read(label)
    return question.wanted[question.phrase.target].role == OBJECT
