"""Scene-Q from Python: ask a running graph, and be told what changes.

from sceneq_client import SceneQ

with SceneQ("tcp/robot:7447") as scene:
    answer = scene.ask("the red mug on the table")
    print(answer.said, answer.best.centre_world if answer.best else None)
"""

from sceneq_client.answer import Answer, Box, Confidence, Instance, Name, Naming, View
from sceneq_client.async_scene_q import AsyncSceneQ
from sceneq_client.changes import Change
from sceneq_client.errors import (
    BusyError,
    DisconnectedError,
    NoAnswerError,
    RefusedError,
    SceneError,
)
from sceneq_client.scene_q import SceneQ
from sceneq_client.standing import Sighting
from sceneq_client.subscription import Subscription

__all__ = [
    "Answer",
    "AsyncSceneQ",
    "Box",
    "BusyError",
    "Change",
    "Confidence",
    "DisconnectedError",
    "Instance",
    "Name",
    "Naming",
    "NoAnswerError",
    "RefusedError",
    "SceneError",
    "SceneQ",
    "Sighting",
    "Subscription",
    "View",
]
