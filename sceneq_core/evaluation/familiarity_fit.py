"""Which scenes look familiar, told from examples of both kinds."""

from sceneq_core.arrays import Float64

LEAST_VARIANCE = 1e-4
"""So that scenes that are all alike do not make the decision infinitely sharp."""


def fit_familiarity(known: Float64, strange: Float64) -> tuple[float, float]:
    """Return the ``middle`` and ``slope`` of the log odds that a scene is a known one.

    ``known`` (K,) and ``strange`` (S,) are how familiar scenes of either kind look. Two normal
    distributions of one variance, both kinds as likely: Fisher's linear discriminant (R. Fisher,
    Annals of Eugenics 1936, DOI 10.1111/j.1469-1809.1936.tb02137.x).

    Raises:
        ValueError: there is none of a kind, or strange scenes look as familiar as known ones.
    """
    if not len(known) or not len(strange):
        raise ValueError(f"familiarity: {len(known)} known scenes and {len(strange)} strange ones")
    far, near = float(strange.mean()), float(known.mean())
    if near <= far:
        raise ValueError(f"familiarity: {near:.3f} of known scenes, {far:.3f} of strange ones")
    variance = max((float(known.var()) + float(strange.var())) / 2.0, LEAST_VARIANCE)
    return (near + far) / 2.0, (near - far) / variance
