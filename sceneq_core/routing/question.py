"""A question with the vectors of its words: all the text tower has to do for an answer."""

from collections import OrderedDict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from threading import Lock

import numpy as np

from sceneq_core.arrays import Bool, Float32
from sceneq_core.encoding.encoder import Encoder
from sceneq_core.mapping.delta import OBJECT
from sceneq_core.routing import words
from sceneq_core.routing.labels import Labeller
from sceneq_core.routing.phrase import Phrase, read, without_colours


@dataclass(frozen=True, slots=True)
class Wanted:
    """The words for one thing.

    ``vector`` float32 (D,) of the words without colours, ``None`` = any thing; ``colours`` are
    rows of ``COLOUR_TERMS``; ``rivals`` bool (C,) marks the labels that mean something else.
    ``role`` is that of the instances they may mean: objects, or the part of the building named.
    """

    vector: Float32 | None
    colours: tuple[int, ...]
    rivals: Bool
    role: str = OBJECT


@dataclass(frozen=True, slots=True)
class Question:
    """A question as asked, as read, and what its target and anchors look for."""

    text: str
    phrase: Phrase
    wanted: Mapping[str, Wanted]


class TextTower:
    """Texts to vectors, remembering the last ``capacity``; may be used by several threads."""

    def __init__(self, encoder: Encoder, capacity: int = 1024) -> None:
        self._encoder = encoder
        self._capacity = capacity
        self._vectors: OrderedDict[str, Float32] = OrderedDict()
        self._lock = Lock()

    def encode(self, texts: Sequence[str]) -> Float32:
        """Return float32 (N, D), L2-normalised."""
        with self._lock:
            new = [text for text in dict.fromkeys(texts) if text not in self._vectors]
            if new:
                self._vectors.update(zip(new, self._encoder.encode_texts(new), strict=True))
            vectors = np.stack([self._vectors[text] for text in texts])
            for text in texts:
                self._vectors.move_to_end(text)
            while len(self._vectors) > self._capacity:
                self._vectors.popitem(last=False)
        return vectors


class Reader:
    """Reads questions: which things they speak of, and what those look like to the encoder."""

    def __init__(self, tower: TextTower, labeller: Labeller, synonym_cosine: float) -> None:
        self._tower = tower
        self._labeller = labeller
        self._synonym_cosine = synonym_cosine

    def read(self, text: str) -> Question:
        """Return the question in ``text``; raise ``ValueError`` when there is none in it."""
        phrase = read(text)
        things = (phrase.target, *(c.anchor for c in phrase.constraints if c.anchor))
        return Question(text, phrase, {thing: self._wanted(thing) for thing in things})

    def _wanted(self, thing: str) -> Wanted:
        noun, colours = without_colours(thing)
        role = words.STRUCTURE.get(noun, OBJECT)
        if not noun:
            return Wanted(None, colours, np.zeros(len(self._labeller.label_set), np.bool_))
        vector = self._tower.encode([noun])[0]
        return Wanted(vector, colours, self._rivals(noun, vector), role)

    def _rivals(self, noun: str, vector: Float32) -> Bool:
        """A label that means the same, or whose words end the noun's, speaks for it."""
        different: Bool = self._labeller.text_vectors @ vector < self._synonym_cosine
        padded = f" {noun}"
        spoken = [padded.endswith(f" {label}") for label in self._labeller.label_set.labels]
        rivals: Bool = different & ~np.array(spoken)
        return rivals
