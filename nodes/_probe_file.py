"""The file of what the conse encoder was taught, beside what its classifier knows.

An ``.npz`` with ``names`` (H,), the ``weights`` float16 (F, H) and ``bias`` float32 (H,) of their
probe, ``size_mean`` and ``size_spread`` float32 (H, 4), ``texts`` (A,) with ``text_vectors``
float16 (A, 384) of the sentence encoder and ``text_of`` int32 (A,), ``looks_centre`` float32 (F,),
``looks_axes`` float16 (F, X) and ``looks_things`` float16 (T, X) of the things that taught, and
``taught_with``, the digest of the examples; ``withheld`` are the models that did not teach.
``sceneq train-probe`` writes it. Files without looks are read: nothing looks strange to them.
"""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from sceneq_core.arrays import Float32
from sceneq_core.encoding.lessons import Lessons
from sceneq_core.encoding.looks import Looks
from sceneq_core.encoding.probe import Probe
from sceneq_core.encoding.usual_sizes import UsualSizes
from sceneq_nodes._npz_file import read_arrays

HOUSEHOLD = Path(__file__).parent / "household_probe.npz"
"""Taught with rendered things (docs/adr/0018-taught-with-rendered-rooms.md)."""

SENTENCE_DIM = 384
MAX_MB = 256


@dataclass(frozen=True, slots=True, eq=False)
class ProbeFile:
    """``lessons``, ``digest`` of the file, ``taught_with`` the digest of what they are from.

    ``withheld``: models of furniture that it was not taught with though it might have been.
    """

    lessons: Lessons
    digest: str
    taught_with: str
    withheld: tuple[str, ...] = ()


def read_probe(path: Path) -> ProbeFile:
    """Return what is in a file.

    Raises:
        ValueError: no such file, or not one of a probe; it is named.
    """
    try:
        data, arrays = path.read_bytes(), read_arrays(path, MAX_MB)
        lessons, taught_with = _lessons(arrays), str(arrays["taught_with"])
        withheld = tuple(str(model) for model in arrays.get("withheld", ()))
    except OSError as error:
        raise ValueError(f"{path}: {error.strerror or error}") from error
    except (ValueError, KeyError, TypeError) as error:
        raise ValueError(f"{path}: no probe file: {error!r:.120}") from error
    if lessons.text_vectors.shape[1:] != (SENTENCE_DIM,):
        shape = lessons.text_vectors.shape
        raise ValueError(f"{path}: text_vectors: expected rows of {SENTENCE_DIM}, got {shape}")
    return ProbeFile(lessons, hashlib.sha256(data).hexdigest()[:8], taught_with, withheld)


def write_probe(
    path: Path,
    lessons: Lessons,
    texts: Sequence[str],
    taught_with: str,
    withheld: Sequence[str] = (),
) -> None:
    """Write lessons; ``texts`` are those of their vectors. Same lessons, same bytes."""
    with path.open("wb") as file:
        np.savez_compressed(
            file,
            names=np.array(lessons.probe.names),
            weights=lessons.probe.weights.astype(np.float16),
            bias=lessons.probe.bias,
            size_mean=lessons.sizes.mean.astype(np.float32),
            size_spread=lessons.sizes.spread.astype(np.float32),
            texts=np.array(texts),
            text_vectors=lessons.text_vectors.astype(np.float16),
            text_of=lessons.text_of.astype(np.int32),
            taught_with=np.array(taught_with),
            withheld=np.array(withheld, dtype=np.str_),
            **_looks_arrays(lessons.looks),
        )


def _lessons(arrays: Mapping[str, Any]) -> Lessons:
    names = tuple(str(name) for name in arrays["names"])
    return Lessons(
        Probe(names, _floats(arrays["weights"]), _floats(arrays["bias"])),
        UsualSizes(*(arrays[key].astype(np.float64) for key in ("size_mean", "size_spread"))),
        _floats(arrays["text_vectors"]),
        arrays["text_of"].astype(np.int64),
        _looks(arrays),
    )


def _looks(arrays: Mapping[str, Any]) -> Looks | None:
    if "looks_things" not in arrays:
        return None
    return Looks(*(_floats(arrays[f"looks_{part}"]) for part in ("centre", "axes", "things")))


def _looks_arrays(looks: Looks | None) -> dict[str, Any]:
    if looks is None:
        return {}
    return {
        "looks_centre": looks.centre,
        "looks_axes": looks.axes.astype(np.float16),
        "looks_things": looks.things.astype(np.float16),
    }


def _floats(array: Any) -> Float32:
    return np.asarray(array, np.float32)
