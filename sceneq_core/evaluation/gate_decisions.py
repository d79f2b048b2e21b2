"""How good the gate's decisions are: the fast path should be taken exactly when it is right."""

from dataclasses import dataclass, fields, replace

import numpy as np

from sceneq_core.arrays import Bool, Float64
from sceneq_core.routing.gate import GateParams


@dataclass(frozen=True, slots=True, eq=False)
class Decisions:
    """What the gate sees of N first guesses, each (N,), and whether the guess is ``right``."""

    p_max: Float64
    margin: Float64
    entropy_norm: Float64
    right: Bool

    def __post_init__(self) -> None:
        lengths = {len(getattr(self, field.name)) for field in fields(self)}
        if len(lengths) > 1:
            raise ValueError(f"decisions: columns of different length: {sorted(lengths)}")

    def __len__(self) -> int:
        return len(self.right)

    def accepted(self, gate: GateParams) -> Bool:
        """Return which guesses (N,) the gate lets pass."""
        return np.asarray(gate.passes(self.p_max, self.margin, self.entropy_norm), np.bool_)


@dataclass(frozen=True, slots=True)
class F1:
    """``precision``: right among the accepted; ``recall``: accepted among the right.

    ``f1`` is their harmonic mean, 0 when no right guess is accepted; ``accepted`` the share of all.
    """

    f1: float
    precision: float
    recall: float
    accepted: float


def f1_of(accepted: Bool, right: Bool) -> F1:
    """Return how well ``accepted`` (N,) agrees with being ``right`` (N,)."""
    both, taken, good = int((accepted & right).sum()), int(accepted.sum()), int(right.sum())
    return F1(
        f1=2 * both / (taken + good) if taken + good else 0.0,
        precision=both / taken if taken else 0.0,
        recall=both / good if good else 0.0,
        accepted=taken / len(right) if len(right) else 0.0,
    )


@dataclass(frozen=True, slots=True)
class Nudged:
    """What F1 becomes when one threshold is scaled by ``factor``."""

    threshold: str
    value: float
    factor: float
    score: F1


def sensitivity(
    decisions: Decisions, gate: GateParams, factors: tuple[float, ...] = (0.9, 1.0, 1.1)
) -> tuple[Nudged, ...]:
    """Return F1 with each threshold scaled by each factor, the others as they are; at most 1."""
    table = []
    for name in (field.name for field in fields(gate)):
        for factor in factors:
            value = min(getattr(gate, name) * factor, 1.0)
            accepted = decisions.accepted(replace(gate, **{name: value}))
            table.append(Nudged(name, value, factor, f1_of(accepted, decisions.right)))
    return tuple(table)
