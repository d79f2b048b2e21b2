"""How much of a calibration error is a fault, and how much the chance of few guesses?

The expected calibration error adds up absolute gaps, so chance alone makes it larger than 0, the
more the fewer guesses there are. Three ways to tell: what faultless probabilities would show on as
many guesses (J. Bröcker and L. Smith, "Increasing the reliability of reliability diagrams", Weather
and Forecasting 2007, DOI 10.1175/WAF993.1), an estimate of the squared error without that bias
(A. Kumar, P. Liang and T. Ma, "Verified Uncertainty Calibration", NeurIPS 2019, arXiv:1909.10155),
and an interval by the bootstrap.
"""

import numpy as np

from sceneq_core.arrays import Bool, Float64
from sceneq_core.evaluation.reliability import Bin, calibration_error, equal_width_bins

ROUNDS = 1000


def errors_without_fault(confidence: Float64, count: int, rounds: int = ROUNDS) -> Float64:
    """Return the errors (rounds,) over ``count`` equally wide bins if ``confidence`` were true.

    Always the same draws of what is right of the N guesses.
    """
    draws = np.random.default_rng(0).random((rounds, len(confidence))) < confidence
    return _errors(draws - confidence, confidence, count)


def as_much_by_chance(confidence: Float64, right: Bool, count: int) -> float:
    """Return how often faultless probabilities would show as large an error, or a larger one.

    1 without any guess: nothing speaks against them.
    """
    if not len(confidence):
        return 1.0
    shown = calibration_error(equal_width_bins(confidence, right, count))
    return float((errors_without_fault(confidence, count) >= shown - 1e-12).mean())


def debiased_square(bins: tuple[Bin, ...]) -> float:
    """Return the mean square of the gaps without what chance adds to it; 0 on average if faultless.

    From each squared gap the variance of the share of right ones is taken away, as the bin itself
    shows it (Kumar et al., definition 5.1). A bin with a single guess tells nothing about its
    variance and is left out. May be below 0.
    """
    telling = [one for one in bins if one.count > 1]
    total = sum(one.count for one in telling)
    squares = (
        one.count
        * (
            (one.accuracy - one.confidence) ** 2
            - one.accuracy * (1 - one.accuracy) / (one.count - 1)
        )
        for one in telling
    )
    return sum(squares) / total if total else 0.0


def debiased_error(bins: tuple[Bin, ...]) -> float:
    """Return the root of ``debiased_square``, 0 where that is below 0: an error of L2."""
    return float(np.sqrt(max(debiased_square(bins), 0.0)))


def error_interval(
    confidence: Float64, right: Bool, count: int, level: float = 0.9
) -> tuple[float, float]:
    """Return between what the error over ``count`` equally wide bins lies, so surely (``level``).

    The basic bootstrap: what resampling the guesses adds to the error shown, chance has added to
    it before, so that much is taken away (B. Efron and R. Tibshirani, "An Introduction to the
    Bootstrap", 1993). 0 and 1 without any guess.
    """
    number = len(confidence)
    if not number:
        return 0.0, 1.0
    taken = np.random.default_rng(0).integers(number, size=(ROUNDS, number))
    times = np.stack([np.bincount(one, minlength=number) for one in taken])
    again = _errors(times * (right - confidence), confidence, count)
    shown = calibration_error(equal_width_bins(confidence, right, count))
    rare = (1.0 - level) / 2.0
    upper, lower = np.quantile(again, [rare, 1.0 - rare])
    low, high = np.clip([2.0 * shown - lower, 2.0 * shown - upper], 0.0, 1.0).tolist()
    return low, high


def _errors(gaps: Float64, confidence: Float64, count: int) -> Float64:
    """Return the errors (R,) from how much each guess is more right than sure, ``gaps`` (R, N)."""
    of_each = np.clip(np.ceil(confidence * count).astype(np.int64) - 1, 0, count - 1)
    inside = (of_each[:, None] == np.arange(count)).astype(np.float64)
    errors: Float64 = np.abs(gaps @ inside).sum(axis=1) / max(len(confidence), 1)
    return errors
