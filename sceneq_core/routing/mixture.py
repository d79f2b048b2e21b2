"""Two likelihoods, for familiar scenes and for unfamiliar ones, weighed by how a scene looks.

A mixture of experts whose gate is the familiarity of the scene (R. Jacobs et al., "Adaptive
mixtures of local experts", Neural Computation 1991, DOI 10.1162/neco.1991.3.1.79).
"""

from dataclasses import replace
from typing import Protocol

import numpy as np

from sceneq_core.arrays import Float64, Int64
from sceneq_core.routing.likelihood import Fit
from sceneq_core.routing.question import Wanted
from sceneq_core.routing.scene import SceneSnapshot
from sceneq_core.routing.unfamiliar import Unfamiliar, scene_familiarity

NEGLIGIBLE = 1e-3
"""Who counts less than this is not asked: most scenes are plainly familiar or not."""


class Fitting(Protocol):
    """How well words fit instances; both methods as those of ``Likelihood``."""

    def fit(self, snapshot: SceneSnapshot, wanted: Wanted) -> Fit:
        """Return how well the words fit every instance."""

    def each(self, snapshot: SceneSnapshot, wanted: Wanted, rows: Int64) -> Float64:
        """Return the probability (M,) of each instance in ``rows`` that it is such a thing."""


class Mixture:
    """``familiar`` where the scene looks like what the encoder was taught with, else as fitted
    where it does not."""

    def __init__(self, familiar: Fitting, unfamiliar: Fitting, weigh: Unfamiliar) -> None:
        self._familiar = familiar
        self._unfamiliar = unfamiliar
        self._share = weigh.share

    def fit(self, snapshot: SceneSnapshot, wanted: Wanted) -> Fit:
        """Return how well the words fit every instance; there must be at least one."""
        share = self._share(scene_familiarity(snapshot.columns))
        if share < NEGLIGIBLE:
            return self._familiar.fit(snapshot, wanted)
        return mixed(
            self._familiar.fit(snapshot, wanted), self._unfamiliar.fit(snapshot, wanted), share
        )

    def each(self, snapshot: SceneSnapshot, wanted: Wanted, rows: Int64) -> Float64:
        """Return the probability (M,) of each instance in ``rows`` that it is such a thing."""
        share = self._share(scene_familiarity(snapshot.columns))
        if share < NEGLIGIBLE:
            return self._familiar.each(snapshot, wanted, rows)
        if share > 1.0 - NEGLIGIBLE:
            return self._unfamiliar.each(snapshot, wanted, rows)
        familiar = self._familiar.each(snapshot, wanted, rows)
        return familiar + share * (self._unfamiliar.each(snapshot, wanted, rows) - familiar)


def mixed(one: Fit, other: Fit, share: float) -> Fit:
    """Return the mixture of two fits to the same instances, ``share`` of it the other.

    Mixed are the probabilities of all instances and of none of them; ``evidence`` is that of one.
    ``kind``, by which a reasoner chooses among instances that geometry allows, stays at least half
    that of one: which is likelier than which needs no caution (docs/adr/0032).
    """
    meant = (1.0 - share) * one.presence * one.p + share * other.presence * other.p
    there = (1.0 - share) * one.presence + share * other.presence
    p = meant / there if there > 0.0 else one.p
    return replace(
        one,
        p=p,
        kind=(1.0 - share / 2.0) * one.kind + share / 2.0 * other.kind,
        order=one.order[np.argsort(-p[one.order], kind="stable")],
        presence=there,
    )
