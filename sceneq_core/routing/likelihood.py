"""How probable words are for each instance, with the label set as what it could be instead.

An instance whose descriptor is close to every text (a wall, a blurred crop) would win every
question on the cosine alone. Here the words compete with the label set for each instance, so such
an instance has little to give to any of them. Over instances, p(instance | words) is proportional
to this p(words | instance).
"""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Float32, Float64
from sceneq_core.routing.gate import log_softmax
from sceneq_core.routing.question import Wanted
from sceneq_core.routing.scene import SceneSnapshot


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


def fit(
    snapshot: SceneSnapshot, wanted: Wanted, colour_vectors: Float32, temperature: float
) -> Fit:
    """Compare words with every instance; colours count as independent of the noun.

    ``colour_vectors`` float32 (11, D) are the basic terms; softmax(s / T) uses ``temperature``.
    """
    noun = _noun_cosine(snapshot, wanted)
    colour = (snapshot.descriptors @ colour_vectors.T).astype(np.float64)
    rivals = snapshot.label_scores[:, wanted.rivals].astype(np.float64)
    log_p = log_softmax(np.column_stack([noun, rivals]) / temperature)[:, 0]
    asked = list(wanted.colours)
    log_p = log_p + log_softmax(colour / temperature)[:, asked].sum(axis=1)
    return Fit(
        likelihood=np.exp(log_p),
        cosine=np.column_stack([noun, colour[:, asked]]).mean(axis=1),
        chance=1.0 / (1 + rivals.shape[1]) / len(colour_vectors) ** len(asked),
    )


def _noun_cosine(snapshot: SceneSnapshot, wanted: Wanted) -> Float64:
    """Return the cosine (N,) with the noun; "anything" is equally close to all."""
    if wanted.vector is None:
        return np.zeros(len(snapshot))
    return (snapshot.descriptors @ wanted.vector).astype(np.float64)
