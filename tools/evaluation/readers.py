"""Predictions and truths in all the forms they come in."""

from collections.abc import Callable
from pathlib import Path

from sceneq_core.evaluation.surface_votes import SurfaceVotesParams
from sceneq_tools.errors import UserError
from sceneq_tools.evaluation.map_folder import is_map, read_predicted_map, read_true_map
from sceneq_tools.evaluation.points_file import read_points_file
from sceneq_tools.evaluation.predictions import Prediction
from sceneq_tools.evaluation.rendered_truth import is_rendered, read_rendered
from sceneq_tools.evaluation.scannet_scene import is_scannet, read_scannet
from sceneq_tools.evaluation.scannet_text import read_codes, read_predicted_text
from sceneq_tools.evaluation.truth import Truth

TEXT, POINTS = ".txt", ".npz"
PREDICTION_FORMS = "a folder written by sceneq map, or a file of 'mask_path label_id score' lines"
TRUTH_FORMS = (
    "a rendered recording (instances.json and frame-*.instance.png), eval_points.npz, a ScanNet "
    "scene folder, a text file of ScanNet codes, or a folder written by sceneq map"
)

ScenePair = tuple[Path, Path]
"""A prediction and the truth about the same scene."""


def scene_pairs(prediction: Path, truth: Path) -> list[ScenePair]:
    """Return the one scene that the paths are, or the scenes with equal names inside of both.

    As in the ScanNet script the predictions say which scenes there are.

    Raises:
        UserError: a path is neither a scene nor a folder of scenes, or a truth is missing.
    """
    if is_prediction(prediction):
        if not is_truth(truth):
            raise UserError(f"{truth}: no truth in it (expected {TRUTH_FORMS})", 2)
        return [(prediction, truth)]
    predictions = _children(prediction, is_prediction)
    if not predictions:
        raise UserError(f"{prediction}: no prediction in it (expected {PREDICTION_FORMS})", 2)
    truths = _children(truth, is_truth)
    if missing := [name for name in predictions if name not in truths]:
        raise UserError(f"{truth}: no truth named {missing[0]} in it (expected {TRUTH_FORMS})", 2)
    return [(path, truths[name]) for name, path in predictions.items()]


def is_prediction(path: Path) -> bool:
    """Tell whether ``path`` is the prediction of one scene."""
    return is_map(path) or (path.is_file() and path.suffix == TEXT)


def is_truth(path: Path) -> bool:
    """Tell whether ``path`` is the truth of one scene."""
    is_file = path.is_file() and path.suffix in (TEXT, POINTS)
    return is_file or is_map(path) or is_rendered(path) or is_scannet(path)


def read_prediction(path: Path, constant_score: bool = False) -> Prediction:
    """Return the predicted instances of one scene; ``constant_score`` is about maps only.

    Raises:
        UserError: it is missing or malformed.
    """
    if is_map(path):
        return read_predicted_map(path, constant_score)
    return read_predicted_text(path)


def read_truth(path: Path, votes: SurfaceVotesParams | None = None, step: int = 1) -> Truth:
    """Return the truth of one scene; ``votes`` says how the points of a recording are found.

    Only what every ``step``-th frame of a rendered recording shows is true of it then.

    Raises:
        UserError: it is missing or malformed, or has no frames of which to take every ``step``-th.
    """
    if step > 1 and not is_rendered(path):
        raise UserError(f"{path}: a step of {step} needs the frames of a rendered recording", 2)
    if path.is_file():
        return read_points_file(path) if path.suffix == POINTS else read_codes(path)
    if is_rendered(path):
        return read_rendered(path, votes, step=step)
    return read_scannet(path) if is_scannet(path) else read_true_map(path)


def _children(folder: Path, wanted: Callable[[Path], bool]) -> dict[str, Path]:
    """Return name without suffix -> path of the ``wanted`` children, by name."""
    if not folder.is_dir():
        return {}
    return {path.stem: path for path in sorted(folder.iterdir()) if wanted(path)}
