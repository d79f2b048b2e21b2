"""A folder written by ``sceneq map``, as prediction or as truth."""

from pathlib import Path

import numpy as np

from sceneq_core.mapping.delta import OBJECT
from sceneq_tools.evaluation.predictions import PredictedCloud
from sceneq_tools.evaluation.truth import Truth, truth_of_things
from sceneq_tools.evaluation.vocabulary import Names
from sceneq_tools.scene_files import ARRAYS_FILE, read_scene

NAMELESS: Names = ("nameless",)
"""Of instances in a truth that have no label: they count where classes do not matter."""


def is_map(path: Path) -> bool:
    """Tell whether ``path`` is such a folder."""
    return (path / ARRAYS_FILE).is_file()


def read_predicted_map(folder: Path, constant_score: bool = False) -> PredictedCloud:
    """Return the instances of a map; their score is the p of their label.

    With ``constant_score`` all are equally sure, as peers without a confidence export them. An
    instance that has points but no record has no name, and score 0. Floor, walls and ceiling are
    no predictions: they are what the truth calls stuff.

    Raises:
        UserError: the folder is not complete.
    """
    cloud, document = read_scene(folder)
    instance_id = cloud.instance_id.astype(np.int64)
    records = {int(record["id"]): record for record in document["instances"]}
    structure = [i for i, record in records.items() if record.get("role", OBJECT) != OBJECT]
    ids = np.setdiff1d(instance_id[instance_id > 0], structure)
    found = [records.get(int(one), {}) for one in ids]
    return PredictedCloud(
        source=str(folder),
        points_world=cloud.points_world,
        instance_id=instance_id,
        ids=ids,
        names=tuple(_names(record) for record in found),
        score=np.array([1.0 if constant_score else record.get("p", 0.0) for record in found]),
    )


def read_true_map(folder: Path) -> Truth:
    """Return a map as truth: every instance a thing called by its label."""
    cloud, document = read_scene(folder)
    named = {int(record["id"]): _names(record) or NAMELESS for record in document["instances"]}
    number = np.maximum(cloud.instance_id, 0).astype(np.int64)
    return truth_of_things(cloud.points_world, number, named, f"{folder} (a map)")


def _names(record: dict[str, object]) -> Names:
    label = record.get("label")
    return (str(label),) if label else ()
