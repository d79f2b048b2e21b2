"""The sheet of pictures of a scene from what is known about it."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from sceneq_core.arrays import Float64, UInt8
from sceneq_core.picture.scene import Cloud, Mark, Thing
from sceneq_core.picture.sheet import SIZE, Heading, draw_sheet
from sceneq_nodes._caption import NAMED_FROM_P
from sceneq_tools.errors import UserError

Record = Mapping[str, Any]

GUESSED_FROM_P = 0.15
"""Less probable names are left out: their objects go by number."""
DIGEST_CHARACTERS = 12


def scene_picture(
    cloud: Cloud,
    document: Record,
    marks: Sequence[Mark] = (),
    question: str = "",
    size: tuple[int, int] = SIZE,
) -> UInt8:
    """Return a sheet (H, W, 3) RGB.

    Args:
        cloud: the points.
        document: what instances.json holds (scene, frame_seq, digest, instances, ...).
        marks: what must stand out.
        question: written over the sheet.
        size: width, height in pixels.

    Raises:
        UserError: there is nothing to draw, or the sheet would be too small.
    """
    things = [_thing(record) for record in document["instances"]]
    try:
        return draw_sheet(cloud, things, marks, _heading(document, question), size)
    except ValueError as error:
        raise UserError(str(error), 2) from error


def mark_of(record: Record, note: str = "") -> Mark:
    """Return the mark of an instance, with its name and a note such as how sure that is."""
    text = f"{record['id']} {record['label']}" + (f"  {note}" if note else "")
    return Mark(int(record["id"]), text, box_corners(record["box_oriented"]))


def box_corners(box: Record) -> Float64:
    """Return the corners (8, 3) in metres of a box with centre, size and rotation."""
    side = (np.arange(8)[:, None] >> np.arange(3)) & 1
    offsets = (side - 0.5) * np.asarray(box["size"], np.float64)
    corners: Float64 = np.asarray(box["centre"]) + offsets @ np.asarray(box["rotation"]).T
    return corners


def write_png(image: UInt8, path: Path) -> None:
    """Write an RGB image.

    Raises:
        UserError: the file cannot be written, or its name does not end like a picture's.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    try:
        written = cv2.imwrite(str(path), image[..., ::-1])
    except cv2.error:  # it does not know the format that the name asks for
        written = False
    if not written:
        raise UserError(f"{path}: the picture could not be written (a name ending in .png?)")


def _thing(record: Record) -> Thing:
    p, number = float(record["p"]), str(record["id"])
    named = p >= GUESSED_FROM_P
    doubt = "" if p >= NAMED_FROM_P else "?"
    text = f"{number} {record['label']}{doubt}" if named else number
    width, depth, height = (float(side) for side in record["box_oriented"]["size"])
    return Thing(record["id"], text, p, named, (width, depth, height))


def _heading(summary: Record, question: str) -> Heading:
    facts = (
        f"{summary['instance_count']} instances",
        f"{summary['points']:,} points".replace(",", " "),
        f"voxels of {100 * summary['voxel_size_m']:g} cm",
        f"map {summary['digest'][:DIGEST_CHARACTERS]} after frame {summary['frame_seq']}",
        f"name? = p under {NAMED_FROM_P:g}",
    )
    return Heading(summary["scene"], " · ".join(facts), question)
