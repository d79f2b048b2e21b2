"""Cost-accuracy curves: what each policy makes of the same questions."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from sceneq_core.evaluation.cost_accuracy import best_accuracy, mixed_accuracy
from sceneq_core.routing.budget import Budget
from sceneq_core.routing.outlook import KINDS, Skill
from sceneq_tools.evaluation.policy_outcomes import SCALES, Outcome, skills_of
from sceneq_tools.evaluation.policy_replay import (
    ADAPTIVE,
    ALWAYS,
    INTERVAL_S,
    NEVER,
    THRESHOLDS,
    Contender,
    Replayed,
    replay,
)

CALLS_PER_HOUR = (3, 6, 12, 24, 36, 48)
"""With a question a minute: from 0.05 to 0.8 calls a question."""

PAPER = "x 1"
PROTOCOL = (
    f"one question every {INTERVAL_S:g} s in shuffled orders, means over orders; cost: calls of "
    "the reasoner a question, one that makes no calls counting as one; right: hit@1, absent: "
    "not_found; beside random: points above asking at random as often; a recording is judged by "
    "what the reasoner did in the others"
)


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """The results with one reasoner, and what is known of that reasoner."""

    reasoner: str
    questions: int
    skills: Mapping[str, Skill]
    points: tuple[Replayed, ...]
    gains: tuple[int, ...]

    def point(self, policy: str, setting: str = "") -> Replayed:
        """Return one result."""
        return next(
            one
            for one in self.points
            if (one.contender.policy, one.contender.setting) == (policy, setting)
        )

    def beside_random(self, one: Replayed) -> float:
        """Return how far it is above asking at random as often."""
        ends = [self.point(name) for name in (NEVER, ALWAYS)]
        never, always = ((end.cost, end.accuracy) for end in ends)
        return one.accuracy - mixed_accuracy(one.cost, never, always)

    def foresight(self, cost: float) -> float:
        """Return the accuracy that nobody exceeds at this cost."""
        return best_accuracy(cost, self.gains, self.point(NEVER).accuracy)

    def as_dict(self) -> dict[str, Any]:
        """Return everything in values that JSON knows."""
        return {
            "reasoner": self.reasoner,
            "questions": self.questions,
            "skills": {kind: asdict(skill) for kind, skill in self.skills.items()},
            "points": [
                {
                    "policy": one.contender.policy,
                    "setting": one.contender.setting,
                    "calls_per_hour": one.contender.budget.calls_per_hour,
                    "cost": one.cost,
                    "accuracy": one.accuracy,
                    "refused": one.refused,
                    "beside_random": self.beside_random(one),
                    "foresight": self.foresight(one.cost),
                }
                for one in self.points
            ],
        }


def contenders() -> tuple[Contender, ...]:
    """Return every policy at every setting."""
    budgets = [(f"{calls} calls/h", Budget(calls_per_hour=calls)) for calls in CALLS_PER_HOUR]
    return (
        Contender(NEVER, ""),
        *(Contender(THRESHOLDS, f"x {scale:g}", scale=scale) for scale in SCALES),
        Contender(ALWAYS, ""),
        *(Contender(THRESHOLDS, name, budget) for name, budget in budgets),
        *(Contender(ADAPTIVE, name, budget) for name, budget in budgets),
        Contender(ADAPTIVE, "no limit"),
    )


def curve(reasoner: str, outcomes: Sequence[Outcome], orders: int, seed: int) -> Curve:
    """Replay every contender on the same questions."""
    skills = skills_of(outcomes)
    return Curve(
        reasoner=reasoner,
        questions=len(outcomes),
        skills={kind: skills[kind] for kind in KINDS},
        points=tuple(replay(outcomes, one, orders, seed) for one in contenders()),
        gains=tuple(int(one.reasoned_right) - int(one.fast_right) for one in outcomes),
    )
