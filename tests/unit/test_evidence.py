"""Pictures that show what an answer rests on."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from sceneq_tools.errors import UserError
from sceneq_tools.evidence import CAPTION_PX, HEIGHT_PX, WIDTH_PX, write_evidence

GREY = cv2.imencode(".jpg", np.full((480, 640, 3), 128, np.uint8))[1].tobytes()


def instance(number: int, *seqs: int) -> dict:
    views = [{"key": f"image?seq={s}", "box_xyxy": [100.0, 50.0, 300.0, 250.0]} for s in seqs]
    return {"id": number, "label": "mug", "p": 0.5, "views": views}


def test_each_instance_gets_a_row_and_each_view_its_box(tmp_path: Path) -> None:
    asked: list[str] = []
    answer = {"instances": [instance(1, 10, 20), instance(2, 30)]}

    def picture(key: str) -> bytes:
        asked.append(key)
        return GREY

    assert write_evidence(answer, picture, tmp_path / "deep" / "out.png")
    sheet = cv2.imread(str(tmp_path / "deep" / "out.png"))
    assert sheet.shape == (2 * (HEIGHT_PX + CAPTION_PX), 4 * WIDTH_PX, 3)
    assert asked == ["image?seq=10", "image?seq=20", "image?seq=30"]
    edge = sheet[CAPTION_PX + 75, 50]
    assert edge[2] > edge[0] + 60
    assert (sheet[HEIGHT_PX + 2 * CAPTION_PX + 5 :, WIDTH_PX:] == 255).all()


def test_a_picture_that_is_gone_leaves_no_hole(tmp_path: Path) -> None:
    gone = {"image?seq=10": None, "image?seq=20": GREY}
    assert write_evidence({"instances": [instance(1, 10, 20)]}, gone.get, tmp_path / "out.png")
    sheet = cv2.imread(str(tmp_path / "out.png"))
    assert sheet[CAPTION_PX + 5, 5].tolist() == [128, 128, 128]
    assert (sheet[CAPTION_PX:, WIDTH_PX:] == 255).all()


def test_no_instance_no_file(tmp_path: Path) -> None:
    assert not write_evidence({"instances": []}, lambda key: GREY, tmp_path / "out.png")
    assert not (tmp_path / "out.png").exists()


def test_a_name_that_is_no_picture_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"out\.xyz"):
        write_evidence({"instances": [instance(1, 1)]}, lambda key: GREY, tmp_path / "out.xyz")
