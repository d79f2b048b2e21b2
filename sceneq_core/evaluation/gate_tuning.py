"""Thresholds of the gate for the best F1, on data that is not used to measure it."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Bool, Float64
from sceneq_core.evaluation.gate_decisions import Decisions
from sceneq_core.routing.gate import GateParams

STEPS = 14
DIGITS = 3
"""More digits of a threshold would only describe the data it was tuned on."""


@dataclass(frozen=True, slots=True, eq=False)
class _Choices:
    """Values (V,) that a threshold may take, which guesses pass each (V, N), and how far from
    where it was each is (V,)."""

    value: Float64
    passes: Bool
    moved: Float64


@dataclass(frozen=True, slots=True, order=True)
class _Rank:
    """What makes one choice better than another, most important first."""

    f1: float
    precision: float
    stayed: float


def tune_gate(
    decisions: Decisions, otherwise: GateParams, least_p: float = 0.0, steps: int = STEPS
) -> GateParams:
    """Return the thresholds with the best F1; ``otherwise`` when no first guess is right.

    ``min_p`` will be at least ``least_p``: what no claim is made below.

    An exhaustive search: every threshold takes its value in ``otherwise``, one that lets all pass,
    and ``steps`` ones half-way between measures that occurred, spread over their quantiles. Of
    equal F1 the better precision wins (bold only where it pays), then what is nearest to
    ``otherwise``: no threshold moves without a reason.
    """
    if not decisions.right.any():
        return otherwise
    p = _at_least(decisions.p_max, otherwise.min_p, steps, least_p)
    margin = _at_least(decisions.margin, otherwise.min_margin, steps)
    clear = _at_least(decisions.margin, otherwise.clear_margin, steps)
    entropy = _at_most(decisions.entropy_norm, otherwise.max_entropy_norm, steps)
    either = entropy.passes[:, None] | clear.passes[None]
    apart = entropy.moved[:, None] + clear.moved[None]
    best, gate = _Rank(-1.0, 0.0, 0.0), otherwise
    for i, j in np.ndindex(len(p.value), len(margin.value)):
        accepted = either & (p.passes[i] & margin.passes[j])
        rank, (e, c) = _best(accepted, decisions.right, apart + p.moved[i] + margin.moved[j])
        if rank > best:
            limits = (p.value[i], margin.value[j], entropy.value[e], clear.value[c])
            best, gate = rank, GateParams(*map(float, limits))
    return gate


def _best(accepted: Bool, right: Bool, moved: Float64) -> tuple[_Rank, tuple[int, int]]:
    """Return the rank of the best of decisions (E, C, N), and which it is."""
    both, taken = (accepted & right).sum(axis=2), accepted.sum(axis=2)
    f1 = 2 * both / (taken + right.sum())
    precision = both / np.maximum(taken, 1)
    first = int(np.lexsort((moved.ravel(), -precision.ravel(), -f1.ravel()))[0])
    e, c = divmod(first, f1.shape[1])
    return _Rank(float(f1[e, c]), float(precision[e, c]), -float(moved[e, c])), (e, c)


def _at_least(measure: Float64, otherwise: float, steps: int, least: float = 0.0) -> _Choices:
    value = np.unique(np.maximum(_values(measure, otherwise, 0.0, steps), least))
    return _Choices(value, measure >= value[:, None], np.abs(value - otherwise))


def _at_most(measure: Float64, otherwise: float, steps: int) -> _Choices:
    value = _values(measure, otherwise, 1.0, steps)
    return _Choices(value, measure <= value[:, None], np.abs(value - otherwise))


def _values(measure: Float64, otherwise: float, open_at: float, steps: int) -> Float64:
    """Return the values to try, sorted."""
    distinct = np.unique(measure)
    between = (distinct[1:] + distinct[:-1]) / 2
    places = np.unique(np.linspace(0, max(len(between) - 1, 0), steps).round().astype(np.int64))
    spread = between[places] if len(between) else between
    rounded = np.clip(np.round(spread, DIGITS), 0.0, 1.0)
    return np.unique(np.concatenate(([open_at, otherwise], rounded)))
