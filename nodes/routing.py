"""The front door for questions about a scene.

Reads   map and view deltas of the scene, descriptors of its encoder's model (state: gaps are
        healed from snapshots, so a restarted node catches up), and the robot's newest pose.
Serves  sceneq/query/<scene>/{instances,ask,label,status,labels,last}; asks sceneq/reason/<scene>.
Rate    queries are answered on a pool from an immutable snapshot in memory; ``step`` swaps it.
Bad     instances, views and descriptors with impossible numbers are counted, logged and left out;
        bad requests are answered with ``bad_request``; a missing reasoner with ``fallback``.
"""

import logging
import math
import time
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np

from sceneq_core.encoding.encoder import Encoder
from sceneq_core.mapping.delta import Instance
from sceneq_core.reasoning.reasoner import Problem, Verdict
from sceneq_core.routing.labels import LabelSet, custom, named
from sceneq_core.routing.router import Router, RouterParams
from sceneq_core.routing.scene import Revision, Scene, ViewRef
from sceneq_nodes._answer_json import Json
from sceneq_nodes._backends import build
from sceneq_nodes._bus import Bus, Context, QueryError, Received
from sceneq_nodes._calibration import given_calibration
from sceneq_nodes._convert import map_delta_from_message
from sceneq_nodes._follow import Follower
from sceneq_nodes._front_door import FrontDoor, Look, ReasonerError
from sceneq_nodes._new_router import new_router
from sceneq_nodes._reason_json import problem_bytes, verdict_from_bytes
from sceneq_schemas import topics
from sceneq_schemas.errors import DecodeError
from sceneq_schemas.feature import FeatureDelta
from sceneq_schemas.frame import Pose
from sceneq_schemas.map import MapDelta
from sceneq_schemas.view import ViewDelta

log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class RoutingParams:
    """``encoder`` must be that of the encoding node: only its texts compare with its images.

    ``labels`` replaces the named ``label_set``. ``calibration``: path of what ``sceneq calibrate``
    wrote; its temperature and thresholds replace those of encoder and gate. ``reason_timeout_s``:
    how long a question waits for the reasoner before it is answered without.
    """

    encoder: dict[str, Any] = field(default_factory=lambda: {"kind": "conse"})
    label_set: str = "scannet200"
    labels: tuple[str, ...] = ()
    router: RouterParams = field(default_factory=RouterParams)
    calibration: str = ""
    reason_timeout_s: float = 10.0

    def __post_init__(self) -> None:
        if not 0 < self.reason_timeout_s <= 600:
            raise ValueError(f"reason_timeout_s: {self.reason_timeout_s} is not in (0, 600]")

    def chosen_labels(self) -> LabelSet:
        """Return the set of ``labels``, or the named one."""
        return custom(self.labels) if self.labels else named(self.label_set)


class Routing:
    """Follows the scene and opens the front door."""

    Params: ClassVar[type] = RoutingParams
    idle_s: ClassVar[float] = 0.2

    def __init__(self, params: RoutingParams, context: Context) -> None:
        self._params = params
        self._context = context
        self._warm = False

    def open(self, bus: Bus) -> None:
        """Know the labels, answer queries, then catch up with the scene."""
        self._bus = bus
        params = self._params
        self._encoder: Encoder = build("encoder", params.encoder, ("encoder",))
        calibration = given_calibration(params.calibration)
        router = new_router(self._encoder, params.chosen_labels(), params.router, calibration)
        self._model = self._encoder.model_id
        self._scene = Scene(router.labeller)
        self._look = Look(self._scene.snapshot(), -math.inf)
        self._serve(router)
        self._follow()

    def step(self, received: Received | None) -> None:
        """Take over one change, and look for missed ones: poses may leave no idle moment."""
        self._warm_up()
        if received is not None and isinstance(received.message, Pose):
            self._move(received.message)
        elif received is not None:
            self._followers[received.topic].offer(received.message)
        for follower in self._followers.values():
            follower.tick()

    def close(self) -> None:
        """Nothing to release."""

    def _warm_up(self) -> None:
        """Load the text tower before the first question needs it."""
        if not self._warm:
            self._encoder.encode_texts(["hello"])
            self._warm = True

    def _serve(self, router: Router) -> None:
        scene = self._context.scene
        door = FrontDoor(scene, router, lambda: self._look, self._reason, self._health)
        for topic, handler in (
            (topics.QUERY_INSTANCES, door.instances),
            (topics.QUERY_ASK, door.ask),
            (topics.QUERY_LABEL, door.label),
            (topics.QUERY_STATUS, door.status),
            (topics.QUERY_LABELS, door.labels),
            (topics.QUERY_LAST, door.last),
        ):
            self._bus.serve(topic, handler, scene=scene)

    def _follow(self) -> None:
        scene, bus = self._context.scene, self._bus
        self._followers = {
            topics.MAP_DELTA: Follower(
                bus, topics.MAP_DELTA, topics.MAP_SNAPSHOT, self._apply_map, scene=scene
            ),
            topics.VIEW_DELTA: Follower(
                bus, topics.VIEW_DELTA, topics.VIEW_SNAPSHOT, self._apply_views, scene=scene
            ),
            topics.FEATURE_DELTA: Follower(
                *(bus, topics.FEATURE_DELTA, topics.FEATURE_SNAPSHOT, self._apply_features),
                scene=scene,
                model=self._model,
            ),
        }
        bus.subscribe(topics.POSE, depth=1, robot=self._context.robot)
        for follower in self._followers.values():
            follower.open()

    def _apply_map(self, message: MapDelta) -> None:
        revision = Revision(message.epoch, message.seq, message.frame_seq, message.stamp_ns)
        delta = map_delta_from_message(message)
        instances = [one for one in delta.instances if self._usable(one)]
        self._scene.apply_map(revision, instances, delta.up_world, full=delta.full)
        self._swap(time.monotonic())

    def _apply_views(self, message: ViewDelta) -> None:
        if not message.map_epoch:
            return  # the views node has started again and knows no map yet
        views = {
            view_set.instance_id: tuple(
                ViewRef(view.seq, tuple(view.box_xyxy.tolist()))
                for view in view_set.views
                if np.isfinite(view.box_xyxy).all()
            )
            for view_set in message.view_sets
        }
        self._scene.apply_views(message.map_epoch, views)
        self._swap(self._look.map_arrived_s)

    def _apply_features(self, message: FeatureDelta) -> None:
        if not message.map_epoch:
            return  # the encoding node has started again and knows no views yet
        descriptors = {}
        for one in message.descriptors:
            if self._scene.accepts(one.descriptor):
                descriptors[one.instance_id] = one.descriptor
            else:
                self._refuse("descriptors_refused", f"descriptor of instance {one.instance_id}")
        self._scene.apply_descriptors(message.map_epoch, descriptors, message.removed)
        self._swap(self._look.map_arrived_s)

    def _move(self, pose: Pose) -> None:
        position_world = pose.T_world_camera[:3, 3]
        if np.isfinite(position_world).all():
            self._scene.move_viewpoint(position_world)
            seen = replace(self._look.snapshot, viewpoint_world=position_world)
            self._look = replace(self._look, snapshot=seen)
        else:
            self._refuse("poses_refused", f"pose of frame {pose.seq} is not finite")

    def _usable(self, instance: Instance) -> bool:
        """JSON has no NaN, and a box without place is no answer."""
        numbers = (instance.centre_world, instance.aabb_world, instance.T_world_box)
        usable = all(np.isfinite(n).all() for n in (*numbers, instance.box_size_m))
        if not usable:
            self._refuse("instances_refused", f"instance {instance.instance_id} is not finite")
        return usable

    def _refuse(self, counter: str, what: str) -> None:
        self._bus.count(counter)
        log.warning("%s: %s", counter, what)

    def _swap(self, map_arrived_s: float) -> None:
        snapshot = self._scene.snapshot()
        self._look = Look(snapshot, map_arrived_s)
        self._bus.report(
            instances=snapshot.instance_count,
            answerable=len(snapshot),
            map_seq=snapshot.revision.seq,
        )

    def _reason(self, problem: Problem) -> Verdict:
        """Ask the reasoning node; raise ``ReasonerError`` when no usable verdict comes."""
        try:
            replies = self._bus.ask(
                topics.REASON,
                payload=problem_bytes(problem),
                timeout_s=self._params.reason_timeout_s,
                scene=self._context.scene,
            )
            if replies:
                return verdict_from_bytes(replies[0].payload)
        except (QueryError, DecodeError) as error:
            self._bus.count("reasoner_failed")
            raise ReasonerError(f"the reasoner failed: {error}") from error
        self._bus.count("reasoner_missing")
        raise ReasonerError("no reasoner answered")

    def _health(self) -> Json:
        return {
            "robot": self._context.robot,
            "sensor": self._context.sensor,
            "model": self._model,
            "alive": sorted(self._bus.alive()),
            "synced": {t.name: f.synced for t, f in self._followers.items()},
        }
