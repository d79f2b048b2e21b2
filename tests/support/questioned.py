"""The ray-cast room as a recording with truth and questions, for an encoder that knows colours."""

import json
from pathlib import Path

import cv2
import numpy as np

from sceneq_core.encoding.describe import DescribeParams
from sceneq_core.encoding.hash import HashEncoder, HashParams
from sceneq_core.reasoning.geometric import GeometricParams, GeometricReasoner
from sceneq_core.routing.labels import Labeller, custom
from sceneq_core.routing.router import Router, RouterParams
from sceneq_core.views.choice import ChoiceParams
from sceneq_core.views.selector import ViewParams
from sceneq_tools.evaluation.retrieval_setup import Setup

from support.recording import write_recording
from support.room import THINGS, Room, Thing

NAMES = [thing.name for thing in THINGS]
IDS = {name: number for number, name in enumerate(NAMES, 1)}
STUFF = ("floor", "wall")
QUERIES = (
    ("red ball", "attribute", ["red ball"]),
    ("yellow ball", "attribute", ["yellow ball"]),
    ("the box on the table", "spatial", ["blue box"]),
    ("bathtub", "absent", []),
)


def write_questioned(folder: Path, frames: int = 6, queries: tuple = QUERIES) -> Path:
    """Write the room with instance images, instances.json and queries.json."""
    write_recording(folder, frames)
    for path in folder.glob("frame-*.mask.png"):
        path.rename(path.with_name(path.name.replace("mask", "instance")))
    records = [_record(number, thing) for number, thing in enumerate(THINGS, 1)]
    (folder / "instances.json").write_text(json.dumps({"instances": records}))
    asked = [{"text": text, "bucket": bucket, "targets": t} for text, bucket, t in queries]
    (folder / "queries.json").write_text(json.dumps({"queries": asked}))
    return folder


def instance_of(frame: int, frames: int) -> np.ndarray:
    """Return the true ids of a frame, (H, W)."""
    return Room().frame(frame, frames)[2]


def paint_over(folder: Path, thing: int) -> None:
    """Make a thing invisible in every instance image."""
    for path in folder.glob("frame-*.instance.png"):
        image = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
        cv2.imwrite(str(path), np.where(image == thing, 0, image))


def hash_setup(every: int = 1) -> Setup:
    """Return what a graph with the colour encoder would build."""
    encoder = HashEncoder(HashParams())
    labeller = Labeller(custom(("ball", "box", "table", "lamp")), encoder)
    return Setup(
        encoder=encoder,
        router=Router(RouterParams(), encoder, labeller),
        reasoner=GeometricReasoner(GeometricParams()),
        calibration=None,
        keyframes={"kind": "every", "every": every},
        views=ViewParams(ChoiceParams(min_visible_px=16)),
        describe=DescribeParams(),
    )


def _record(number: int, thing: Thing) -> dict[str, object]:
    half = np.asarray(thing.size) / 2 if thing.size else np.full(3, thing.radius)
    box = [(np.asarray(thing.centre) - half).tolist(), (np.asarray(thing.centre) + half).tolist()]
    return {
        "id": number,
        "name": thing.name,
        "label": thing.name.split()[-1],
        "stuff": thing.name in STUFF,
        "history": [{"from_frame": 0, "box": box}],
    }
