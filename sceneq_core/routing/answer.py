"""What a question is answered with: claims, evidence, confidence and cost."""

from dataclasses import dataclass

from sceneq_core.reasoning.reasoner import NO_USAGE, Usage
from sceneq_core.routing.gate import Confidence
from sceneq_core.routing.labels import Label
from sceneq_core.routing.scene import Revision, SceneInstance

FOUND, AMBIGUOUS, NOT_FOUND = "found", "ambiguous", "not_found"
FAST, REASONED, FALLBACK = "fast", "reasoned", "fallback"


@dataclass(frozen=True, slots=True)
class Match:
    """An instance with the probability ``p`` that it is meant and its ``cosine`` to the words."""

    instance: SceneInstance
    p: float
    cosine: float


@dataclass(frozen=True, slots=True)
class Answer:
    """The answer to a question.

    ``status``: ``found`` = the first match is it; ``ambiguous`` = which one of these?;
    ``not_found`` = most probably not in the map, the matches are only the least unlike.
    ``presence`` is the probability that the best instance is called what the question says rather
    than anything in the label set. ``route``: ``fast`` = the encoder alone, ``reasoned`` = a
    reasoner chose, ``fallback`` = a reasoner should have chosen but did not.
    """

    status: str
    question: str
    matches: tuple[Match, ...]
    confidence: Confidence
    presence: float
    route: str
    reason: str
    vlm_calls: int
    revision: Revision
    usage: Usage = NO_USAGE


@dataclass(frozen=True, slots=True)
class Naming:
    """What an instance is called: the most probable labels, best first; ``route`` as above."""

    status: str
    instance: SceneInstance
    labels: tuple[Label, ...]
    confidence: Confidence
    reason: str
    revision: Revision
    route: str = FAST
    vlm_calls: int = 0
    usage: Usage = NO_USAGE
