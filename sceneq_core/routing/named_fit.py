"""What a taught name adds to what the encoder says."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from sceneq_core.arrays import Float64, Int64
from sceneq_core.routing.answer import AMBIGUOUS, FOUND
from sceneq_core.routing.gate import Confidence
from sceneq_core.routing.judge import Judge, hesitation
from sceneq_core.routing.likelihood import Fit
from sceneq_core.routing.names import GivenName


def with_name(fit: Fit, given: GivenName) -> Fit:
    """Return ``fit`` for words that are a taught name; the same where the name means nothing.

    A name that holds with p leaves 1 - p to what is alike, and that what is left to the encoder:
    p' ~ p_name + (1 - max p_name) (p_alike + (1 - max p_alike) p).
    """
    if not given.p:
        return fit
    rows = [*given.p, *given.maybe]
    named, alike = _spread(given.p, len(fit.p)), _spread(given.maybe, len(fit.p))
    surest = float(named.max())
    p = named + (1.0 - surest) * (alike + (1.0 - alike.max()) * fit.p)
    known = set(fit.order.tolist())
    order = np.concatenate([fit.order, np.array([r for r in rows if r not in known], np.int64)])
    return replace(
        fit,
        p=p / p.sum(),
        kind=with_name_each(fit.kind, np.arange(len(p)), given),
        order=order[np.argsort(-p[order], kind="stable")],
        presence=max(fit.presence, surest),
    )


def with_name_each(p: Float64, rows: Int64, given: GivenName) -> Float64:
    """Return p (M,) of ``rows`` (M,), each judged by itself: by the name as far as that holds."""
    if not given.p:
        return p
    told = {**given.maybe, **given.p}
    named = np.array([told.get(row, 0.0) for row in rows.tolist()])
    each: Float64 = np.minimum(named + (1.0 - max(given.p.values())) * p, 1.0)
    return each


def _spread(p: Mapping[int, float], count: int) -> Float64:
    """Return p (N,) of all rows, 0 where nothing is said."""
    spread = np.zeros(count)
    spread[list(p)] = list(p.values())
    return spread


def judged_by_name(
    given: GivenName, judge: Judge, confidence: Confidence, otherwise: tuple[str, str]
) -> tuple[str, str]:
    """Return status and reason when a question speaks a taught name.

    ``otherwise`` is what the encoder says, which counts where the name means nothing in this map.
    """
    if not given.p:
        status, reason = otherwise
        return status, f"{reason}; {given.reason}"
    if judge.accepts(confidence):
        return FOUND, given.reason
    return AMBIGUOUS, f"{given.reason}; {hesitation(confidence)}"
