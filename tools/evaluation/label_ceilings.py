"""How sure names of instances may be, from true instances that the encoder knows or does not."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from sceneq_core.evaluation.familiarity_fit import fit_label_ceiling
from sceneq_core.routing.label_ceiling import STRANGE, LabelCeiling
from sceneq_core.routing.labels import Labeller
from sceneq_tools.evaluation.calibration import Scene
from sceneq_tools.evaluation.calibration_guesses import label_guesses

DIGITS = 4

Named = list[tuple[float, bool]]
"""Familiarity of an instance, and whether its first name is right."""


def label_ceiling(
    known: Sequence[Scene], strange: Sequence[Scene], labeller: Labeller
) -> LabelCeiling | None:
    """Return the ceiling that both kinds of scenes show, each kind counting half.

    ``None`` where a kind has no name in the label set, or all are right or wrong.
    """
    sides = [_named(scenes, labeller) for scenes in (known, strange)]
    if not all(sides):
        return None
    pairs = np.array([pair for side in sides for pair in side], np.float64)
    counts = np.concatenate([np.full(len(side), 1.0 / len(side)) for side in sides])
    fitted = fit_label_ceiling(pairs[:, 0], pairs[:, 1] > 0, counts)
    if fitted is None:
        return None
    return replace(fitted, slope=round(fitted.slope, DIGITS), shift=round(fitted.shift, DIGITS))


def _named(scenes: Sequence[Scene], labeller: Labeller) -> Named:
    """Return what has a name in the label set and a familiarity."""
    return [
        (guess.familiarity, guess.is_top_right)
        for scene in scenes
        for guess in label_guesses(labeller, scene.candidates, scene.questioned.things)
        if guess.familiarity > STRANGE
    ]
