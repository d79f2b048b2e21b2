"""A policy on a stream of questions whose outcomes are known: what it spends, and what is right."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from sceneq_core.routing.budget import Budget, Cost, Ledger, OverBudgetError
from sceneq_core.routing.outlook import ABSENCE, RELATION, THING, Outlook, OutlookParams
from sceneq_core.routing.policy import PolicyParams, new_policy
from sceneq_tools.evaluation.policy_outcomes import Outcome, skills_of

NEVER, ALWAYS, THRESHOLDS, ADAPTIVE = "never", "always", "thresholds", "adaptive"

INTERVAL_S = 60.0
"""One question a minute."""


@dataclass(frozen=True, slots=True)
class Contender:
    """A policy at one setting; ``scale`` is that of the thresholds."""

    policy: str
    setting: str
    budget: Budget = field(default_factory=Budget)
    scale: float = 1.0


@dataclass(frozen=True, slots=True)
class Replayed:
    """What came of one contender: means over all questions and orders.

    ``cost``: calls a question; ``accuracy``: share of answers that are right; ``refused``: share of
    the questions that were worth the reasoner and found the budget spent.
    """

    contender: Contender
    cost: float
    accuracy: float
    refused: float


def replay(outcomes: Sequence[Outcome], contender: Contender, orders: int, seed: int) -> Replayed:
    """Put the questions to a policy in shuffled orders.

    Each recording is judged by what the reasoner did in the others: nothing is learned from the
    questions it is scored on. A single recording is judged by the opinion that is configured.
    """
    rng = np.random.default_rng(seed)
    shuffled = [[outcomes[i] for i in rng.permutation(len(outcomes))] for _ in range(orders)]
    totals = np.zeros(3)
    for params, names in _judged_by(outcomes, contender):
        for order in shuffled:
            rows = _run(order, contender, params)
            own = [row for row, one in zip(rows, order, strict=True) if one.recording in names]
            totals += np.sum(own, axis=0)
    cost, accuracy, refused = (totals / (len(outcomes) * orders)).tolist()
    return Replayed(contender, cost, accuracy, refused)


def _judged_by(
    outcomes: Sequence[Outcome], contender: Contender
) -> Iterator[tuple[PolicyParams, frozenset[str]]]:
    """Yield parameters with the recordings that they are scored on; only some policies learn."""
    plain = PolicyParams(kind=contender.policy)
    names = list(dict.fromkeys(one.recording for one in outcomes))
    if contender.policy != ADAPTIVE or len(names) == 1:
        yield plain, frozenset(names)
        return
    for name in names:
        skills = skills_of([one for one in outcomes if one.recording != name])
        outlook = OutlookParams(skills[THING], skills[RELATION], skills[ABSENCE])
        yield replace(plain, outlook=outlook), frozenset([name])


def _run(
    outcomes: Iterable[Outcome], contender: Contender, params: PolicyParams
) -> list[tuple[int, bool, bool]]:
    """Return calls, whether right and whether refused, for every question in order."""
    outlook, ledger = Outlook(params.outlook), Ledger(contender.budget)
    policy = new_policy(params, contender.budget, outlook)
    rows = []
    for number, one in enumerate(outcomes):
        now_s = number * INTERVAL_S
        case = replace(one.case, enough=one.passes[contender.scale])
        calls, refused = 0, False
        if policy.decide(case, now_s).ask:
            try:
                ticket = ledger.reserve(outlook.dearest(THING, contender.budget), now_s)
            except OverBudgetError:
                refused = True
            else:
                calls, cost = one.calls, Cost(calls=one.calls)
                ledger.settle(ticket, cost, now_s)
                policy.spend(cost, now_s)
                outlook.paid(THING, cost)
                outlook.told(case.kind, changed=one.changed)
        rows.append((calls, one.reasoned_right if calls else one.fast_right, refused))
    return rows
