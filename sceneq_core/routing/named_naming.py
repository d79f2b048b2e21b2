"""What taught names add to what an instance is called."""

from dataclasses import replace

from sceneq_core.routing.answer import FOUND, Naming
from sceneq_core.routing.labels import TAUGHT
from sceneq_core.routing.names import Names


def with_taught(naming: Naming, names: Names, row: int, k: int) -> Naming:
    """Return ``naming`` of the instance in ``row`` with what it was taught first.

    What it inherited goes before the encoder's labels that are less probable, and so does what it
    is only like.
    """
    called, like = names.called.get(row, ()), names.like.get(row, ())
    if not called and not like:
        return naming
    guesses = sorted((*naming.labels, *like), key=lambda label: -label.p)
    labels = (*called, *guesses)[:k]
    if not called:
        return replace(naming, labels=labels)
    best = called[0]
    how = names.reason(best.name) if best.source == TAUGHT else _inherited(best.name, best.p)
    return replace(naming, status=FOUND, labels=labels, reason=how)


def _inherited(name: str, p: float) -> str:
    return f"it looks like what was taught to be '{name}', p {p:.2f}"
