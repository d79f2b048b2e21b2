"""The file of a probe: what the conse encoder was taught, beside what its classifier knows.

An ``.npz`` with ``names`` (H,), ``name_vectors`` float16 (H, 384) of the sentence encoder,
``weights`` float16 (F, H) and ``bias`` float32 (H,); ``sceneq train-probe`` writes it.
"""

import hashlib
import io
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sceneq_core.arrays import Float32
from sceneq_core.encoding.probe import Probe

HOUSEHOLD = Path(__file__).parent / "household_probe.npz"
"""Taught with rendered rooms (docs/adr/0018-taught-with-rendered-rooms.md)."""

SENTENCE_DIM = 384


@dataclass(frozen=True, slots=True, eq=False)
class ProbeFile:
    """``probe`` and the sentence vectors of its names, float32 (H, 384); ``digest`` of the file."""

    probe: Probe
    name_vectors: Float32
    digest: str


def read_probe(path: Path) -> ProbeFile:
    """Return the probe in a file.

    Raises:
        ValueError: no such file, or not one of a probe; it is named.
    """
    try:
        data = path.read_bytes()
        with np.load(io.BytesIO(data), allow_pickle=False) as arrays:
            names = tuple(str(name) for name in arrays["names"])
            weights = arrays["weights"].astype(np.float32)
            bias = arrays["bias"].astype(np.float32)
            vectors = arrays["name_vectors"].astype(np.float32)
        probe = Probe(names, weights, bias)
    except OSError as error:
        raise ValueError(f"{path}: {error.strerror or error}") from error
    except Exception as error:  # a damaged file fails in many ways inside zipfile and numpy
        raise ValueError(f"{path}: no probe file: {error!r:.120}") from error
    if vectors.shape != (len(names), SENTENCE_DIM):
        expected = (len(names), SENTENCE_DIM)
        raise ValueError(f"{path}: name_vectors: expected {expected}, got {vectors.shape}")
    return ProbeFile(probe, vectors, hashlib.sha256(data).hexdigest()[:8])


def write_probe(path: Path, probe: Probe, name_vectors: Float32) -> None:
    """Write a probe with the sentence vectors (H, 384) of its names; same probe, same bytes."""
    with path.open("wb") as file:
        np.savez(
            file,
            names=np.array(probe.names),
            name_vectors=name_vectors.astype(np.float16),
            weights=probe.weights.astype(np.float16),
            bias=probe.bias,
        )
