"""How well words fit each instance: which one is meant, and is there such a thing at all?

Which one: s_i = cos(instance_i, words), p = softmax(s / T) over the instances. The instance's mean
cosine with the label set is taken from s_i: a descriptor that is close to every text (a wall, a
blurred crop) would else win every question.
Is there such a thing: for each instance the words compete with the label set, and a calibration
says how probable that makes it (``sceneq_core.routing.null``).
"""

from dataclasses import dataclass, replace

import numpy as np

from sceneq_core.arrays import Bool, Float32, Float64, Int64
from sceneq_core.encoding.colour import COLOUR_TERMS
from sceneq_core.mapping.delta import OBJECT
from sceneq_core.routing.attribute_fit import log_excluded, log_size
from sceneq_core.routing.gate import log_softmax
from sceneq_core.routing.null import NO_EVIDENCE, Evidence, NullParams, evidence_of
from sceneq_core.routing.question import TextTower, Wanted
from sceneq_core.routing.scene import SceneSnapshot
from sceneq_core.routing.sureness import Sureness

VAGUE = ("object", "things", "stuff", "texture")
"""Words for anything, which always compete: with a label set of one, p would else be 1 for all.

J. Kerr et al., LERF, ICCV 2023, DOI 10.1109/ICCV51070.2023.01807, calls them canonical phrases.
"""

FIXED_TEXTS = (*COLOUR_TERMS, *VAGUE)
"""What is encoded once, whatever the questions."""


LOOKED_AT = 50
"""Of how many best instances p(words | instance) is worked out: the others, which no reasoner is
shown, are not worth their softmax over the label set."""


@dataclass(frozen=True, slots=True)
class Fit:
    """How words fit the N instances of a snapshot.

    Only instances of the role that is meant count: floor and walls are not objects, and not asked
    of the encoder. ``order`` leaves the others out, their ``p`` is 0.

    ``p`` (N,) is the probability that an instance is meant, given that one is; ``kind`` (N,) is
    p(words | instance), that it is such a thing, of the best ones, 0 of the others: of four lamps
    that all are one, the most typical is not the likelier to be the one beside the sofa.
    ``cosine`` (N,) is the mean cosine with the words; ``order`` (M,) the rows, best first.
    ``presence`` is the probability that there is such a thing when ``calibrated``; else the highest
    ``kind``, and ``chance`` what it would be if the encoder knew nothing. ``evidence`` is what a
    calibration judges presence by.
    """

    p: Float64
    kind: Float64
    cosine: Float64
    order: Int64
    presence: float
    chance: float
    evidence: Evidence
    calibrated: bool = False

    @property
    def p_null(self) -> float:
        """The probability that nothing is meant; 0 where no calibration tells."""
        return 1.0 - self.presence if self.calibrated else 0.0


class Likelihood:
    """Compares words with instances by softmax(s / T); colours count as independent of nouns."""

    def __init__(
        self,
        tower: TextTower,
        temperature: float,
        ceiling: float,
        null: NullParams | None = None,
        null_described: NullParams | None = None,
        sureness_described: Sureness | None = None,
    ) -> None:
        """``null_described`` is for words that describe, ``None`` = as for names.

        So is ``sureness_described``, ``None`` = as the softmax says.
        """
        self._vague_vectors = tower.encode(VAGUE)
        self._temperature = temperature
        self._ceiling = ceiling
        self._null = null
        self._null_described = null_described or null
        self._sureness_described = sureness_described or Sureness()

    def fit(self, snapshot: SceneSnapshot, wanted: Wanted) -> Fit:
        """Return how well the words fit every instance; there must be at least one."""
        fit = self._fit(snapshot, wanted)
        if wanted.described and wanted.vector is not None and fit.calibrated:
            return _as_sure(fit, self._sureness_described)
        return fit

    def _fit(self, snapshot: SceneSnapshot, wanted: Wanted) -> Fit:
        asked = list(wanted.colours)
        noun, common = self._noun_cosine(snapshot, wanted)
        colour = snapshot.columns.colour_scores
        log_colour = self._log_colours(colour, wanted)
        roles = snapshot.columns.role
        meant = roles == OBJECT
        if wanted.role != OBJECT and (roles == wanted.role).any():
            return self._fit_structure(snapshot, roles == wanted.role, noun, log_colour)
        log_fit = (noun - common).astype(np.float64) / self._temperature + log_colour
        log_fit[~meant] = -np.inf
        fitting = log_size(snapshot, wanted.sizes, log_fit) if wanted.sizes else np.zeros(len(noun))
        log_fit = log_fit + fitting
        order = np.argsort(-log_fit, kind="stable")[: meant.sum()]
        best = order[:LOOKED_AT]
        rivals = self._rivals(snapshot, wanted, best)
        choices = 1 + rivals.shape[1]
        log_said = log_colour + fitting
        null = self._null_of(wanted)
        log_name = self._log_name(noun[best], rivals, self._evidence_temperature(null))
        p = np.exp(log_softmax(log_fit)) if meant.any() else np.zeros(len(meant))
        seen = evidence_of(log_name, log_said[best], float(p.max()), choices, len(order))
        kind = np.exp(log_said) * meant
        if wanted.vector is not None:
            kind[order[LOOKED_AT:]] = 0.0
            kind[best] *= np.exp(self._log_name(noun[best], rivals, self._temperature))
        return Fit(
            p=p,
            kind=kind,
            cosine=np.column_stack([noun, colour[:, asked]]).mean(axis=1).astype(np.float64),
            order=order,
            presence=self._presence(wanted, log_name, log_said[best], seen, null),
            chance=1.0 / choices / len(COLOUR_TERMS) ** len(asked) / 2 ** len(wanted.sizes),
            evidence=seen,
            calibrated=self._null is not None,
        )

    def each(self, snapshot: SceneSnapshot, wanted: Wanted, rows: Int64) -> Float64:
        """Return the probability (M,) of each instance in ``rows`` that it is such a thing.

        A coffee table is a table, too: what labels call a kind of it counts, and competes no more.
        That a room has something to sit on says nothing of any one thing in it: each is judged as
        a name is, whatever the words.
        """
        colour = snapshot.columns.colour_scores
        log_colour = self._log_colours(colour, wanted)
        log_said = log_colour
        if wanted.vector is None:
            anything: Float64 = np.exp(log_said[rows])
            return anything
        if wanted.role != OBJECT:
            found: Float64 = np.exp(log_said[rows]) * (snapshot.columns.role[rows] == wanted.role)
            return found
        noun, common = self._noun_cosine(snapshot, wanted)
        log_fit = (noun - common).astype(np.float64) / self._temperature
        if wanted.sizes:
            log_said = log_said + log_size(snapshot, wanted.sizes, log_fit)
        rivals = self._rivals(snapshot, replace(wanted, rivals=wanted.rivals & ~wanted.kinds), rows)
        kinds = snapshot.label_scores[rows][:, wanted.kinds]
        so_called = np.column_stack([noun[rows], kinds]).max(axis=1)
        log_name = self._log_name(so_called, rivals, self._evidence_temperature(self._null))
        log_said = log_said[rows]
        log_fit += log_colour
        p, sizes = np.exp(log_softmax(log_fit))[rows], (1 + rivals.shape[1], len(snapshot))
        ones = [(log_name[i : i + 1], log_said[i : i + 1]) for i in range(len(rows))]
        seen = [evidence_of(*one, float(p[i]), *sizes) for i, one in enumerate(ones)]
        return np.array(
            [
                self._presence(wanted, *one, what, self._null)
                for one, what in zip(ones, seen, strict=True)
            ]
        )

    def _log_colours(self, cosine: Float32, wanted: Wanted) -> Float64:
        """Return log p (M,) of the colours said, and of none of those excluded.

        ``cosine`` (M, 11) is that with the colours.
        """
        if not wanted.colours and not wanted.excluded:
            return np.zeros(len(cosine))
        log_p = log_softmax(cosine.astype(np.float64) / self._temperature)
        said: Float64 = log_p[:, list(wanted.colours)].sum(axis=1)
        return said + log_excluded(log_p, wanted.excluded)

    def _log_name(self, noun: Float32, rivals: Float32, temperature: float) -> Float64:
        """Return log p(noun | instance) (M,) from cosines (M,) and those of its rivals (M, R)."""
        cosines = np.column_stack([noun, rivals]).astype(np.float64)
        log_name: Float64 = log_softmax(cosines / temperature)[:, 0]
        return log_name

    def _fit_structure(
        self, snapshot: SceneSnapshot, meant: Bool, cosine: Float32, log_colour: Float64
    ) -> Fit:
        """Return the fit of a part of the building: the map knows it, the larger the likelier."""
        voxels = np.maximum(snapshot.columns.voxel_count, 1.0)
        log_fit = np.where(meant, np.log(voxels) + log_colour, -np.inf)
        coloured = float(log_colour[meant].max())
        p = np.exp(log_softmax(log_fit))
        return Fit(
            p=p,
            kind=p,
            cosine=cosine.astype(np.float64),
            order=np.argsort(-log_fit, kind="stable")[: meant.sum()],
            presence=float(np.exp(coloured)) * (1.0 if self._null else self._ceiling),
            chance=0.0,
            evidence=NO_EVIDENCE,
            calibrated=self._null is not None,
        )

    def _presence(
        self,
        wanted: Wanted,
        log_name: Float64,
        log_said: Float64,
        seen: Evidence,
        null: NullParams | None,
    ) -> float:
        """Return the presence from log p of the best (M,), and the evidence in it.

        Where there is no name, what is said decides alone.
        """
        if wanted.vector is None:
            said = float(np.exp(log_said).max(initial=0.0))
            alone = not (wanted.colours or wanted.excluded or wanted.sizes)
            return said if alone or self._null is not None else min(said, self._ceiling)
        if null is None:
            best = np.exp(log_name + log_said).max(initial=0.0)
            return min(float(best), self._ceiling)
        return null.presence(seen)

    def _null_of(self, wanted: Wanted) -> NullParams | None:
        return self._null_described if wanted.described else self._null

    def _evidence_temperature(self, null: NullParams | None) -> float:
        return null.temperature if null else self._temperature

    def _rivals(self, snapshot: SceneSnapshot, wanted: Wanted, rows: Int64) -> Float32:
        """Return the cosines of ``rows`` with everything the noun competes with."""
        labels = snapshot.label_scores[rows][:, wanted.rivals]
        return np.column_stack([labels, snapshot.descriptors[rows] @ self._vague_vectors.T])

    def _noun_cosine(self, snapshot: SceneSnapshot, wanted: Wanted) -> tuple[Float32, Float32]:
        """Return the cosines (N,) with the noun and, on average, with the label set.

        "Anything" is equally close to all.
        """
        if wanted.vector is None:
            nothing = np.zeros(len(snapshot), np.float32)
            return nothing, nothing
        return snapshot.descriptors @ wanted.vector, snapshot.columns.label_mean


def _as_sure(fit: Fit, sureness: Sureness) -> Fit:
    """Return a fit whose first guess, of all instances and none of them, is as sure as it is."""
    sure = sureness.of(np.append(fit.presence * fit.p, 1.0 - fit.presence))
    there = float(sure[:-1].sum())
    return replace(fit, p=sure[:-1] / there if there > 0.0 else fit.p, presence=there)
