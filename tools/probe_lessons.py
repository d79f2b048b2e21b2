"""What the conse encoder learns from examples."""

import logging
from collections.abc import Callable, Sequence

import numpy as np

from sceneq_core.arrays import Float32
from sceneq_core.encoding.lessons import Lessons
from sceneq_core.encoding.probe_training import ProbeTrainingParams, train_probe
from sceneq_core.encoding.usual_sizes import learn_sizes
from sceneq_tools.probe_examples import Example, as_arrays
from sceneq_tools.wordnet import PACKAGE_HINT, WordNet

log = logging.getLogger(__name__)

Meanings = Sequence[tuple[str, str]]
"""Texts, and the name that each of them means."""


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
    """Return the lessons of the examples; ``ValueError`` when there are fewer than two names."""
    probe = train_probe(*_weighted(found), ProbeTrainingParams(rounds=rounds))
    row = {name: number for number, name in enumerate(probe.names)}
    return Lessons(
        probe=probe,
        sizes=learn_sizes(probe.names, [(one.names[0], one.shape) for one in found]),
        text_vectors=embed_all([text for text, _ in texts]),
        text_of=np.array([row[name] for _, name in texts], np.int64),
    )


def _weighted(found: Sequence[Example]) -> tuple[Float32, list[str]]:
    names, features = as_arrays(found)
    return features, names


def _dictionary() -> WordNet | None:
    try:
        return WordNet()
    except OSError:
        log.warning("no WordNet here: names mean only themselves (%s)", PACKAGE_HINT)
        return None
