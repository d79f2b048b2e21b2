"""How probable words are for each instance, with the label set as what it could be instead.

An instance whose descriptor is close to every text (a wall, a blurred crop) would win every
question on the cosine alone. Here the words compete with the label set for each instance, so such
an instance has little to give to any of them. Over instances, p(instance | words) is proportional
to this p(words | instance).
"""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Float32, Float64
from sceneq_core.encoding.colour import COLOUR_TERMS
from sceneq_core.routing.gate import log_softmax
from sceneq_core.routing.question import TextTower, Wanted
from sceneq_core.routing.scene import SceneSnapshot

VAGUE = ("object", "things", "stuff", "texture")
"""Words for anything, which always compete: with a label set of one, p would else be 1 for all.

J. Kerr et al., LERF, ICCV 2023, DOI 10.1109/ICCV51070.2023.01807, calls them canonical phrases.
"""


@dataclass(frozen=True, slots=True)
class Fit:
    """How words fit the N instances of a snapshot.

    ``likelihood`` (N,) is p(words | instance), ``cosine`` (N,) the mean cosine with the words,
    ``chance`` the likelihood if the encoder knew nothing.
    """

    likelihood: Float64
    cosine: Float64
    chance: float

    @property
    def p(self) -> Float64:
        """Return p(instance | words) (N,), every instance equally probable beforehand."""
        total = self.likelihood.sum()
        uniform = np.full(len(self.cosine), 1.0 / max(1, len(self.cosine)))
        return self.likelihood / total if total > 0 else uniform

    @property
    def presence(self) -> float:
        """The likelihood of the best instance: is there such a thing at all?"""
        return float(self.likelihood.max(initial=0.0))

    @property
    def order(self) -> list[int]:
        """Rows, best first; equals by cosine, then by id."""
        return [int(row) for row in np.lexsort((-self.cosine, -self.likelihood))]


class Likelihood:
    """Compares words with instances by softmax(s / T); colours count as independent of nouns."""

    def __init__(self, tower: TextTower, temperature: float) -> None:
        self._colour_vectors = tower.encode(COLOUR_TERMS)
        self._vague_vectors = tower.encode(VAGUE)
        self._temperature = temperature

    def fit(self, snapshot: SceneSnapshot, wanted: Wanted) -> Fit:
        """Return how well the words fit every instance."""
        rivals = np.column_stack(
            [snapshot.label_scores[:, wanted.rivals], snapshot.descriptors @ self._vague_vectors.T]
        )
        noun = _noun_cosine(snapshot, wanted)
        colour = snapshot.descriptors @ self._colour_vectors.T
        asked = list(wanted.colours)
        log_p = self._log_p(np.column_stack([noun, rivals]))[:, 0]
        log_p = log_p + self._log_p(colour)[:, asked].sum(axis=1)
        return Fit(
            likelihood=np.exp(log_p),
            cosine=np.column_stack([noun, colour[:, asked]]).mean(axis=1).astype(np.float64),
            chance=1.0 / (1 + rivals.shape[1]) / len(COLOUR_TERMS) ** len(asked),
        )

    def _log_p(self, cosine: Float32) -> Float64:
        return log_softmax(cosine.astype(np.float64) / self._temperature)


def _noun_cosine(snapshot: SceneSnapshot, wanted: Wanted) -> Float32:
    """Return the cosine (N,) with the noun; "anything" is equally close to all."""
    if wanted.vector is None:
        return np.zeros(len(snapshot), np.float32)
    return snapshot.descriptors @ wanted.vector
