"""Shows a running graph in Rerun: map, camera, answers with their evidence, rates and delays.

Reads   keyframes, segments, map, view and feature deltas of the scene, metrics of every node.
Asks    the front door for names and the last answers, views for the pictures behind them.
Writes  nothing on the bus; a web page, a file or a Rerun viewer elsewhere gets it.
Rate    pictures as they come; map and answers ``picture_hz`` times a second at most, and less
        often when a picture takes long: three quarters of the time are left to listening.
Bad     what does not decode counts as ``frames_bad`` or ``metrics_bad``, a delta that contradicts
        the map as ``map_delta_bad``, an answer that is none as ``answers_bad``; what comes faster
        than it can be shown is dropped from the inbox and counted there; while a viewer elsewhere
        takes nothing, ``messages_skipped`` and ``pictures_skipped``; one that is gone is looked
        for again (``viewers_lost``).
"""

import logging
import os
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, ClassVar

from sceneq_nodes._bus import Bus, Context, Received
from sceneq_nodes._epoch import new_epoch
from sceneq_nodes._followed_map import FollowedMap
from sceneq_nodes._viewer_asking import Asking
from sceneq_nodes._viewer_eye import Eyes
from sceneq_nodes._viewer_layout import live_layout
from sceneq_nodes._viewer_map import CLOUDS, MAX_POINTS, SUPERPOINTS
from sceneq_nodes._viewer_output import Output, OutputParams, need_rerun
from sceneq_nodes._viewer_screen import Screen
from sceneq_schemas import topics
from sceneq_schemas.errors import DecodeError
from sceneq_schemas.map import MapDelta
from sceneq_schemas.topics import Topic

log = logging.getLogger(__name__)

NICE = 10
"""The nodes that work come first where cores are few."""
DEPTHS = {
    topics.FRAME: 2,
    topics.MASK: 2,
    topics.VIEW_DELTA: 8,
    topics.FEATURE_DELTA: 8,
    topics.METRIC: 64,
}
STAGES = {topics.VIEW_DELTA: "views", topics.FEATURE_DELTA: "descriptors"}
REST = 3.0
"""So many times what a picture took passes before the next one."""
NAMES_S = 3.0


@dataclass(frozen=True, slots=True)
class ViewerParams:
    """Where the picture goes and how often it is made; ``superpoints`` shows them as well.

    ``max_points`` of each cloud: of a larger map every second, fourth, ... point is shown.
    """

    output: OutputParams = field(default_factory=OutputParams)
    picture_hz: float = 1.0
    max_points: int = MAX_POINTS
    superpoints: bool = False

    def __post_init__(self) -> None:
        if self.max_points < 1:
            raise ValueError(f"max_points: must be at least 1, got {self.max_points}")
        if not 0 < self.picture_hz <= 10:
            raise ValueError(f"picture_hz: {self.picture_hz} is not in (0, 10]")


class Viewer:
    """Follows one scene and draws it."""

    Params: ClassVar[type] = ViewerParams
    idle_s: ClassVar[float] = 0.2

    def __init__(
        self,
        params: ViewerParams,
        context: Context,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._params = params
        self._context = context
        self._clock = clock
        self._screen: Screen | None = None
        self._due_s = self._names_due_s = 0.0
        self._map_is_new = self._names_are_old = False

    def open(self, bus: Bus) -> None:
        """Take the output, then listen; raise ``ValueError`` when the output cannot be had."""
        need_rerun()
        os.nice(max(0, NICE - os.nice(0)))
        self._bus, context = bus, self._context
        self._asking = Asking(bus, context.scene)
        self._captions: dict[int, str] = {}
        self._eyes = Eyes()
        recording_id = f"{context.scene}-{new_epoch()}"
        self._clouds = [path for path in CLOUDS if path != SUPERPOINTS or self._params.superpoints]
        self._output = Output(self._params.output, recording_id, live_layout(self._clouds))
        self._output.open()
        ids = {"scene": context.scene, "robot": context.robot, "sensor": context.sensor}
        for topic, depth in DEPTHS.items():
            known = {name: ids[name] for name in topic.id_names if name in ids}
            bus.subscribe(topic, depth=depth, **known)
        self._map = FollowedMap(bus, context.scene, self._note)
        self._map.open()
        if self._params.output.serves:
            log.warning("watch at %s", self._params.output.page)

    def step(self, received: Received | None) -> None:
        """Take in one message; draw when it is time."""
        if received is None:
            self._map.tick()
        elif received.topic is topics.MAP_DELTA:
            self._map.offer(received.message)
        elif self._output.waiting:
            self._bus.count("messages_skipped")
        elif self._screen is not None:
            self._show(self._screen, received.topic, received.message)
        if self._clock() >= self._due_s:
            began_s = self._clock()
            self._draw()
            took_s = self._clock() - began_s
            pause_s = max(1.0 / self._params.picture_hz - took_s, REST * took_s)
            self._due_s = self._clock() + pause_s

    def close(self) -> None:
        """End the recording."""
        self._output.close()

    def _note(self, delta: MapDelta) -> None:
        self._map_is_new = self._names_are_old = True
        if self._screen is not None:
            self._screen.reach("map", delta.frame_seq, self._clock())

    def _show(self, screen: Screen, topic: Topic, message: Any) -> None:
        try:
            self._show_good(screen, topic, message)
        except DecodeError as error:
            self._bus.count(f"{topic.name}s_bad")
            log.warning("%s: skipped, %s", topic.name, error)

    def _show_good(self, screen: Screen, topic: Topic, message: Any) -> None:
        now_s = self._clock()
        if topic is topics.FRAME:
            screen.frame(message, now_s)
        elif topic is topics.MASK:
            screen.masks(message, now_s)
        elif topic is topics.METRIC:
            screen.metrics(message, now_s)
        else:
            self._names_are_old |= topic is topics.FEATURE_DELTA
            screen.reach(STAGES[topic], message.frame_seq, now_s)

    def _draw(self) -> None:
        """Bring map and answers up to date, if somebody is there to see them and takes them."""
        if self._output.waiting:
            self._bus.count("pictures_skipped")
            return
        recording, is_new = self._output.recording()
        if self._screen is not None and (recording is None or is_new):
            self._bus.count("viewers_lost")
            self._screen = None
        if recording is None:
            return
        if self._screen is None:
            self._screen = Screen(recording, self._clouds, self._params.max_points)
            self._map_is_new = True
        self._draw_answers(self._screen)
        self._draw_map(self._screen)
        self._screen.series(self._clock())
        self._output.flush()

    def _draw_map(self, screen: Screen) -> None:
        now_s = self._clock()
        if self._names_are_old and now_s >= self._names_due_s:
            self._captions = self._asking.captions() or self._captions
            self._names_are_old, self._names_due_s = False, now_s + NAMES_S
            self._map_is_new = True
        if self._map_is_new and (eye := self._eyes.look(self._map.replica)) is not None:
            self._output.arrange(live_layout(self._clouds, eye))
        points = 0
        if self._map_is_new or screen.needs_map(now_s):
            points = screen.map(self._map.replica, self._captions, now_s)
        self._map_is_new = False
        boxes = len(self._map.replica.instances)
        self._bus.report(points_logged=points, boxes=boxes, answer=screen.answer_id)

    def _draw_answers(self, screen: Screen) -> None:
        earlier = self._asking.earlier()
        newest_id = earlier[0]["query_id"] if earlier else ""
        if newest_id == screen.answer_id:
            return
        answer = self._asking.newest()
        if answer is not None:
            best = answer["instances"][0]["views"] if answer["instances"] else []
            pictures = [self._asking.picture(view["seq"]) for view in best[:3]]
            screen.answer(answer, earlier[1:], pictures, self._clock())
