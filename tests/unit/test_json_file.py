"""Results written for other programs."""

import json
from pathlib import Path

import pytest

from sceneq_tools.errors import UserError
from sceneq_tools.json_file import write_json


def test_folders_are_made_and_letters_stay_readable(tmp_path: Path) -> None:
    path = tmp_path / "new" / "report.json"
    write_json({"café": [1, 2.5]}, path)
    text = path.read_text(encoding="utf-8")
    assert "café" in text
    assert json.loads(text) == {"café": [1, 2.5]}


def test_a_place_that_cannot_be_written_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="Is a directory"):
        write_json({}, tmp_path)
