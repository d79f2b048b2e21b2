"""A model's folder: on this disk, or of the Hugging Face hub, fetched once into its cache."""

import logging
from pathlib import Path

log = logging.getLogger(__name__)

FILES = ("*.json", "*.safetensors", "*.model", "*.txt", "*.jinja", "*.bin")
"""What towers and tokenizers need; other formats of the same weights are left where they are."""


def model_folder(model: str, revision: str = "main") -> Path:
    """Return the folder of ``model``: a path, or the name of a hub repository such as ``org/name``.

    The cache is asked first, so a robot without network starts with what it once fetched.

    Raises:
        ValueError: no such folder, or not in the cache and not to be had.
    """
    path = Path(model).expanduser()
    if path.is_dir():
        return path
    if model.startswith((".", "/", "~")) or model.count("/") != 1:
        raise ValueError(f"model: no folder {model} (a hub repository is named org/name)")
    return _cached(model, revision) or _fetched(model, revision)


def _cached(model: str, revision: str) -> Path | None:
    from huggingface_hub import snapshot_download
    from huggingface_hub.errors import LocalEntryNotFoundError

    try:
        return Path(
            snapshot_download(
                model, revision=revision, allow_patterns=list(FILES), local_files_only=True
            )
        )
    except LocalEntryNotFoundError:
        return None


def _fetched(model: str, revision: str) -> Path:
    from huggingface_hub import snapshot_download

    log.warning("fetching %s from the hub, once", model)
    try:
        return Path(snapshot_download(model, revision=revision, allow_patterns=list(FILES)))
    except (OSError, ValueError) as error:
        reason = str(error).strip().splitlines()[0]
        raise ValueError(
            f"model: {model} is neither a folder nor cached, and cannot be fetched: {reason}"
        ) from error
