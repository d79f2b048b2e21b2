"""Plays the journal of a kept map to the nodes of another one, moved to where it belongs there."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np

from sceneq_core.arrays import Float64, Int64
from sceneq_core.ingest.transforms import nearest_rigid, transform
from sceneq_core.visits import seq_in_scene, seq_of, visit_of
from sceneq_nodes._bus import Bus, Context, Received
from sceneq_nodes._journal import Entry
from sceneq_nodes._mapped import CORRECTION, GIVEN, KEYFRAME, MAX_GIVEN_BYTES, PROPOSED
from sceneq_nodes._wire import from_bytes
from sceneq_schemas.codec import decode
from sceneq_schemas.proposal import ProposalSet
from sceneq_schemas.topics import FRAME, MASK, POSE_CORRECTION, PROPOSAL


class JournalPlayer:
    """A node that publishes one entry each idle step.

    Args:
        entries: of the other map's journal, from the first on.
        T_world_other: (4, 4) where that map lies in this one.
        visits: the number here of each of its visits.

    Attributes:
        keyframes: how many were played.
        is_done: whether all were.
    """

    Params: ClassVar[type] = object
    idle_s: ClassVar[float] = 0.0

    def __init__(
        self, entries: Iterator[Entry], T_world_other: Float64, visits: Mapping[int, int]
    ) -> None:
        self.keyframes = 0
        self.is_done = False
        self._entries = entries
        self._T_world_other = T_world_other
        self._visits = visits

    def open(self, bus: Bus) -> None:
        """Publish on ``bus``."""
        self._bus = bus
        context: Context = bus.context
        self._robot, self._sensor, self._scene = context.robot, context.sensor, context.scene

    def step(self, received: Received | None) -> None:
        """Publish what the next entry holds."""
        entry = next(self._entries, None)
        if entry is None:
            self.is_done = True
        elif entry.kind == KEYFRAME:
            self._play_keyframe(entry)
        elif entry.kind == CORRECTION:
            self._play_correction(from_bytes(POSE_CORRECTION, entry.first))
        elif entry.kind in (PROPOSED, GIVEN):
            self._play_proposals(decode(ProposalSet, entry.first, MAX_GIVEN_BYTES))

    def close(self) -> None:
        """Nothing to release."""

    def _play_keyframe(self, entry: Entry) -> None:
        frame, masks = from_bytes(FRAME, entry.first), from_bytes(MASK, entry.second)
        seq, pose = self._seq(frame.seq), self._pose(frame.T_world_camera)
        moved = replace(frame, seq=seq, T_world_camera=pose, after=-1)
        self._bus.publish(FRAME, moved, robot=self._robot, sensor=self._sensor)
        self._bus.publish(MASK, replace(masks, seq=seq), scene=self._scene)
        self.keyframes += 1

    def _play_correction(self, correction: Any) -> None:
        seqs: Int64 = np.array([self._seq(n) for n in correction.keyframe_seq.tolist()], np.int64)
        poses = [self._pose(pose) for pose in correction.T_world_camera]
        moved = replace(
            correction,
            frame_seq=self._seq(correction.frame_seq),
            keyframe_seq=seqs,
            T_world_camera=np.array(poses).reshape(-1, 4, 4),
        )
        self._bus.publish(POSE_CORRECTION, moved, robot=self._robot)

    def _play_proposals(self, proposals: ProposalSet) -> None:
        points = transform(self._T_world_other, proposals.points_world.astype(np.float64))
        moved = replace(proposals, points_world=points.astype(np.float32))
        self._bus.publish(PROPOSAL, moved, scene=self._scene)

    def _seq(self, seq: int) -> int:
        return seq_in_scene(self._visits[visit_of(seq)], seq_of(seq))

    def _pose(self, T_other_camera: Float64) -> Float64:
        return nearest_rigid(self._T_world_other @ T_other_camera)
