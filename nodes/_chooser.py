"""Who decides, question by question, whether the reasoner is asked."""

from typing import Protocol

from sceneq_core.routing.policy import Case, Decision


class Chooser(Protocol):
    """A policy with its state: time, budget and what it learned."""

    def decide(self, case: Case) -> Decision:
        """Return whether a question is worth the reasoner."""

    def told(self, case: Case, *, changed: bool) -> None:
        """Learn whether the reasoner said something else than the encoder."""


class GateOnly:
    """Asks where the gate does not accept the encoder's answer, and learns nothing."""

    def decide(self, case: Case) -> Decision:
        """Return what the gate says."""
        return Decision(not case.enough)

    def told(self, case: Case, *, changed: bool) -> None:
        """Nothing to learn."""
