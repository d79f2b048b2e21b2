"""A recording run through the nodes of a graph in one process."""

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from sceneq_core.arrays import Float64
from sceneq_core.ingest.trajectory import (
    color_trajectory,
    corrected_trajectory,
    trajectory_report,
)
from sceneq_nodes._backends import build, load
from sceneq_nodes._bus import Bus, Context, Node, QueryError, Received, Reply
from sceneq_nodes._params import ParamError, validate
from sceneq_schemas.topics import POSE, POSE_CORRECTION, Topic
from sceneq_tools.errors import UserError
from sceneq_tools.graph_plan import Plan
from sceneq_tools.local_bus import LocalHub

POSES = "poses"
INGEST, ENCODING, GATEWAY = "ingest", "encoding", "gateway"
MOST_AT_ONCE = 8
"""More instances at a time than this want more memory than they save time."""
TROUBLES = (
    *("skipped", "refused", "unmatched", "lost", "bad", "missing", "failed", "gone"),
    "quarantined",
)


@dataclass(frozen=True, slots=True)
class Stage:
    """A part of the work: ``steps`` yields how many of ``total`` are done."""

    name: str
    total: int | None
    steps: Iterator[int]


class PoseLog:
    """Keeps the pose of every frame, and what corrections say of keyframes."""

    Params: ClassVar[type] = object
    idle_s: ClassVar[float] = 1.0

    def __init__(self, params: Any, context: Context) -> None:
        self._context = context
        self.poses: list[tuple[int, Float64]] = []
        self._keyframes: list[int] = []
        self._corrected: dict[int, Float64] = {}

    def open(self, bus: Bus) -> None:
        """Listen to poses and their corrections."""
        bus.subscribe(POSE, depth=1, robot=self._context.robot)
        bus.subscribe(POSE_CORRECTION, depth=1, robot=self._context.robot)

    def step(self, received: Received | None) -> None:
        """Keep a pose, or what is known better of older ones."""
        if received is None:
            return
        message = received.message
        if received.topic is POSE_CORRECTION:
            poses = zip(message.keyframe_seq.tolist(), message.T_world_camera, strict=True)
            self._corrected.update(poses)
            return
        self.poses.append((message.seq, message.T_world_camera))
        if message.keyframe:
            self._keyframes.append(message.seq)

    def corrected(self) -> list[tuple[int, Float64]]:
        """Return the poses as they are known by now."""
        return corrected_trajectory(self.poses, self._keyframes, self._corrected)

    def close(self) -> None:
        """Nothing to release."""


class Batch:
    """The nodes of ``plan`` on one hub, from the source to answerable instances.

    ``listeners`` are further nodes, by name, that hear everything from the first message on.

    Raises:
        UserError: a node that cannot start with its parameters.
    """

    def __init__(self, plan: Plan, listeners: Mapping[str, Node] | None = None) -> None:
        self.scene = plan.scene
        self._plan = plan
        self._hub = LocalHub()
        nodes = [node for node in plan.nodes if node.node_kind != GATEWAY]
        self._params = {node.id: node.params for node in nodes}
        kinds = {node.node_kind: node.id for node in nodes}
        if INGEST not in kinds:
            raise UserError("the graph has no ingest node to read the recording", 2)
        self._ingest, self._encoding = kinds[INGEST], kinds.get(ENCODING)
        self._pose_log = PoseLog(None, self._context(POSES))
        for name, listener in {POSES: self._pose_log, **(listeners or {})}.items():
            self._hub.add(listener, self._context(name))
        # Readers first, so that nobody misses the first message.
        for node in sorted(nodes, key=lambda node: node.id == self._ingest):
            self._open(node.id, node.node_kind, {**_of_a_batch(node.node_kind), **node.params})

    def stages(self) -> Iterator[Stage]:
        """Yield what there is to do; the next stage starts when the steps of one are consumed."""
        source = build("source", self._params[self._ingest]["source"])
        yield Stage("frames", len(source) if hasattr(source, "__len__") else None, self._play())
        if self._encoding is not None:
            total = int(self._hub.reported[self._encoding].get("pending", 0))
            yield Stage("descriptors", total, self._encode(total))

    def get(self, topic: Topic, parameters: Mapping[str, Any], **ids: str) -> Reply | None:
        """Ask one of the nodes, as ``collect`` does; raise ``UserError`` on an error reply."""
        try:
            said = {name: str(value) for name, value in parameters.items()}
            replies = self._hub.ask(topic.key(scene=self.scene, **ids), said)
        except QueryError as error:
            raise UserError(str(error)) from error
        return replies[-1] if replies else None

    def params_of(self, kind: str) -> Mapping[str, Any]:
        """Return the parameters of the node of a kind, none when there is no such node."""
        return next((node.params for node in self._plan.nodes if node.node_kind == kind), {})

    def troubles(self) -> dict[str, int]:
        """Return the counters of what was lost or refused."""
        counters = self._hub.counters
        return {name: n for name, n in counters.items() if name.endswith(TROUBLES) and n}

    def trajectory_report(self) -> str:
        """Return one line that compares the poses used with those the source gives."""
        source = build("source", {**self._params[self._ingest]["source"], "use_poses": True})
        try:
            report = trajectory_report(self._pose_log.corrected(), color_trajectory(source))
        except ValueError as error:
            raise UserError(f"--report: {error}") from error
        return (
            f"position RMSE {report.rmse_m:.3f} m over {report.length_m:.1f} m, "
            f"{report.frames} frames, against the given poses (Umeyama-aligned)"
        )

    def close(self) -> None:
        """Close every node."""
        self._hub.close()

    def _context(self, node: str) -> Context:
        return Context(node, self._plan.scene, self._plan.robot, self._plan.sensor)

    def _open(self, name: str, kind: str, params: Mapping[str, Any]) -> None:
        try:
            cls = load("nodes", kind)
            node: Node = cls(validate(cls.Params, params, (name,)), self._context(name))
            self._hub.add(node, self._context(name))
        except (ParamError, ValueError) as error:
            raise UserError(f"{name}: {error}", 2) from error

    def _play(self) -> Iterator[int]:
        said = self._hub.reported[self._ingest]
        while said["state"] != "finished":
            self._hub.idle(self._ingest)
            yield int(said["frames"])

    def _encode(self, total: int) -> Iterator[int]:
        said = self._hub.reported[self._encoding or ""]
        while pending := int(said.get("pending", 0)):
            self._hub.idle(self._encoding or "")
            yield max(total - pending, 0)
        yield total


def _of_a_batch(kind: str) -> dict[str, int]:
    """Return parameters that are better in one process than in one of many.

    Instances are described when all frames are in the map, and nobody else needs the cores.
    """
    cores = min(len(os.sched_getaffinity(0)), MOST_AT_ONCE)
    return {"at_once": cores} if kind == ENCODING else {}
