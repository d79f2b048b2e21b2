"""Everything the viewer shows, in one recording, on common timelines."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from sceneq_core.mapping.replica import MapReplica
from sceneq_nodes._viewer_answers import AnswersLog, Json
from sceneq_nodes._viewer_camera import CameraLog
from sceneq_nodes._viewer_map import MapLog
from sceneq_nodes._viewer_series import DELAYS, LOST, RATES, STALE_S, Delays, Flows, Lines
from sceneq_schemas.errors import DecodeError
from sceneq_schemas.frame import Frame
from sceneq_schemas.mask import Masks

FRAME, STAMP = "frame", "stamp"
STAGES = ("masks", "map", "views", "descriptors", "answer")
REFRESH_S = 5.0
"""So often one block of the cloud is logged again: who comes when the server has forgotten how it
began sees all of the map as well, a little later."""


class Screen:
    """One recording; timelines ``frame`` (seq of the keyframe) and ``stamp`` (its capture time).

    Args:
        recording: a ``rerun.RecordingStream`` that somebody reads.
        clouds: entities of the clouds to show.
        max_points: of each cloud.
    """

    def __init__(self, recording: Any, clouds: Sequence[str], max_points: int) -> None:
        self._recording = recording
        self._map = MapLog(recording, clouds, max_points)
        self._camera = CameraLog(recording)
        self._answers = AnswersLog(recording)
        self._flows, self._delays = Flows(), Delays()
        self._rates, self._lost = Lines(RATES, STALE_S), Lines(LOST)
        self._delay_lines = Lines(DELAYS, known=STAGES)
        self._reached: dict[str, int] = {}
        self._refresh_due_s = 0.0
        self._answer: Json | None = None
        self._answer_is_new = False

    def frame(self, frame: Frame, now_s: float) -> None:
        """Show a keyframe; raise ``DecodeError`` when it is none."""
        self._set_time(frame.seq, frame.stamp_ns)
        self._delays.start(frame.seq, now_s)
        self._camera.frame(frame)

    def masks(self, masks: Masks, now_s: float) -> None:
        """Show the segments of a keyframe."""
        self._set_time(masks.seq, masks.stamp_ns)
        self._camera.masks(masks)
        self.reach("masks", masks.seq, now_s)

    def reach(self, stage: str, seq: int, now_s: float) -> None:
        """Note that keyframe ``seq`` has come to this stage; the first time counts."""
        delay_ms = self._delays.since(seq, now_s)
        if delay_ms is not None and self._reached.get(stage) != seq:
            self._reached[stage] = seq
            self._delay_lines.set(stage, delay_ms, now_s)

    def metrics(self, message: Mapping[str, Any], now_s: float) -> None:
        """Take in the numbers of one node; raise ``DecodeError`` when they are none."""
        node, metrics = str(message.get("node")), message.get("metrics")
        if not isinstance(metrics, dict) or not all(map(_is_number, metrics.values())):
            raise DecodeError(f"metrics of {node:.40}: not numbers by name")
        rate_hz, lost = self._flows.take(node, metrics)
        self._rates.set(node, rate_hz, now_s)
        self._lost.set(node, lost, now_s)

    def series(self, now_s: float) -> None:
        """Show rates, losses and delays as they are now."""
        for lines in (self._rates, self._lost, self._delay_lines):
            lines.log(self._recording, now_s)

    def needs_map(self, now_s: float) -> bool:
        """Tell whether there is something to show although the map has not changed."""
        return self._answer_is_new or now_s >= self._refresh_due_s

    def map(self, replica: MapReplica, captions: Mapping[int, str], now_s: float) -> int:
        """Show the map; return the number of points that had to be logged."""
        if replica.frame_seq < 0:
            return 0
        self._set_time(replica.frame_seq, replica.stamp_ns)
        if now_s >= self._refresh_due_s:
            self._map.forget_oldest()
            self._answers.repeat()
            self._camera.repeat()
            self._refresh_due_s = now_s + REFRESH_S
        self._answer_is_new = False
        if self._answer is not None:
            self._answers.mark(self._answer, replica)
        return self._map.log(replica, captions)

    @property
    def answer_id(self) -> str:
        """Which answer is shown, "" = none."""
        return "" if self._answer is None else str(self._answer["query_id"])

    def answer(
        self,
        answer: Json,
        earlier: Sequence[Json],
        pictures: Sequence[bytes | None],
        now_s: float,
    ) -> None:
        """Show an answer, its words and the pictures behind it; the next map has it marked."""
        self._answer, self._answer_is_new = answer, True
        self._answers.text(answer, earlier)
        self._answers.evidence(answer, pictures)
        self._delay_lines.set("answer", float(answer["took_ms"]), now_s)

    def _set_time(self, seq: int, stamp_ns: int) -> None:
        self._recording.set_time(FRAME, sequence=seq)
        self._recording.set_time(STAMP, timestamp=np.datetime64(stamp_ns, "ns"))


def _is_number(value: object) -> bool:
    return isinstance(value, int | float)
