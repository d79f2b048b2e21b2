"""The space in which a classifier's view of a crop and the meaning of a text are compared.

Convex combination of class names (ConSE: M. Norouzi et al., ICLR 2014, doi
10.48550/arXiv.1312.5650), scored on the side of the classes (SynC: S. Changpinyo et al., CVPR
2016, doi 10.1109/CVPR.2016.575). A vector has four parts:

    1000 classes    how much more this class shows than in any crop | how much the text means it
    H names         square roots of what a probe says, H may be 0   | the same
    1 unfamiliar    always 0                                        | what no class can say
    11 colours      square roots of the shares of colour            | the colours named

A text about something the classifier never learned keeps most of its length in "unfamiliar", where
no image follows: it is far from everything, instead of boldly near to the wrong thing.
"""

import numpy as np

from sceneq_core.arrays import Float32, Float64
from sceneq_core.encoding.colour import COLOUR_TERMS

CLASSES = 1000
COLOURS = len(COLOUR_TERMS)

COLOUR_PART = 0.2
"""Length of the colour part of an image vector of length 1. With the temperature of the conse
encoder, softmax over the terms then follows the measured shares about as firmly as its square."""
PROBE_PART = 0.85
"""Length of the probe's part beside the classes' of sqrt(1 - PROBE_PART^2)."""
CLASS_SHARPNESS = 0.05
"""Temperature of softmax(cosine(text, class names)): a few close names speak for a text."""


def dimensions(names: int) -> int:
    """Return the length of vectors with a probe of so many names."""
    return CLASSES + names + 1 + COLOURS


def image_vector(logits: Float32, prior: Float32, probed: Float32, shares: Float32) -> Float32:
    """Return the vector of a crop, length 1.

    ``logits`` (1000,) of the classifier; ``prior`` (1000,) their mean over many crops, so that
    classes that fit any blurred crop say nothing; ``probed`` (H,) probabilities of the probe's
    names; ``shares`` (11,) of colour.
    """
    surprise = logits - prior
    probe_part = PROBE_PART if len(probed) else 0.0
    classes = unit(surprise - surprise.mean()) * np.sqrt(1 - probe_part**2)
    meant = np.concatenate([classes, np.sqrt(probed) * probe_part]) * np.sqrt(1 - COLOUR_PART**2)
    colours = np.sqrt(shares) * COLOUR_PART
    return unit(np.concatenate([meant, np.zeros(1, np.float32), colours]))


def text_vector(similarity: Float32, shares: Float32) -> Float32:
    """Return the vector of a text, length 1.

    ``similarity`` (1000 + H,) cosines of the text without its colour words with the names of
    classes and probe, all 0 when nothing is left of it; ``shares`` (11,) of the colours named,
    zero if none.
    """
    has_words, has_colour = bool(similarity.any()), bool(shares.any())
    meaning = _meaning(similarity) if has_words else _nothing(len(similarity), has_colour)
    return unit(np.concatenate([meaning, np.sqrt(shares)]))


def given_evidence(vector: Float32, evidence: Float64) -> Float32:
    """Return the image vector given independent evidence for the H names, length as before.

    ``evidence`` (H,): log-likelihood of something else that is known of the thing. What the probe
    said is multiplied with it; the sum of the squares in its part stays.
    """
    names = slice(CLASSES, CLASSES + len(evidence))
    said = vector[names].astype(np.float64) ** 2
    meant = said * np.exp(evidence)
    sized = vector.copy()
    if meant.sum() > 0:
        sized[names] = np.sqrt(meant * (said.sum() / meant.sum()))
    return sized


def unit(vector: Float32) -> Float32:
    """Return ``vector`` with length 1; zeros stay zeros."""
    length = float(np.linalg.norm(vector))
    return np.asarray(vector / length if length > 0 else vector, np.float32)


def _meaning(similarity: Float32) -> Float32:
    """Return (1001 + H,): the names a text means and how little they say about it, length 1.

    The length of the class part is the square root of the softmax's length: a compromise between
    no trust in diffuse texts (its length) and full trust (1) that ranks best.
    """
    weight = np.exp((similarity - similarity.max()) / CLASS_SHARPNESS)
    weight /= weight.sum()
    length = float(np.linalg.norm(weight))
    classes = weight / np.sqrt(length)
    return np.append(classes, np.sqrt(max(0.0, 1 - length))).astype(np.float32)


def _nothing(names: int, has_colour: bool) -> Float32:
    """A mere colour leaves the names open; an empty text means nothing an image shows."""
    meaning = np.zeros(names + 1, np.float32)
    meaning[names] = 0.0 if has_colour else 1.0
    return meaning
