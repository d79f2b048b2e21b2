"""How bold an answer may be."""

from dataclasses import dataclass, field

from sceneq_core.checks import need_at_least, need_within
from sceneq_core.routing.answer import AMBIGUOUS, FOUND, NOT_FOUND
from sceneq_core.routing.gate import Confidence, Gate, GateParams
from sceneq_core.routing.likelihood import Fit


@dataclass(frozen=True, slots=True)
class JudgeParams:
    """What a status needs, besides the gate.

    A claim is made where it costs less than asking back does: at a probability of 1 - (cost of
    asking back) / (cost of a wrong claim) and more (C. Chow, "On optimum recognition error and
    reject tradeoff", IEEE Trans. Inf. Theory 1970, DOI 10.1109/TIT.1970.1054406).
    ``min_claim`` is for ``found``, that there is such a thing and that it is this one: being wrong
    costs three times what asking back does. ``min_absence`` is for ``not_found``, which also has
    to be likelier than any one thing: being wrong costs less, the matches are still there to see.
    That an anchor is not there needs ``min_claim``.

    ``absent_lift`` is for encoders without a calibration: when the words fit the best instance
    less than this multiple of chance, a label picked blindly would fit better: ``not_found``.
    """

    gate: GateParams = field(default_factory=GateParams)
    min_claim: float = 0.67
    min_absence: float = 0.4
    absent_lift: float = 1.0

    def __post_init__(self) -> None:
        need_within(self, 0, 1, "min_claim", "min_absence")
        need_at_least(self, 0, "absent_lift")


class Judge:
    """Chooses between ``found``, ``ambiguous`` and ``not_found``, and says why.

    Between "surely there" and "surely not" lies ``ambiguous``: a weak encoder ends there most of
    the time, and says so rather than guess boldly.
    """

    def __init__(self, params: JudgeParams) -> None:
        self.params = params
        self._gate = Gate(params.gate)

    def accepts(self, confidence: Confidence) -> bool:
        """Return whether the gate lets the first guess pass."""
        return self._gate.accepts(confidence)

    def claims(self, presence: float, p: float = 1.0) -> bool:
        """Return whether something that is there with ``presence`` and meant with ``p`` is sure."""
        return presence * p >= self.params.min_claim

    def absent(self, fit: Fit) -> bool:
        """Return whether there surely is no such thing: nothing that could be it is in the map."""
        if not len(fit.order):
            return True
        if fit.calibrated:
            likeliest = (1.0 - fit.p_null) * float(fit.p.max(initial=0.0))
            return fit.p_null >= max(self.params.min_absence, likeliest)
        return fit.presence < self.params.absent_lift * fit.chance

    def missing(self, fit: Fit) -> bool:
        """Return whether an anchor is surely not there, so that nothing can stand by it.

        Who names an anchor takes it for granted, and does not ask for it: to deny it is a claim as
        bold as ``found``, and hides a target that may well be there.
        """
        if fit.calibrated and len(fit.order):
            return fit.p_null >= max(self.params.min_claim, self.params.min_absence)
        return self.absent(fit)

    def judge(self, words: str, fit: Fit, confidence: Confidence) -> tuple[str, str]:
        """Return status and reason of the encoder's own answer to ``words``."""
        if self.absent(fit):
            return NOT_FOUND, absence(words, fit)
        if not self.accepts(confidence):
            return AMBIGUOUS, hesitation(confidence)
        if not self.claims(fit.presence, float(fit.p.max())):
            return AMBIGUOUS, (
                f"one instance stands out, but is '{words}' only with p {fit.presence:.2f}"
            )
        return FOUND, "the gate accepts the encoder's first guess"


def absence(words: str, fit: Fit) -> str:
    """Say why there is no such thing."""
    if fit.calibrated:
        return f"there is no '{words}' with p {fit.p_null:.2f}"
    return f"'{words}' fits no instance better than a label picked blindly"


def hesitation(confidence: Confidence) -> str:
    """Say why the gate does not let the first guess pass."""
    none = f"none {confidence.p_null:.2f}, " if confidence.p_null else ""
    return (
        f"not sure which: p {confidence.p_max:.2f}, {none}margin {confidence.margin:.2f}, "
        f"entropy {confidence.entropy_norm:.2f} of its maximum"
    )
