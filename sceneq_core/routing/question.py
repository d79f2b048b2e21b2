"""A question with the vectors of its words: all the text tower has to do for an answer."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from sceneq_core.arrays import Bool, Float32
from sceneq_core.encoding.encoder import Encoder
from sceneq_core.encoding.towers import TextCache
from sceneq_core.mapping.delta import OBJECT
from sceneq_core.reasoning.english import singular
from sceneq_core.routing import words
from sceneq_core.routing.attributes import without_excluded
from sceneq_core.routing.described_words import describes, wants_to_do
from sceneq_core.routing.labels import Labeller
from sceneq_core.routing.phrase import Phrase, read, without_colours, without_sizes


@dataclass(frozen=True, slots=True)
class Wanted:
    """The words for one thing.

    ``vector`` float32 (D,) of the words without colours, ``None`` = any thing; ``colours`` are
    rows of ``COLOUR_TERMS`` that it has, ``excluded`` those that it has not, ``sizes`` words of
    ``SIZE_WORDS``; ``rivals`` bool (C,) marks the labels that mean something else, ``kinds`` (C,)
    those that name a kind of it, ``noun`` is the word itself. ``role`` is that of the instances
    they may mean: objects, or the part of the building named. ``described``: the words say what it
    is for, or like, and do not name it.
    """

    vector: Float32 | None
    colours: tuple[int, ...]
    rivals: Bool
    kinds: Bool
    role: str = OBJECT
    excluded: tuple[int, ...] = ()
    sizes: tuple[str, ...] = ()
    noun: str = ""
    described: bool = False


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
        self._texts = TextCache(capacity)

    def encode(self, texts: Sequence[str]) -> Float32:
        """Return float32 (N, D), L2-normalised; known texts wait for nobody else's new ones."""
        vectors = self._texts.known(texts)
        new = [text for text in dict.fromkeys(texts) if text not in vectors]
        if new:
            fresh = dict(zip(new, self._encoder.encode_texts(new), strict=True))
            self._texts.keep(fresh)
            vectors |= fresh
        return np.stack([vectors[text] for text in texts])


QUESTIONS = 512
"""So many questions are remembered as read: people and robots ask the same things again."""


class Reader:
    """Reads questions: which things they speak of, and what those look like to the encoder."""

    def __init__(self, tower: TextTower, labeller: Labeller, synonym_cosine: float) -> None:
        self._tower = tower
        self._labeller = labeller
        self._synonym_cosine = synonym_cosine
        self._row = {label: row for row, label in enumerate(labeller.label_set.labels)}
        self._remembered = lru_cache(maxsize=QUESTIONS)(self._read)

    def read(self, text: str, *, many: bool = False) -> Question:
        """Return the question in ``text``; ``many``: it speaks of its target in the plural.

        Raises:
            ValueError: there is no question in it.
        """
        return self._remembered(text, many)

    def _read(self, text: str, many: bool) -> Question:
        phrase = read(text)
        if many:
            phrase = replace(phrase, target=singular(phrase.target))
        things = (phrase.target, *(words for c in phrase.constraints for words in c.things))
        wanted = {thing: self._wanted(thing) for thing in things}
        if wants_to_do(text):
            wanted[phrase.target] = replace(wanted[phrase.target], described=True)
        return Question(text, phrase, wanted)

    def _wanted(self, thing: str) -> Wanted:
        kept, excluded = without_excluded(thing)
        coloured, colours = without_colours(kept)
        noun, sizes = without_sizes(coloured)
        role = words.STRUCTURE.get(noun, OBJECT)
        if not noun:
            nobody = np.zeros(len(self._labeller.label_set), np.bool_)
            return Wanted(None, colours, nobody, nobody, OBJECT, excluded, sizes)
        vector = self._tower.encode([noun])[0]
        kinds = np.array([label.endswith(f" {noun}") for label in self._row], np.bool_)
        return Wanted(
            vector=vector,
            colours=colours,
            rivals=self._rivals(noun, vector),
            kinds=kinds,
            role=role,
            excluded=excluded,
            sizes=sizes,
            noun=noun,
            described=describes(noun),
        )

    def _rivals(self, noun: str, vector: Float32) -> Bool:
        """A label that means the same, or whose words end the noun's, speaks for it."""
        rivals: Bool = self._labeller.text_vectors @ vector < self._synonym_cosine
        tokens = noun.split(" ")
        endings = (" ".join(tokens[first:]) for first in range(len(tokens)))
        rivals[[self._row[ending] for ending in endings if ending in self._row]] = False
        return rivals
