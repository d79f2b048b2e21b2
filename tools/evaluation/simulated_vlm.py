"""A vision-language model that is not there: right as often as it is told to be.

For the cost-accuracy curve of policies on machines without a model. It knows the truth and says
it with a given probability; else it picks another candidate. What it says depends on the seed and
the question only, so all policies get the same answers. No real model errs so evenly: this measures
policies, not models.
"""

import hashlib

from sceneq_core.reasoning.reasoner import (
    LabelProblem,
    LabelVerdict,
    Pictures,
    Problem,
    UnansweredError,
    Verdict,
    no_pictures,
)

SURE = 0.75
"""The probability that one vote gives its choice, as ``VisualParams.prior_votes`` makes it."""


class SimulatedVlm:
    """Answers one question in one call, right with probability ``accuracy``.

    ``right`` are the instances that are meant; ``seed`` names the question, too.
    """

    def __init__(self, right: frozenset[int], accuracy: float, seed: str) -> None:
        self._right = right
        self._accuracy = accuracy
        self._seed = seed

    def solve(self, problem: Problem, pictures: Pictures = no_pictures) -> Verdict:
        """Choose one of the targets, or none."""
        targets = [c.instance_id for c in problem.candidates if c.role == "target"]
        right = self._right & set(targets)
        choices: list[int | None] = [*targets, None]
        good = [one for one in choices if (one in right if right else one is None)]
        bad = [one for one in choices if one not in good]
        lucky = self._draw("luck") < self._accuracy
        among = good if lucky or not bad else bad
        choice = among[int(self._draw("choice") * len(among))]
        if choice is None:
            return Verdict((), "simulated: none of them", 1)
        rest = (1.0 - SURE) / len(targets)
        ranking = [(one, rest) for one in targets if one != choice]
        return Verdict(((choice, SURE), *ranking), "simulated", 1)

    def label(self, problem: LabelProblem, pictures: Pictures = no_pictures) -> LabelVerdict:
        """Name nothing."""
        raise UnansweredError("simulated: names nothing")

    def close(self) -> None:
        """Nothing to release."""

    def _draw(self, what: str) -> float:
        """Return a number in [0, 1) that depends on the seed and what it is for."""
        digest = hashlib.sha256(f"{self._seed} {what}".encode()).digest()
        return int.from_bytes(digest[:7], "big") / 2**56
