"""What a question is answered with: claims, evidence, confidence and cost."""

from dataclasses import dataclass

from sceneq_core.reasoning.reasoner import NO_USAGE, Usage
from sceneq_core.routing.gate import Confidence
from sceneq_core.routing.labels import Label
from sceneq_core.routing.revision import Revision
from sceneq_core.routing.scene import SceneInstance

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
    ``presence`` is the probability that there is such a thing; where no calibration tells, that
    the best instance is called what the question says rather than anything in the label set.
    The p of all matches and ``confidence.p_null`` add up to 1. ``route``: ``fast`` = the encoder
    alone, ``reasoned`` = a reasoner chose, ``fallback`` = a reasoner should have but did not.
    ``cached``: it chose for somebody else who asked the same, and that still holds.
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
    cached: bool = False

    @property
    def p_right(self) -> float:
        """The probability that this answer is right, 0 to 1, as far as is known.

        Of ``not_found``: that there is no such thing; else: that the first match is meant. With a
        relation in the question it is the chance of the first match before anybody has looked at
        the relation. Without a calibration it supposes that there is such a thing.
        """
        certainty = self.confidence
        return certainty.p_null if self.status == NOT_FOUND else certainty.p_max


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
    cached: bool = False

    @property
    def p_right(self) -> float:
        """The probability that the first label is right."""
        return self.confidence.p_max


def differ(one: Answer, other: Answer) -> bool:
    """Return whether two answers to a question say different things, however surely."""
    if NOT_FOUND in (one.status, other.status):
        return one.status != other.status
    best = [[match.instance.instance_id for match in a.matches[:1]] for a in (one, other)]
    return best[0] != best[1]
