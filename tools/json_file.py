"""Results of a command as a JSON file."""

import json
from pathlib import Path

from sceneq_tools.errors import UserError


def write_json(document: object, path: Path) -> None:
    """Write a report; ``UserError`` when the file cannot be written."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(document, indent=1, ensure_ascii=False) + "\n", "utf-8")
    except OSError as error:
        raise UserError(f"{path}: {error.strerror}") from error
