"""A visit that is not in the map yet: what it holds, and what is known of where that was seen."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.ingest.ingestor import Ingested
from sceneq_core.ingest.transforms import nearest_rigid
from sceneq_core.places.gazetteer import Gazetteer, GazetteerParams
from sceneq_core.places.place import PlaceParams, place_of
from sceneq_core.places.relocaliser import Relocaliser, Relocation
from sceneq_core.places.settling import Settling, SettlingParams
from sceneq_core.places.visit import Visit
from sceneq_core.visits import seq_in_scene
from sceneq_nodes._held_frames import HeldFrames

LOOKS = GazetteerParams(apart_m=0.1, apart_deg=5.0, most=64)
"""Which keyframes of an earlier run are looked at: none that shows what another one shows."""


class Submap:
    """The keyframes of one visit: held, looked at for their place, and then given to the map.

    Attributes:
        number: of the visit.
        T_world_odom: where its frame of reference lies, ``None`` as long as that is not known.
        held: the keyframes.
        relocaliser: knows how far recognition has come.
    """

    def __init__(self, visit: Visit, held: HeldFrames, relocaliser: Relocaliser) -> None:
        self.number, self.T_world_odom = visit.number, visit.T_world_odom
        self.held, self.relocaliser = held, relocaliser
        self._settling, self._camera_odom = Settling(SettlingParams()), np.zeros(3)
        self._places = Gazetteer(LOOKS)
        self._corrected: dict[int, Float64] = {}
        self._read, self._backlog = 0, held.last
        self._given = 0
        self._under_way: dict[int, int] = {}
        self._gone: set[int] = set()
        self._moved: dict[int, Float64] = {}

    @property
    def has_work(self) -> bool:
        """Whether ``study`` would learn something, or has an answer."""
        if self.T_world_odom is not None:
            return False
        has_more = self._read < self._backlog or self.relocaliser.has_to_look
        return has_more or self.is_sure

    @property
    def is_sure(self) -> bool:
        """Whether there is an answer, good enough to go by or not yet."""
        return self.T_world_odom is None and self._settling.sure is not None

    @property
    def is_releasing(self) -> bool:
        """Whether keyframes may go into the map and have not gone yet."""
        return self.T_world_odom is not None and self._given < self.held.last

    @property
    def is_over(self) -> bool:
        """Whether everything has gone, and nobody is waited for."""
        known = self.T_world_odom is not None
        return known and not self.is_releasing and not self._under_way

    def knows(self, seq: int) -> bool:
        """Tell whether it held keyframe ``seq`` of its own count before."""
        return seq <= self.held.newest_seq

    def hold(self, frame: Ingested) -> bool:
        """Keep a keyframe; tell whether the oldest was let go; raise ``StoreError``."""
        self.correct(frame.corrected)
        return self.held.add(frame)

    def correct(self, poses: Mapping[int, Float64]) -> None:
        """Take note of poses that are known better now."""
        self._corrected |= poses
        self._moved |= {seq: pose for seq, pose in poses.items() if seq in self._gone}

    def see(self, frame: Ingested) -> Relocation | None:
        """Look for the place of a keyframe just held; return it once it stands still."""
        assert frame.keyframe is not None
        self._camera_odom = frame.T_world_camera[:3, 3]
        return self._settle(self.relocaliser.see(place_of(frame.keyframe, PlaceParams())))

    def study(self, *, patient: bool = False) -> Relocation | None:
        """Look at one keyframe of an earlier run, or at one once more where the map has grown.

        When all is looked at, the answer is what it is, unless ``patient``: more is to come.

        Raises:
            StoreError, DamageError, DecodeError: it cannot be read.
        """
        if self._read >= self._backlog:
            if self.relocaliser.has_to_look:
                return self._settle(self.relocaliser.look_again())
            return None if patient else self._settling.sure
        frame, before = self._next_of_backlog(), self._places.revision
        if frame is None or frame.keyframe is None:
            return None
        self._places.visit(frame.keyframe)
        return None if self._places.revision == before else self.see(frame)

    def next(self) -> Ingested | None:
        """Return the next keyframe as one of the scene; it is held until ``acknowledge``.

        It brings what has become known since of the poses of those that went before.

        Raises:
            StoreError, DamageError, DecodeError: it cannot be read.
        """
        while self._read < self._backlog:  # what later ones say of the poses of earlier ones
            self._next_of_backlog()
        if (found := self.held.read(self._given)) is None:
            self._given = self.held.last
            return None
        self._given, frame = found
        pose = self._corrected.get(frame.seq, frame.T_world_camera)
        newest = replace(frame, T_world_camera=pose, corrected=self._moved)
        assert self.T_world_odom is not None
        moved = in_scene(newest, self.number, self.T_world_odom)
        self._gone.add(frame.seq)
        self._moved = {}
        self._under_way[moved.seq] = self._given
        return moved

    def acknowledge(self, seq: int) -> None:
        """Forget keyframe ``seq`` of the scene: it is in the map. Raises ``StoreError``."""
        if (position := self._under_way.pop(seq, None)) is not None:
            self.held.forget(position)

    def give_up(self, seq: int) -> None:
        """Do not wait for keyframe ``seq`` of the scene; it goes again at the next start."""
        self._under_way.pop(seq, None)

    def _settle(self, found: Relocation | None) -> Relocation | None:
        return self._settling.take(found, self._camera_odom)

    def _next_of_backlog(self) -> Ingested | None:
        if (found := self.held.read(self._read)) is None:
            self._read = self._backlog
            return None
        self._read, frame = found
        self.correct(frame.corrected)
        return frame


def in_scene(frame: Ingested, visit: int, T_world_odom: Float64) -> Ingested:
    """Return a frame of a visit with the scene's numbers, in the scene's frame of reference."""
    seq = seq_in_scene(visit, frame.seq)
    pose = nearest_rigid(T_world_odom @ frame.T_world_camera)
    corrected = {
        seq_in_scene(visit, old): nearest_rigid(T_world_odom @ T)
        for old, T in frame.corrected.items()
    }
    keyframe = frame.keyframe and replace(frame.keyframe, seq=seq, T_world_camera=pose)
    return replace(frame, seq=seq, T_world_camera=pose, keyframe=keyframe, corrected=corrected)
