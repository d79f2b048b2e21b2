"""Evaluation points that somebody else chose: ``eval_points.npz`` beside an ``instances.json``.

``points`` (N, 3) metres, ``instance`` (N,) id in instances.json, ``stuff`` (N,) True on wall and
floor, which count as unannotated.
"""

from pathlib import Path

import numpy as np

from sceneq_tools.errors import UserError
from sceneq_tools.evaluation.true_things import THINGS_FILE, read_things
from sceneq_tools.evaluation.truth import Truth, truth_of_things

ARRAYS = ("points", "instance", "stuff")


def read_points_file(path: Path) -> Truth:
    """Return the truth at the points of ``path``.

    Raises:
        UserError: an array is missing or has another shape, or there is no instances.json.
    """
    try:
        with np.load(path) as arrays:
            points_world, instance, is_stuff = (arrays[name] for name in ARRAYS)
    except KeyError as error:
        raise UserError(f"{path}: no array {error.args[0]!r}"[:300], 2) from error
    except (OSError, ValueError) as error:
        raise UserError(f"{path}: cannot be read: {error}", 2) from error
    if points_world.ndim != 2 or points_world.shape[1] != 3:
        raise UserError(f"{path}: points: expected (N, 3), got {points_world.shape}", 2)
    for name, array in (("instance", instance), ("stuff", is_stuff)):
        if array.shape != (len(points_world),):
            raise UserError(f"{path}: {name}: expected (N,), got {array.shape}", 2)
    named = {thing.id: thing.names for thing in read_things(path.parent / THINGS_FILE)}
    number = np.where(is_stuff, 0, instance).astype(np.int64)
    return truth_of_things(points_world.astype(np.float32), number, named, str(path))
