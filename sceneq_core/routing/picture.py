"""A picture as the question: which instance looks like it?

Which one: p = softmax(s / T) over the instances, s the cosine of picture and instance, less the
instance's mean cosine with the label set as for words. Is it such a thing at all: the probability
that picture and instance are called the same, sum over labels of p(label | picture) times
p(label | instance). No picture is like its own label set, so words cannot compete here.
"""

import numpy as np

from sceneq_core.arrays import Float32, Float64
from sceneq_core.mapping.delta import OBJECT
from sceneq_core.routing.answer import AMBIGUOUS, FAST, FOUND, NOT_FOUND, Answer, Match
from sceneq_core.routing.gate import Confidence, log_softmax
from sceneq_core.routing.judge import Judge, hesitation
from sceneq_core.routing.labels import Labeller
from sceneq_core.routing.matches import MAX_MATCHES
from sceneq_core.routing.scene import SceneSnapshot


class PictureMatcher:
    """Ranks instances by how much they look like a picture."""

    def __init__(self, labeller: Labeller, judge: Judge, temperature: float) -> None:
        self._labeller = labeller
        self._judge = judge
        self._temperature = temperature

    def answer(self, snapshot: SceneSnapshot, descriptor: Float32) -> Answer:
        """Return the instances like a picture with this ``descriptor`` (D,), L2-normalised."""
        objects = np.flatnonzero(snapshot.columns.role == OBJECT)
        cosine = (snapshot.descriptors @ descriptor)[objects].astype(np.float64)
        common = snapshot.columns.label_mean[objects]
        p = np.exp(log_softmax((cosine - common) / self._temperature))
        order = np.argsort(-p, kind="stable")[:MAX_MATCHES]
        rows = objects[order]
        confidence = Confidence.of(p, self._temperature)
        alike = self._called_the_same(snapshot, descriptor, int(rows[0])) if len(rows) else 0.0
        status, reason = self._judge_likeness(confidence, alike)
        return Answer(
            status=status,
            question="picture",
            matches=tuple(
                Match(snapshot.instances[row], float(p[i]), float(cosine[i]))
                for row, i in zip(rows, order, strict=True)
            ),
            confidence=confidence,
            presence=alike,
            route=FAST,
            reason=reason,
            vlm_calls=0,
            revision=snapshot.revision,
        )

    def _judge_likeness(self, confidence: Confidence, alike: float) -> tuple[str, str]:
        shown = f"picture and instance are called the same with p {alike:.2f}"
        if alike < 1.0 / len(self._labeller.label_set):
            return NOT_FOUND, f"nothing looks like that: {shown}"
        if not self._judge.accepts(confidence):
            return AMBIGUOUS, f"{hesitation(confidence)}; {shown}"
        sure = self._judge.claims(alike)
        return (FOUND if sure else AMBIGUOUS), f"one instance looks most like it; {shown}"

    def _called_the_same(self, snapshot: SceneSnapshot, descriptor: Float32, row: int) -> float:
        seen, known = (
            self._names(scores)
            for scores in (self._labeller.scores(descriptor[None])[0], snapshot.label_scores[row])
        )
        return float(seen @ known)

    def _names(self, scores: Float32) -> Float64:
        return self._labeller.distribution(scores)
