"""Descriptors with what follows from them, alone and in rows."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Float32
from sceneq_core.encoding.colour import COLOUR_TERMS
from sceneq_core.encoding.looks import FAMILIAR
from sceneq_core.routing.labels import Label, Labeller


@dataclass(frozen=True, slots=True, eq=False)
class Described:
    """A descriptor (D,) with its cosines with labels and colours; equal is only the same one.

    ``familiarity`` is how much the thing looks like something that the encoder was taught with.
    """

    descriptor: Float32
    label_scores: Float32
    colour_scores: Float32
    label: Label
    familiarity: float


@dataclass(frozen=True, slots=True)
class Matrices:
    """The rows of ``described``: (N, D), (N, C), (N, 11) and (N,)."""

    described: tuple[Described, ...]
    descriptors: Float32
    label_scores: Float32
    colour_scores: Float32
    familiarity: Float32


def describe(descriptor: Float32, labeller: Labeller, familiarity: float = FAMILIAR) -> Described:
    """Work out once what every question would ask of a descriptor."""
    scores = labeller.scores(descriptor[None])[0]
    colour_scores = labeller.colour_vectors @ descriptor
    label = labeller.best_of_scores(scores)[0]
    return Described(descriptor, scores, colour_scores, label, familiarity)


def stacked(described: Sequence[Described], labeller: Labeller) -> Matrices:
    """Return the rows as matrices."""
    return Matrices(
        tuple(described),
        _rows([one.descriptor for one in described], labeller.text_vectors.shape[1]),
        _rows([one.label_scores for one in described], len(labeller.label_set)),
        _rows([one.colour_scores for one in described], len(labeller.colour_vectors)),
        np.array([one.familiarity for one in described], np.float32),
    )


def no_matrices(labels: int) -> Matrices:
    """Return the matrices of nothing, with so many labels."""
    nothing = np.zeros((0, labels), np.float32)
    return Matrices(
        (), nothing, nothing, np.zeros((0, len(COLOUR_TERMS)), np.float32), nothing[:, 0]
    )


def _rows(rows: Sequence[Float32], width: int) -> Float32:
    return np.stack(rows) if rows else np.zeros((0, width), np.float32)
