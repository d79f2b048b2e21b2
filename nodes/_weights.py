"""Which weights a model really has: a short digest of its files, worked out once for each file.

A name says little: two files called ``model.safetensors`` are two models. Hashing a gigabyte takes
a second or more, so the digest of a file is kept in ``$XDG_CACHE_HOME/sceneq``, under the file's
place, size and time.
"""

import hashlib
import logging
import re
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from sceneq_nodes._cache import cache_path, write_whole

log = logging.getLogger(__name__)

SHORT = 10
"""Hexadecimal digits of a digest in a model id: 40 bits, for the handful of models of one site."""
BLOCK = 1 << 20


def model_id(name: str, files: Sequence[Path], settings: str = "") -> str:
    """Return ``<name>-<digest>`` of ``[a-z0-9_-]``; the digest is of the files and the settings.

    Nothing in it depends on where the files lie: two machines with the same files agree.

    Raises:
        ValueError: a file that cannot be read.
    """
    whole = hashlib.sha256(settings.encode())
    for path in files:
        whole.update(f"{path.name}\0{digest(path)}\0".encode())
    slug = re.sub(r"[^a-z0-9_]+", "-", name.lower()).strip("-")
    return f"{slug}-{whole.hexdigest()[:SHORT]}"


def digest(path: Path) -> str:
    """Return the SHA-256 of a file; raise ``ValueError`` when it cannot be read."""
    try:
        status = path.stat()
        place = f"{path.resolve()}\0{status.st_size}\0{status.st_mtime_ns}"
        kept = cache_path() / f"weights-{hashlib.sha256(place.encode()).hexdigest()[:24]}.sha256"
        if (found := _kept(kept)) is not None:
            return found
        fresh = _hash(path)
    except OSError as error:
        raise ValueError(f"{path}: cannot be read: {error.strerror}") from error
    _keep(kept, fresh)
    return fresh


def need_package(module: str, extra: str, kind: str) -> None:
    """Raise ``ValueError`` with what to install when ``module`` is not there; imports nothing."""
    if find_spec(module) is None:
        raise ValueError(
            f"kind: '{kind}' needs the package {module}, which is not installed "
            f"(pip install 'sceneq[{extra}]')"
        )


def need_file(path: Path, what: str) -> Path:
    """Return ``path``; raise ``ValueError`` when there is no such file."""
    if not path.is_file():
        raise ValueError(f"{path}: no such file; expected {what}")
    return path


def need_prompt(params: Any) -> None:
    """Refuse a ``prompt`` without a place for the text."""
    if "{}" not in params.prompt:
        raise ValueError(f"prompt: needs {{}} where the text goes, got {params.prompt!r}")


def _hash(path: Path) -> str:
    whole = hashlib.sha256()
    with path.open("rb") as file:
        while block := file.read(BLOCK):
            whole.update(block)
    return whole.hexdigest()


def _kept(path: Path) -> str | None:
    text = path.read_text(encoding="ascii").strip() if path.is_file() else ""
    return text if re.fullmatch(r"[0-9a-f]{64}", text) else None


def _keep(path: Path, text: str) -> None:
    try:
        write_whole(path, lambda file: file.write(text.encode("ascii")))
    except OSError as error:
        log.warning("%s: not kept, the next start is slower: %s", path, error)
