"""Corrections of poses on their way into the map."""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from hashlib import sha256

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.ingest.ingestor import Ingested
from sceneq_core.mapping.correction import Correction
from sceneq_core.visits import visit_of
from sceneq_schemas.correction import PoseCorrection
from sceneq_schemas.frame import Frame

MAX_WAITING = 64
"""More corrections than that for frames still to come are no robot's."""
REMEMBERED = 4096
"""So many that came are known when they come again."""


class Corrections:
    """Holds a correction back until the frame from which on it holds is next.

    So a map made live equals one made from the recording, however long messages take, and however
    often an odometry that begins anew comes to the same corrections.
    """

    def __init__(
        self,
        waiting: Iterable[PoseCorrection] = (),
        poses: Mapping[int, Float64] | None = None,
        came: Mapping[int, bytes] | None = None,
    ) -> None:
        """Go on with what ``parts`` of another gave."""
        self._waiting = list(waiting)
        self._poses = dict(poses or {})
        self._came = dict(came or {})

    def parts(self) -> tuple[list[PoseCorrection], dict[int, Float64], dict[int, bytes]]:
        """Return the corrections that wait, the newest poses by frame, and a digest of the last
        correction of each frame.
        """
        return list(self._waiting), dict(self._poses), dict(self._came)

    def offer(self, message: PoseCorrection) -> bool:
        """Take a correction, unless it came before; tell whether there was room for it."""
        digest = _digest(message)
        if self._came.get(message.frame_seq) == digest:
            return True
        if len(self._waiting) >= MAX_WAITING:
            return False
        self._waiting.append(message)
        self._came[message.frame_seq] = digest
        if len(self._came) > REMEMBERED:
            del self._came[next(iter(self._came))]
        return True

    def due(self, frame_seq: int) -> list[PoseCorrection]:
        """Return, and forget, those that hold from ``frame_seq`` or an earlier frame on."""
        due = [message for message in self._waiting if _is_due(message, frame_seq)]
        self._waiting = [message for message in self._waiting if not _is_due(message, frame_seq)]
        for message in due:
            visit = visit_of(message.frame_seq)
            others = {seq: pose for seq, pose in self._poses.items() if visit_of(seq) != visit}
            known = others if message.full else self._poses
            self._poses = known | dict(
                zip(message.keyframe_seq.tolist(), message.T_world_camera, strict=True)
            )
        return due

    def corrected(self, frame: Frame) -> Frame:
        """Return ``frame``, which was on its way meanwhile, with its newest pose."""
        pose = self._poses.get(frame.seq)
        return frame if pose is None else replace(frame, T_world_camera=pose)


def _digest(message: PoseCorrection) -> bytes:
    """Return what tells the poses of a correction from all others."""
    parts = message.keyframe_seq.tobytes(), message.T_world_camera.tobytes()
    return sha256(b"".join(parts)).digest()


def _is_due(message: PoseCorrection, frame_seq: int) -> bool:
    """Tell whether ``message`` holds from an earlier frame of the same visit on."""
    is_same = visit_of(message.frame_seq) == visit_of(frame_seq)
    return is_same and message.frame_seq <= frame_seq


def correction_message(frame: Ingested, epoch: int, number: int) -> PoseCorrection:
    """Return what ``frame`` tells of the poses of earlier ones; the ``number``-th of ``epoch``."""
    seqs = np.array(list(frame.corrected), np.int64)
    poses = np.stack(list(frame.corrected.values()))
    return PoseCorrection(epoch, number, True, frame.seq, frame.stamp_ns, seqs, poses)


def correction_of(message: PoseCorrection) -> Correction:
    """Return what ``message`` says about poses."""
    return Correction(message.keyframe_seq, message.T_world_camera)
