"""The front door for questions about a scene.

Reads   map and view deltas of the scene, descriptors of its encoder's model (state: gaps are
        healed from snapshots, so a restarted node catches up), and the robot's newest pose.
Serves  sceneq/query/<scene>/{instances,ask,label,status,labels,last,names} and, what changes names,
        sceneq/teach/<scene>/{set,forget}; asks sceneq/reason/<scene>. Names are kept in the store.
Writes  sceneq/label/<scene>/delta/v1: what every instance is called, whenever that changes, at most
        twice a second; epoch = start time in ms; the whole at sceneq/label/<scene>/@snapshot/v1.
Rate    queries are answered on a pool from an immutable snapshot in memory; ``step`` swaps it.
        With ``meanwhile``, answers come from the former encoder until the new one's descriptors
        cover the map, then all at once from the new one.
Bad     instances, views and descriptors with impossible numbers are counted, logged and left out;
        so are descriptors of another model than their key says; bad requests are answered with
        ``bad_request``; a missing reasoner with ``fallback``.
"""

import logging
import time
from collections.abc import Callable
from concurrent.futures import Future
from functools import partial
from typing import ClassVar

import numpy as np

from sceneq_core.encoding.encoder import Encoder
from sceneq_core.mapping.delta import Instance
from sceneq_core.routing.revision import Revision
from sceneq_core.teaching.album import Album
from sceneq_nodes._answer_json import Json
from sceneq_nodes._asked_reasoner import AskedReasoner
from sceneq_nodes._backends import build
from sceneq_nodes._bus import Bus, Context, Received, Reply, Request
from sceneq_nodes._calibration import Calibration
from sceneq_nodes._chosen_calibration import chosen_calibration, former_calibration
from sceneq_nodes._convert import map_delta_from_message
from sceneq_nodes._follow import Follower
from sceneq_nodes._front_door import FrontDoor
from sceneq_nodes._label_stream import LabelStream
from sceneq_nodes._likeness_file import judgement_of
from sceneq_nodes._name_keeper import NameKeeper
from sceneq_nodes._new_router import new_router
from sceneq_nodes._purse import Purse
from sceneq_nodes._routing_params import RoutingParams
from sceneq_nodes._scene_input import is_id, is_usable, view_refs
from sceneq_nodes._space import Space, in_background
from sceneq_nodes._teaching_desk import TeachingDesk
from sceneq_schemas import topics
from sceneq_schemas.feature import FeatureDelta
from sceneq_schemas.frame import Pose
from sceneq_schemas.map import MapDelta
from sceneq_schemas.view import ViewDelta

log = logging.getLogger(__name__)
HELD = {"map_delta": "map", "view_delta": "views", "feature_delta": "features"}
"""Under which names the writers of these report how far they are, and so do we."""


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
        encoder: Encoder = build("encoder", params.encoder, ("encoder",))
        calibration = chosen_calibration(params.calibration, encoder)
        self._next: Space | None = None
        self._coming: Future[Space] | None = None
        former = build("encoder", params.meanwhile, ("meanwhile",)) if params.meanwhile else encoder
        self._keeper = NameKeeper(bus, params.names, former.model_id)
        if former.model_id == encoder.model_id:
            self._space = self._new_space(encoder, calibration)
        else:
            known = former_calibration(params.calibration, former)
            self._space = self._new_space(former, known)
            self._coming = in_background(partial(self._new_space, encoder, calibration))
        self._names = LabelStream(bus, self._context.scene)
        self._purse = Purse(bus, params.budget, params.policy)
        self._serve()
        self._follow()

    def step(self, received: Received | None) -> None:
        """Take over one change, and look for missed ones: poses may leave no idle moment."""
        self._warm_up()
        if received is not None and isinstance(received.message, Pose):
            self._move(received.message)
        elif received is not None:
            follower = self._followers.get(_place(received.topic, received.ids.get("model", "")))
            if follower is not None:  # descriptors of a former encoder may still come
                follower.offer(received.message)
        for follower in list(self._followers.values()):
            follower.tick()
        self._bus.report(**{HELD[topic]: f.at for (topic, _), f in self._followers.items()})
        self._arrive()
        self._names.tick(self._space.model, self._space.router.namer, self._space.look.snapshot)

    def close(self) -> None:
        """Nothing to release."""

    def _warm_up(self) -> None:
        """Load the text tower before the first question needs it."""
        if not self._warm:
            self._space.warm_up()
            self._warm = True

    def _arrive(self) -> None:
        """Let the new encoder's space follow the scene once it is made."""
        if self._coming is None or not self._coming.done():
            return
        coming, self._coming = self._coming, None
        if (error := coming.exception()) is not None:
            self._bus.count("encoder_failed")
            log.error("answers stay with the encoder %s: %s", self._space.model, error)
            return
        self._next = new = coming.result()
        new.take_over(self._space)
        self._doors[new.model] = self._new_door(new)
        self._followers[_place(topics.FEATURE_DELTA, new.model)] = self._follower_of(new)
        self._followers[_place(topics.FEATURE_DELTA, new.model)].open()

    def _spaces(self) -> list[Space]:
        return [self._space] if self._next is None else [self._space, self._next]

    def _new_space(self, encoder: Encoder, calibration: Calibration | None) -> Space:
        params = self._params
        labels = params.chosen_labels()
        router = new_router(encoder, labels, params.router, calibration)
        album = Album(encoder.model_id, judgement_of(encoder.model_id, params.likeness))
        return Space(encoder, router, self._keeper, album)

    def _new_door(self, space: Space) -> FrontDoor:
        scene = self._context.scene
        params, purse = self._params, self._purse
        asked = AskedReasoner(self._bus, scene, params.reason_timeout_s, purse, params.remembered)
        return FrontDoor(
            *(scene, space.router, lambda: space.look, asked.solve, self._health),
            name=asked.label,
            told=self._names.tell,
            policy=purse,
            seeing=space.see,
        )

    def _serve(self) -> None:
        scene = self._context.scene
        self._doors = {self._space.model: self._new_door(self._space)}
        for topic, handler in (
            (topics.QUERY_INSTANCES, FrontDoor.instances),
            (topics.QUERY_ASK, FrontDoor.ask),
            (topics.QUERY_LABEL, FrontDoor.label),
            (topics.QUERY_STATUS, FrontDoor.status),
            (topics.QUERY_LABELS, FrontDoor.labels),
            (topics.QUERY_LAST, FrontDoor.last),
        ):
            self._bus.serve(topic, partial(self._answer, handler), scene=scene)
        desk = TeachingDesk(scene, self._keeper, lambda: self._space)
        self._bus.serve(topics.QUERY_NAMES, desk.names, scene=scene)
        self._bus.serve(topics.TEACH_SET, desk.set, scene=scene)
        self._bus.serve(topics.TEACH_FORGET, desk.forget, scene=scene)

    def _answer(
        self, handler: Callable[[FrontDoor, Request], Reply | None], request: Request
    ) -> Reply | None:
        """Answer from one space: a switch while an answer is made does not change it."""
        return handler(self._doors[self._space.model], request)

    def _follow(self) -> None:
        scene, bus = self._context.scene, self._bus
        self._followers = {
            _place(topics.MAP_DELTA): Follower(
                *(bus, topics.MAP_DELTA, topics.MAP_SNAPSHOT, self._apply_map),
                journal_topic=topics.MAP_JOURNAL,
                scene=scene,
            ),
            _place(topics.VIEW_DELTA): Follower(
                *(bus, topics.VIEW_DELTA, topics.VIEW_SNAPSHOT, self._apply_views),
                journal_topic=topics.VIEW_JOURNAL,
                scene=scene,
            ),
        }
        place = _place(topics.FEATURE_DELTA, self._space.model)
        self._followers[place] = self._follower_of(self._space)
        bus.subscribe(topics.POSE, depth=1, robot=self._context.robot)
        for follower in list(self._followers.values()):
            follower.open()

    def _follower_of(self, space: Space) -> Follower:
        return Follower(
            *(self._bus, topics.FEATURE_DELTA, topics.FEATURE_SNAPSHOT),
            partial(self._apply_features, space),
            journal_topic=topics.FEATURE_JOURNAL,
            scene=self._context.scene,
            model=space.model,
        )

    def _apply_map(self, message: MapDelta) -> None:
        revision = Revision(message.epoch, message.seq, message.frame_seq, message.stamp_ns)
        delta = map_delta_from_message(message)
        instances = [one for one in delta.instances if self._usable(one)]
        self._keeper.follow(message.epoch, instances)
        for space in self._spaces():
            space.scene.apply_map(revision, instances, delta.up_world, full=delta.full)
        self._swap(time.monotonic())

    def _apply_views(self, message: ViewDelta) -> None:
        if not message.map_epoch:
            return  # the views node has started again and knows no map yet
        views = view_refs(message)
        for space in self._spaces():
            space.scene.apply_views(message.map_epoch, views)
        self._swap(self._space.look.map_arrived_s)

    def _apply_features(self, space: Space, message: FeatureDelta) -> None:
        if not message.map_epoch:
            return  # the encoding node has started again and knows no views yet
        if message.model_id != space.model:
            self._refuse("descriptors_refused", f"{message.model_id} on the key of {space.model}")
            return
        looks, familiarity = {}, {}
        for one in message.descriptors:
            familiar = space.familiarity(one.descriptor, one.feature)
            if familiar is not None and is_id(one.instance_id):
                looks[one.instance_id] = (one.descriptor, one.feature)
                familiarity[one.instance_id] = familiar
            else:
                self._refuse("descriptors_refused", f"descriptor of instance {one.instance_id}")
        descriptors = {instance_id: descriptor for instance_id, (descriptor, _) in looks.items()}
        removed = np.array([key for key in message.removed.tolist() if is_id(key)], np.int32)
        space.album.put(message.map_epoch, looks, removed.tolist())
        space.scene.apply_descriptors(message.map_epoch, descriptors, removed, familiarity)
        self._swap(self._space.look.map_arrived_s)

    def _move(self, pose: Pose) -> None:
        position_world = pose.T_world_camera[:3, 3]
        if np.isfinite(position_world).all():
            for space in self._spaces():
                space.move(position_world)
        else:
            self._refuse("poses_refused", f"pose of frame {pose.seq} is not finite")

    def _usable(self, instance: Instance) -> bool:
        usable = is_usable(instance)
        if not usable:
            self._refuse("instances_refused", f"instance {instance.instance_id} has no place")
        return usable

    def _refuse(self, counter: str, what: str) -> None:
        self._bus.count(counter)
        log.warning("%s: %s", counter, what)

    def _swap(self, map_arrived_s: float) -> None:
        for space in self._spaces():
            space.swap(map_arrived_s)
        self._switch()
        snapshot = self._space.look.snapshot
        self._bus.report(
            instances=snapshot.instance_count,
            answerable=len(snapshot),
            map_seq=snapshot.revision.seq,
        )

    def _switch(self) -> None:
        """Leave the former encoder as soon as the new one covers what it covers."""
        former, new = self._space, self._next
        if new is None or former.share_in(new) < max(self._params.cover, 1e-9):
            return
        self._space, self._next = new, None
        self._keeper.leading = new.model
        del self._followers[_place(topics.FEATURE_DELTA, former.model)]
        self._bus.count("encoder_switches")
        log.warning("answers come from the encoder %s now, not %s", new.model, former.model)

    def _health(self) -> Json:
        space, new = self._space, self._next
        covered = round(space.share_in(new), 3) if new else 0.0
        return {
            "robot": self._context.robot,
            "sensor": self._context.sensor,
            "model": space.model,
            "alive": sorted(self._bus.alive()),
            "synced": {name: f.synced for (name, _), f in list(self._followers.items())},
            "reasoning": self._purse.status(),
            "names": self._keeper.status(),
            **({"next_covers": covered} if new or self._coming else {}),
        }


def _place(topic: topics.Topic, model: str = "") -> tuple[str, str]:
    """Return where the follower of a topic is found: descriptors have one for each model."""
    return topic.name, model
