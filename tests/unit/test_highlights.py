"""Highlights: the short formula against the one with vectors."""

import numpy as np
import pytest

from sceneq_tools.room.light.highlights import DULL, Glances, Lamps, highlights

LAMPS = Lamps(
    np.array([[0.5, 1.0, 2.4], [3.0, 2.0, 2.0]], np.float32),
    np.array([[3.0, 2.5, 2.0], [0.0, 1.0, 4.0]], np.float32),
)


def glances(count: int) -> Glances:
    rng = np.random.default_rng(5)
    out = rng.normal(size=(3, count))
    return Glances(
        (rng.random((3, count)) * 2).astype(np.float32),
        (out / np.linalg.norm(out, axis=0)).astype(np.float32),
        (rng.normal(size=(3, count)) + np.array([[0], [0], [1]])).astype(np.float32),
        rng.random((2, count)).astype(np.float32),
    )


def blinn_phong(places: Glances, shine: float, gloss: float) -> np.ndarray:
    """Return radiance (3, N), one place after another, from the definition."""
    radiance = np.zeros(places.at.shape)
    for i in range(places.at.shape[1]):
        normal = places.normals[:, i] / np.linalg.norm(places.normals[:, i])
        for centre, power, seen in zip(LAMPS.centres, LAMPS.power, places.seen[:, i], strict=True):
            to_light = centre - places.at[:, i]
            squared = to_light @ to_light
            incoming = to_light / np.sqrt(squared)
            half = incoming + places.out[:, i]
            near = max(normal @ half / np.linalg.norm(half), 0)
            lobe = max(normal @ incoming, 0) * near**gloss / squared
            radiance[:, i] += lobe * seen * power * shine * (gloss + 2) * 0.35 / (8 * np.pi)
    return radiance


def test_it_is_blinn_and_phongs_lobe() -> None:
    places, full = glances(50), np.ones(50, np.float32)
    found = highlights(LAMPS, places, full * np.float32(0.6), full * 20)

    assert found.dtype == np.float32
    assert found.max() > 0.01
    np.testing.assert_allclose(found, blinn_phong(places, 0.6, 20.0), rtol=2e-3, atol=1e-6)


@pytest.mark.parametrize("shine", [0.0, DULL])
def test_what_is_dull_has_none(shine: float) -> None:
    full = np.ones(4, np.float32)

    assert not highlights(LAMPS, glances(4), full * np.float32(shine), full).any()


def test_a_light_that_is_not_seen_gives_none() -> None:
    places, full = glances(4), np.ones(4, np.float32)
    places.seen[:] = 0

    assert not highlights(LAMPS, places, full, full).any()
