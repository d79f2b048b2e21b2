"""Brings a recording or a camera into the graph: a pose for every frame, images of keyframes.

Reads   a source; sceneq/view/<scene>/delta/v1 when lossless: its ``frame_seq`` acknowledges.
Writes  sceneq/pose/<robot>/v1 for every frame, sceneq/frame/<robot>/<sensor>/v1 for keyframes,
        sceneq/pose/<robot>/correction/v1 when odometry closes a loop: earlier poses were wrong.
Serves  sceneq/ctl/<node>/{list,move,remove,add,look}: what a simulated source lets one change.
Rate    ``rate_hz`` frames a second, late ones at once (``frames_late``), latest wins, of a robot
        all of them as they come; or, without a rate, as fast as the graph takes it: at most
        ``window`` keyframes are on their way, an unacknowledged one is sent again
        (``frames_resent``), in the end given up (``frames_lost``).
        When mapping or views start again while it plays, so does the source (``replays``).
        In a scene with a map keyframes are held until it is known where they are (_arrival).
Bad     a source that cannot be opened ends the process with code 2; a bad frame is skipped, logged
        with file and reason and counted (``frames_skipped``; ``tracking_lost`` of those for want
        of a pose).
"""

import logging
import time
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

from sceneq_core.ingest.ingestor import Ingested
from sceneq_core.ingest.pose_graph import PoseGraphParams
from sceneq_core.ingest.source import RawFrame, Skipped, Waiting
from sceneq_nodes._arrival import Arrival
from sceneq_nodes._arrival_params import ArrivalParams
from sceneq_nodes._bus import Bus, Context, Received, Reply, Request
from sceneq_nodes._corrections import correction_message
from sceneq_nodes._epoch import new_epoch
from sceneq_nodes._images import frame_message
from sceneq_nodes._ingesting import IngestSpecs, new_ingestor, open_source
from sceneq_nodes._pacer import Pacer
from sceneq_nodes._source_control import VERBS, control
from sceneq_nodes._window import Window
from sceneq_schemas.correction import PoseCorrection
from sceneq_schemas.frame import Frame, Pose
from sceneq_schemas.topics import CONTROL, FRAME, POSE, POSE_CORRECTION, VIEW_DELTA
from sceneq_schemas.view import ViewDelta

log = logging.getLogger(__name__)

BURST_S = 0.05
"""Work on frames that long, then look at the inbox and the stop signal again."""
ALIVE_POLL_S = 0.2
RGB_CODECS = ("raw", "jpeg")
DEPTH_CODECS = ("raw", "zstd", "delta")


@dataclass(frozen=True, slots=True)
class IngestParams:
    """What to play, how fast, and in which form; times in seconds.

    ``rate_hz`` None or 0 means lossless. ``wait_for`` names nodes that must live before the first
    frame, for at most ``wait_s``. ``window`` and ``resend_s`` are for lossless play: keyframes on
    their way (more than segmentation's ``inbox`` holds would be dropped and come late), and the
    silence of the graph after which one is sent again, ``tries`` times in all; ``replays``: how
    often the source starts again for readers that did, for a frame may be what ends them.
    ``arrival``: what to do in a scene that has a map already. ``robot``: who this is, where that is
    not the graph's own robot.
    """

    source: dict[str, Any]
    rate_hz: float | None = None
    keyframes: dict[str, Any] = field(default_factory=lambda: {"kind": "interval"})
    odometry: dict[str, Any] = field(default_factory=lambda: {"kind": "depth_icp"})
    pose_graph: PoseGraphParams = field(default_factory=PoseGraphParams)
    rgb_codec: str = "raw"
    depth_codec: str = "raw"
    window: int = 2
    resend_s: float = 2.0
    tries: int = 5
    replays: int = 3
    arrival: ArrivalParams = field(default_factory=ArrivalParams)
    robot: str | None = None
    wait_for: tuple[str, ...] = ("segmentation", "mapping", "views")
    wait_s: float = 20.0

    def __post_init__(self) -> None:
        if self.rate_hz is not None and not 0 <= self.rate_hz < float("inf"):
            raise ValueError(f"rate_hz: expected 0 or more, got {self.rate_hz}")
        if self.rgb_codec not in RGB_CODECS:
            raise ValueError(f"rgb_codec: expected raw or jpeg, got {self.rgb_codec!r}")
        if self.depth_codec not in DEPTH_CODECS:
            raise ValueError(f"depth_codec: expected raw, zstd or delta, got {self.depth_codec!r}")
        for name in ("window", "tries", "resend_s"):
            if not getattr(self, name) > 0:
                raise ValueError(f"{name}: expected more than 0, got {getattr(self, name)}")
        if self.replays < 0:
            raise ValueError(f"replays: expected 0 or more, got {self.replays}")


class Ingest:
    """Plays one source."""

    Params: ClassVar[type] = IngestParams
    idle_s: ClassVar[float] = 0.005

    def __init__(self, params: IngestParams, context: Context) -> None:
        self._params = params
        self._context = replace(context, robot=params.robot) if params.robot else context
        self._pacer = Pacer(params.rate_hz) if params.rate_hz else None
        self._readers: tuple[int, int] | None = None
        self._hears = False
        self._frames = self._keyframes = self._replays = 0
        self._state = "waiting"

    def open(self, bus: Bus) -> None:
        """Open the source; raise ``ValueError`` when it cannot be played."""
        self._bus = bus
        params = self._params
        self._report("opening")
        self._epoch, self._corrections = new_epoch(), 0
        self._corrected: deque[PoseCorrection] = deque(maxlen=params.window)
        self._specs = IngestSpecs(
            params.source, params.keyframes, params.odometry, params.pose_graph
        )
        self._source = open_source(self._specs)
        connect = getattr(self._source, "connect", None)
        self._is_live = connect is not None
        if connect is not None:
            connect(bus)
        self._rewind()
        for verb in VERBS:
            bus.serve(CONTROL, self._control, node=self._context.node, verb=verb)
        if self._pacer is None:
            self._hear()
        self._wait_until_s = time.monotonic() + params.wait_s
        self._next_poll_s = 0.0
        self._report("waiting")

    def step(self, received: Received | None) -> None:
        """Take an acknowledgement, send again what is overdue, then play what is due."""
        now_s = time.monotonic()
        if received is not None:
            self._window.acknowledge(received.message.frame_seq, now_s)
            self._arrival.acknowledge(received.message.frame_seq)
            self._meet(received.message)
        self._resend(now_s)
        if self._state == "waiting" and self._graph_is_there(now_s):
            self._report("playing")
        if self._arrival.idle() and self._state in ("ending", "finished"):
            self._report("playing")
        burst_end_s = now_s + BURST_S
        while self._state == "playing" and self._is_due(now_s) and now_s < burst_end_s:
            if not self._play(now_s):
                break
            now_s = time.monotonic()
        if self._state == "ending" and not len(self._window):
            self._report("finished")
            log.info("finished: %d frames, %d keyframes", self._frames, self._keyframes)

    def close(self) -> None:
        """Let go of keyframes that wait for their place, and of a camera."""
        self._arrival.close()
        close = getattr(self._source, "close", None)
        if close is not None:
            close()

    def _rewind(self) -> None:
        params = self._params
        # A live source knows its cameras from the first frame on.
        self._ingestor = None if self._is_live else new_ingestor(self._source, self._specs)
        self._raw: Iterator[RawFrame | Skipped | Waiting] = self._source.frames()
        paced = self._pacer is not None
        self._arrival = Arrival(params.arrival, self._bus, self._context, paced=paced)
        self._window: Window[Frame] = Window(params.window, params.resend_s, params.tries)
        self._frames = self._keyframes = 0
        self._last_seq = -1
        self._lost: set[int] = set()

    def _meet(self, delta: ViewDelta) -> None:
        """Start again when mapping or views did: the map, or the pictures, are lost.

        What the map still holds is acknowledged without being integrated again.
        """
        if not delta.map_epoch or self._pacer is not None:
            return  # views does not know the map yet, or frames may be lost
        before, self._readers = self._readers, (delta.epoch, delta.map_epoch)
        lost = before not in (None, self._readers) and self._state in ("playing", "ending")
        if lost and self._replays < self._params.replays:
            log.warning("mapping or views have started again, and so does the source")
            self._replays += 1
            self._bus.count("replays")
            self._arrival.close()
            self._rewind()
            self._report("playing")

    def _control(self, request: Request) -> Reply | None:
        return control(self._source, request)

    def _is_due(self, now_s: float) -> bool:
        if self._pacer is None:
            return self._window.has_room()
        return self._is_live or self._pacer.is_due(now_s)

    def _play(self, now_s: float) -> bool:
        """Read the next source frame and publish what it gives; tell whether there was one."""
        if (held := self._next_held()) is not None:
            self._publish(held, was_held=True)
            return True
        raw = next(self._raw, None)
        if raw is None and not self._arrival.is_under_way:
            self._report("ending")
        if raw is None or isinstance(raw, Waiting):
            return False
        if self._pacer and not self._is_live and self._pacer.take(now_s):
            self._bus.count("frames_late")
        result = raw if isinstance(raw, Skipped) else self._ingest(raw)
        if isinstance(result, Skipped):
            log.warning("frame %d skipped: %s: %s", result.seq, result.where, result.reason)
            self._bus.count("frames_skipped")
            if result.where == self._params.odometry["kind"]:
                self._bus.count("tracking_lost")
        elif (frame := self._arrival.take(result)) is not None:
            self._publish(frame)
        return True

    def _hear(self) -> None:
        """Hear what has come, from the first keyframe on that must not be lost."""
        if not self._hears:
            depth, self._hears = 4 * self._params.window, True
            self._bus.subscribe(VIEW_DELTA, depth=depth, scene=self._context.scene)

    def _next_held(self) -> Ingested | None:
        """Return a keyframe that was held: it goes as if lossless, for it is nowhere else."""
        if not self._arrival.is_releasing or not self._window.has_room():
            return None
        self._hear()
        return self._arrival.next()

    def _ingest(self, raw: RawFrame) -> Ingested | Skipped:
        if self._ingestor is None:
            self._ingestor = new_ingestor(self._source, self._specs)
        return self._ingestor.ingest(raw)

    def _publish(self, frame: Ingested, *, was_held: bool = False) -> None:
        self._frames += 1
        is_keyframe = frame.keyframe is not None
        pose = (frame.seq, frame.stamp_ns, frame.T_world_camera, frame.pose_source, is_keyframe)
        if self._arrival.is_own(frame.seq):  # where a robot is that left is nobody's news
            self._bus.publish(POSE, Pose(*pose), robot=self._context.robot)
        if frame.corrected:
            self._publish_correction(frame)
        if frame.keyframe is not None:
            self._keyframes += 1
            codecs = self._params.rgb_codec, self._params.depth_codec
            message = frame_message(frame.keyframe, *codecs)
            if self._pacer is None:
                first = self._last_seq < 0
                message = replace(message, after=message.seq if first else self._last_seq)
                self._last_seq = message.seq
            if self._pacer is None or was_held:
                self._window.sent(message.seq, message, time.monotonic())
            self._publish_keyframe(message)
        self._report(self._state)

    def _publish_correction(self, frame: Ingested) -> None:
        """Tell, before the keyframe that showed it, which earlier poses were wrong."""
        self._corrections += 1
        correction = correction_message(frame, self._epoch, self._corrections)
        self._corrected.append(correction)
        self._bus.publish(POSE_CORRECTION, correction, robot=self._context.robot)
        self._bus.count("corrections")
        log.info("keyframe %d corrects %d poses", frame.seq, len(frame.corrected))

    def _publish_keyframe(self, message: Frame) -> None:
        context = self._context
        if message.after in self._lost:
            message = replace(message, after=-1)
        self._bus.publish(FRAME, message, robot=context.robot, sensor=context.sensor)

    def _resend(self, now_s: float) -> None:
        for message in self._window.overdue(now_s):
            self._bus.count("frames_resent")
            for correction in self._corrected:
                if correction.frame_seq == message.seq:
                    self._bus.publish(POSE_CORRECTION, correction, robot=self._context.robot)
            self._publish_keyframe(message)
        for seq in self._window.lost(now_s):
            log.error("keyframe %d lost: sent %d times, no view delta", seq, self._params.tries)
            self._bus.count("frames_lost")
            self._lost.add(seq)
            self._arrival.give_up(seq)

    def _graph_is_there(self, now_s: float) -> bool:
        if now_s < self._next_poll_s:
            return False
        self._next_poll_s = now_s + ALIVE_POLL_S
        missing = set(self._params.wait_for) - self._bus.alive()
        if missing and now_s >= self._wait_until_s:
            log.warning("starting without %s", ", ".join(sorted(missing)))
            return True
        return not missing

    def _report(self, state: str) -> None:
        self._state = state
        self._bus.report(state=state, frames=self._frames, keyframes=self._keyframes)
