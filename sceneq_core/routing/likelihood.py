"""How well words fit each instance: which one is meant, and is there such a thing at all?

Which one: s_i = cos(instance_i, words), p = softmax(s / T) over the instances. The instance's mean
cosine with the label set is taken from s_i: a descriptor that is close to every text (a wall, a
blurred crop) would else win every question.
Is there such a thing: for each instance the words compete with the label set.
"""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Bool, Float32, Float64, Int64
from sceneq_core.encoding.colour import COLOUR_TERMS
from sceneq_core.mapping.delta import OBJECT
from sceneq_core.routing.gate import log_softmax
from sceneq_core.routing.question import TextTower, Wanted
from sceneq_core.routing.scene import SceneSnapshot

VAGUE = ("object", "things", "stuff", "texture")
"""Words for anything, which always compete: with a label set of one, p would else be 1 for all.

J. Kerr et al., LERF, ICCV 2023, DOI 10.1109/ICCV51070.2023.01807, calls them canonical phrases.
"""

FIXED_TEXTS = (*COLOUR_TERMS, *VAGUE)
"""What is encoded once, whatever the questions."""


LOOKED_AT = 10
"""Of how many best instances the presence is worked out: p(words | instance) of the others, which
nobody would be shown first, is not worth their softmax over the label set."""


@dataclass(frozen=True, slots=True)
class Fit:
    """How words fit the N instances of a snapshot.

    Only instances of the role that is meant count: floor and walls are not objects, and not asked
    of the encoder. ``order`` leaves the others out, their ``p`` is 0.

    ``p`` (N,) is the probability that an instance is meant, given that one is; ``cosine`` (N,) the
    mean cosine with the words; ``order`` (M,) the rows, best first. ``presence`` is the highest
    p(words | instance) of the best ones, ``chance`` what it would be if the encoder knew nothing.
    """

    p: Float64
    cosine: Float64
    order: Int64
    presence: float
    chance: float


class Likelihood:
    """Compares words with instances by softmax(s / T); colours count as independent of nouns."""

    def __init__(self, tower: TextTower, temperature: float, ceiling: float) -> None:
        self._colour_vectors = tower.encode(COLOUR_TERMS)
        self._vague_vectors = tower.encode(VAGUE)
        self._temperature = temperature
        self._ceiling = ceiling

    def fit(self, snapshot: SceneSnapshot, wanted: Wanted) -> Fit:
        """Return how well the words fit every instance; there must be at least one."""
        asked = list(wanted.colours)
        noun, common = self._noun_cosine(snapshot, wanted)
        colour = snapshot.descriptors @ self._colour_vectors.T
        log_colour = self._log_p(colour)[:, asked].sum(axis=1)
        roles = np.array([one.geometry.role for one in snapshot.instances], np.str_)
        meant = roles == OBJECT
        if wanted.role != OBJECT and (roles == wanted.role).any():
            return self._fit_structure(snapshot, roles == wanted.role, noun, log_colour)
        log_fit = (noun - common).astype(np.float64) / self._temperature + log_colour
        log_fit[~meant] = -np.inf
        order = np.argsort(-log_fit, kind="stable")[: meant.sum()]
        best = order[:LOOKED_AT]
        rivals = self._rivals(snapshot, wanted, best)
        log_noun = self._log_p(np.column_stack([noun[best], rivals]))[:, 0]
        return Fit(
            p=np.exp(log_softmax(log_fit)) if meant.any() else np.zeros(len(meant)),
            cosine=np.column_stack([noun, colour[:, asked]]).mean(axis=1).astype(np.float64),
            order=order,
            presence=min(
                float(np.exp(log_noun + log_colour[best]).max(initial=0.0)), self._ceiling
            ),
            chance=1.0 / (1 + rivals.shape[1]) / len(COLOUR_TERMS) ** len(asked),
        )

    def _fit_structure(
        self, snapshot: SceneSnapshot, meant: Bool, cosine: Float32, log_colour: Float64
    ) -> Fit:
        """Return the fit of a part of the building: the map knows it, the larger the likelier."""
        voxels = np.array([one.geometry.voxel_count for one in snapshot.instances], np.float64)
        log_fit = np.where(meant, np.log(np.maximum(voxels, 1.0)) + log_colour, -np.inf)
        return Fit(
            p=np.exp(log_softmax(log_fit)),
            cosine=cosine.astype(np.float64),
            order=np.argsort(-log_fit, kind="stable")[: meant.sum()],
            presence=self._ceiling * float(np.exp(log_colour[meant].max())),
            chance=0.0,
        )

    def _rivals(self, snapshot: SceneSnapshot, wanted: Wanted, rows: Int64) -> Float32:
        """Return the cosines of ``rows`` with everything the noun competes with."""
        labels = snapshot.label_scores[rows][:, wanted.rivals]
        return np.column_stack([labels, snapshot.descriptors[rows] @ self._vague_vectors.T])

    def _log_p(self, cosine: Float32) -> Float64:
        return log_softmax(cosine.astype(np.float64) / self._temperature)

    def _noun_cosine(self, snapshot: SceneSnapshot, wanted: Wanted) -> tuple[Float32, Float32]:
        """Return the cosines (N,) with the noun and, on average, with the label set.

        "Anything" is equally close to all.
        """
        if wanted.vector is None:
            nothing = np.zeros(len(snapshot), np.float32)
            return nothing, nothing
        return snapshot.descriptors @ wanted.vector, snapshot.label_scores.mean(axis=1)
