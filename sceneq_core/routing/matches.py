"""The instances of an answer, best first, with why they may be meant."""

from collections.abc import Iterable

from sceneq_core.reasoning.reasoner import Problem
from sceneq_core.routing.answer import Match
from sceneq_core.routing.likelihood import Fit
from sceneq_core.routing.scene import SceneSnapshot

MAX_MATCHES = 50


def matches_of_fit(snapshot: SceneSnapshot, fit: Fit, p_null: float) -> tuple[Match, ...]:
    """Return the encoder's best, best first; ``p_null`` is what is left to "none of them"."""
    rows = fit.order[:MAX_MATCHES]
    p = (1.0 - p_null) * fit.p[rows]
    values = zip(rows.tolist(), p.tolist(), fit.cosine[rows].tolist(), strict=True)
    return tuple(Match(snapshot.instances[row], p, cosine) for row, p, cosine in values)


def matches_of_ranking(
    snapshot: SceneSnapshot, problem: Problem | None, ranking: Iterable[tuple[int, float]]
) -> Iterable[Match]:
    """Yield the matches of a ranking, evidence and cosine from the problem it solves.

    Raises:
        ValueError: an instance that was not among the candidates.
    """
    targets = [c for c in problem.candidates if c.role == "target"] if problem else []
    cosine = {c.instance_id: c.cosine for c in targets}
    for instance_id, p in ranking:
        row = snapshot.find(instance_id)
        if row is None or instance_id not in cosine:
            raise ValueError(f"verdict: instance {instance_id} was not a candidate")
        yield Match(snapshot.instances[row], p, cosine[instance_id])
