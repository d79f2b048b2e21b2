"""What the conse encoder learns from examples."""

import logging
from collections.abc import Callable, Sequence

import numpy as np

from sceneq_core.arrays import Float32
from sceneq_core.encoding.lessons import Lessons
from sceneq_core.encoding.looks import learn_looks
from sceneq_core.encoding.probe import Probe
from sceneq_core.encoding.probe_training import ProbeTrainingParams, train_probe
from sceneq_core.encoding.usual_sizes import learn_sizes
from sceneq_tools.probe_examples import Example, as_arrays, as_things
from sceneq_tools.wordnet import PACKAGE_HINT, WordNet

log = logging.getLogger(__name__)

Meanings = Sequence[tuple[str, str]]
"""Texts, and the name that each of them means."""

NEVER = 30.0
"""So far below the least bias of the others is that of a name without an example: pictures raise
and lower the others by ten or so, and it stays as good as impossible."""


def meanings(found: Sequence[Example]) -> Meanings:
    """Return every name with itself, its synonyms and, where WordNet is installed, its gloss."""
    synonyms: dict[str, set[str]] = {}
    for one in found:
        synonyms.setdefault(one.names[0], set()).update(one.names[1:])
    dictionary = _dictionary()
    texts = []
    for name, others in sorted(synonyms.items()):
        gloss = dictionary.gloss(name) if dictionary else None
        said = [name, *sorted(others), *([gloss] if gloss else [])]
        texts += [(text, name) for text in dict.fromkeys(said)]
    return texts


def learn(
    found: Sequence[Example],
    texts: Meanings,
    embed_all: Callable[[Sequence[str]], Float32],
    rounds: int,
) -> Lessons:
    """Return the lessons of the examples, with all names of ``texts``.

    A name without an example is there, never meant and never measured: lessons from other
    examples, with the same texts, have the same dimensions.

    Raises:
        ValueError: there are examples of fewer than two names, or of fewer than two things.
    """
    names = tuple(sorted({name for _, name in texts}))
    row = {name: number for number, name in enumerate(names)}
    return Lessons(
        probe=_among(names, train_probe(*_weighted(found), ProbeTrainingParams(rounds=rounds))),
        sizes=learn_sizes(names, [(one.names[0], one.shape) for one in found]),
        text_vectors=embed_all([text for text, _ in texts]),
        text_of=np.array([row[name] for _, name in texts], np.int64),
        looks=learn_looks(as_things(found)),
    )


def _among(names: tuple[str, ...], taught: Probe) -> Probe:
    """Return a probe of all ``names`` that says what ``taught`` says of those it knows."""
    rows = [names.index(name) for name in taught.names]
    weights = np.zeros((len(taught.weights), len(names)), np.float32)
    bias = np.full(len(names), taught.bias.min() - NEVER, np.float32)
    weights[:, rows], bias[rows] = taught.weights, taught.bias
    return Probe(names, weights, bias)


def _weighted(found: Sequence[Example]) -> tuple[Float32, list[str]]:
    names, features = as_arrays(found)
    return features, names


def _dictionary() -> WordNet | None:
    try:
        return WordNet()
    except OSError:
        log.warning("no WordNet here: names mean only themselves (%s)", PACKAGE_HINT)
        return None
