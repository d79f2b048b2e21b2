"""From an instance to its name: the encoder's label, a reasoner's where asked."""

from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import replace
from threading import Lock

import numpy as np

from sceneq_core.arrays import Float32
from sceneq_core.encoding.encoder import Encoder
from sceneq_core.reasoning.reasoner import NO_USAGE, LabelProblem, LabelVerdict, Usage
from sceneq_core.routing.answer import AMBIGUOUS, FALLBACK, FOUND, REASONED, Naming
from sceneq_core.routing.gate import Confidence
from sceneq_core.routing.judge import Judge, hesitation
from sceneq_core.routing.labels import INHERITED, TAUGHT, Label, Labeller, custom
from sceneq_core.routing.named_naming import with_taught
from sceneq_core.routing.scene import SceneSnapshot

MAX_GIVEN = 200
"""Labels that a question may bring along: the text tower has to read them."""
REMEMBERED = 32
"""How many such label sets are remembered with their vectors."""

REASONER = "reasoner"


class Namer:
    """Names the instance in a row of a snapshot; the gate is the one of questions.

    ``top_k``: labels for the reasoner.
    """

    def __init__(self, labeller: Labeller, judge: Judge, temperature: float, top_k: int) -> None:
        self.labeller = labeller
        self._judge = judge
        self._temperature = temperature
        self._top_k = top_k
        self._knows_names = True

    def accepts(self, snapshot: SceneSnapshot, row: int) -> bool:
        """Return whether the gate lets the first label of the instance in ``row`` pass.

        What somebody said needs no gate; what looks like that has passed one of its own.
        """
        if snapshot.instances[row].label.source in (TAUGHT, INHERITED):
            return True
        return self._judge.accepts(self._confidence(self._scores(snapshot, row)))

    def label(self, snapshot: SceneSnapshot, row: int, k: int = 5) -> Naming:
        """Return what the instance in ``row`` is called, and whether the gate accepts it."""
        return self._with_taught(self._guess(snapshot, row, k), snapshot, row, k)

    def problem(self, snapshot: SceneSnapshot, row: int) -> LabelProblem:
        """Return the question for a reasoner what the instance in ``row`` is called."""
        best = self.labeller.best_of_scores(self._scores(snapshot, row), self._top_k)
        instance = snapshot.instances[row]
        views = tuple((view.seq, view.box_xyxy) for view in instance.views)
        labels = tuple((label.name, label.p) for label in best)
        return LabelProblem(instance.instance_id, labels, views, map_epoch=snapshot.revision.epoch)

    def conclude(
        self, snapshot: SceneSnapshot, row: int, verdict: LabelVerdict, k: int = 5
    ) -> Naming:
        """Return the reasoner's name: it has seen the thing, so its own votes carry the claim.

        Raises:
            ValueError: no label, or one that the encoder did not propose.
        """
        if not verdict.ranking:
            raise ValueError("verdict: no label")
        naming = self._guess(snapshot, row, self._top_k)
        confidence = Confidence.of(np.array([p for _, p in verdict.ranking]), self._temperature)
        cosine = {label.name: label.cosine for label in naming.labels}
        if unknown := [name for name, _ in verdict.ranking if name not in cosine]:
            raise ValueError(f"verdict: {unknown[0]!r:.40} was not proposed")
        told = replace(
            naming,
            status=FOUND if self._judge.accepts(confidence) else AMBIGUOUS,
            labels=tuple(Label(name, p, cosine[name], REASONER) for name, p in verdict.ranking[:k]),
            confidence=confidence,
            reason=verdict.reason,
            route=REASONED,
            vlm_calls=verdict.billed[0],
            usage=verdict.billed[1],
            cached=verdict.cached,
        )
        return self._with_taught(told, snapshot, row, k)

    def fall_back(
        self, naming: Naming, why: str, vlm_calls: int = 0, usage: Usage = NO_USAGE
    ) -> Naming:
        """Return the encoder's name, marked: a reasoner should have looked, but ``why``."""
        reason = f"{why}; {naming.reason}"
        return replace(naming, route=FALLBACK, reason=reason, vlm_calls=vlm_calls, usage=usage)

    def among(self, labeller: Labeller) -> "Namer":
        """Return a namer that chooses among other labels."""
        other = Namer(labeller, self._judge, self._temperature, self._top_k)
        other._knows_names = False
        return other

    def _guess(self, snapshot: SceneSnapshot, row: int, k: int) -> Naming:
        """Return what the encoder calls it."""
        scores = self._scores(snapshot, row)
        confidence = self._confidence(scores)
        accepted = self._judge.accepts(confidence)
        return Naming(
            status=FOUND if accepted else AMBIGUOUS,
            instance=snapshot.instances[row],
            labels=self.labeller.best_of_scores(scores, k),
            confidence=confidence,
            reason="the gate accepts the label" if accepted else hesitation(confidence),
            revision=snapshot.revision,
        )

    def _with_taught(self, naming: Naming, snapshot: SceneSnapshot, row: int, k: int) -> Naming:
        """What was taught is a name beside the label set, not one of other labels."""
        return with_taught(naming, snapshot.names, row, k) if self._knows_names else naming

    def _scores(self, snapshot: SceneSnapshot, row: int) -> Float32:
        scores: Float32 = self.labeller.scores(snapshot.descriptors[row][None])[0]
        return scores

    def _confidence(self, scores: Float32) -> Confidence:
        return Confidence.of(self.labeller.distribution(scores), self._temperature)


class OtherLabels:
    """Namers for label sets that come with a question; the last ``REMEMBERED`` are kept."""

    def __init__(self, namer: Namer, encoder: Encoder) -> None:
        self._namer = namer
        self._encoder = encoder
        self._known: OrderedDict[tuple[str, ...], Namer] = OrderedDict()
        self._lock = Lock()

    def namer(self, labels: Sequence[str]) -> Namer:
        """Return a namer for ``labels``, or the scene's own when there are none.

        Raises:
            ValueError: over ``MAX_GIVEN`` labels, the same twice, an empty or a long one.
        """
        if not labels:
            return self._namer
        if len(labels) > MAX_GIVEN:
            raise ValueError(f"labels: {len(labels)} given, the limit is {MAX_GIVEN}")
        label_set = custom(labels)
        with self._lock:
            known = self._known.get(label_set.labels)
        # The text tower may take a second: whoever asks with known labels does not wait for it.
        known = known or self._namer.among(Labeller(label_set, self._encoder))
        with self._lock:
            self._known[label_set.labels] = known
            self._known.move_to_end(label_set.labels)
            while len(self._known) > REMEMBERED:
                self._known.popitem(last=False)
        return known
