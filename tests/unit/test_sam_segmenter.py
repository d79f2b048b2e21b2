"""SAM and SAM 2 from folders as transformers writes them; SAM against its own processor."""

import json
import shutil

import numpy as np
import pytest

from sceneq_core.frame import Frame
from sceneq_core.segmentation.automatic_masks import AutomaticParams
from sceneq_core.segmentation.letterbox import fitted
from sceneq_nodes._model_error import ModelError
from sceneq_nodes._sam_segmenter import SamParams, SamSegmenter, _pixels

from support.tiny_segmenters import SIDE, write_sam, write_sam2, write_sam2_video

transformers = pytest.importorskip("transformers", reason="transformers is not installed")

WRITERS = {"sam": write_sam, "sam2": write_sam2}
ALL = AutomaticParams(points_per_side=3, iou_min=0, stability_min=0, nms_iou=0.99, least_px=1)


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    transformers.logging.disable_progress_bar()
    return {kind: write(tmp_path_factory.mktemp(kind)) for kind, write in WRITERS.items()}


def picture(height, width):
    y, x = np.mgrid[:height, :width]
    waves = [127 + 120 * np.sin(x / 5 + k) * np.cos(y / 6 - k) for k in range(3)]
    return np.stack(waves, axis=-1).astype(np.uint8)


def frame(height, width):
    return Frame(
        seq=0,
        stamp_ns=0,
        rgb=picture(height, width),
        depth_m=np.ones((height, width), np.float32),
        K=np.array([[width, 0, width / 2], [0, width, height / 2], [0, 0, 1]], float),
        T_world_camera=np.eye(4),
    )


def segmenter(folder, **changes):
    return SamSegmenter(SamParams(**{"model": str(folder), "masks": ALL} | changes))


@pytest.mark.parametrize("kind", WRITERS)
@pytest.mark.parametrize("size", [(48, 64), (90, 61)])
def test_labels_are_of_the_frames_size_and_the_same_again(kind, size, folders):
    ours = segmenter(folders[kind])
    labels = ours.segment(frame(*size))
    assert labels.shape == size
    assert labels.dtype == np.uint16
    assert np.array_equal(ours.segment(frame(*size)), labels)


@pytest.mark.parametrize("size", [(48, 64), (90, 61)])
def test_the_picture_is_fed_as_the_processor_of_sam_does(size):
    processor = transformers.SamImageProcessorPil(
        size={"longest_edge": SIDE}, pad_size={"height": SIDE, "width": SIDE}
    )
    wanted = processor(picture(*size), return_tensors="np")["pixel_values"][0]
    box = fitted(*size, (SIDE, SIDE), centred=False)
    assert np.abs(_pixels(picture(*size), box, (SIDE, SIDE))[0] - wanted).max() < 0.04


def test_a_mask_comes_back_as_the_processor_of_sam_brings_it():
    import torch

    low = torch.nn.functional.interpolate(
        torch.randn(1, 1, 4, 4, generator=torch.Generator().manual_seed(3)), size=(16, 16),
        mode="bicubic",
    )  # fmt: skip
    box = fitted(90, 61, (SIDE, SIDE), centred=False)
    processor = transformers.SamImageProcessorPil(pad_size={"height": SIDE, "width": SIDE})
    inner = [box.inner_height, box.inner_width]
    wanted = processor.post_process_masks([low], [[90, 61]], [inner])[0][0, 0].numpy()
    got = box.restored(low[0, 0].numpy(), (SIDE, SIDE)) > 0
    assert (got == wanted).mean() > 0.98


def test_the_checkpoints_of_sam_2_for_video_serve_too(tmp_path):
    folder = write_sam2_video(tmp_path)
    assert json.loads((folder / "config.json").read_text())["model_type"] == "sam2_video"
    labels = segmenter(folder).segment(frame(48, 64))
    assert labels.shape == (48, 64)
    assert labels.any()


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ('{"model_type": "clip"}', "model_type: expected sam, sam2, sam2_video, got 'clip'"),
        ("[]", "config.json: no JSON object"),
        ("{", "config.json: no JSON object"),
    ],
)
def test_a_wrong_config_is_named(text, says, tmp_path):
    (tmp_path / "config.json").write_text(text)
    with pytest.raises(ValueError, match=says):
        segmenter(tmp_path)


def test_missing_files_are_named(folders, tmp_path):
    with pytest.raises(ValueError, match=r"config\.json: no such file; expected the config"):
        segmenter(tmp_path)
    with pytest.raises(ValueError, match=r"^model: no folder /no/where"):
        segmenter("/no/where")


def test_a_gpu_that_is_not_there_is_no_frame_without_masks(folders):
    import torch

    absent = f"cuda:{torch.cuda.device_count()}"
    with pytest.raises(ModelError, match=f"^device: no {absent}"):
        segmenter(folders["sam"], device=absent).segment(frame(48, 64))


def test_weights_that_are_not_there_are_not_made_up(folders, tmp_path):
    from safetensors.numpy import load_file, save_file

    copy = shutil.copytree(folders["sam2"], tmp_path / "copy")
    weights = load_file(copy / "model.safetensors")
    del weights["mask_decoder.iou_token.weight"]
    save_file(weights, copy / "model.safetensors", metadata={"format": "pt"})
    with pytest.raises(ModelError, match=r"1 weights of Sam2Model are missing, such as mask_dec"):
        segmenter(copy).segment(frame(48, 64))


@pytest.mark.parametrize(("name", "value"), [("device", "tpu"), ("dtype", "int8"), ("threads", 0)])
def test_bad_parameters_are_named(name, value):
    with pytest.raises(ValueError, match=f"^{name}:"):
        SamParams(**{"model": "m", name: value})
