"""Instances that are looked through: in doubt, then stale, moved or gone."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Int32
from sceneq_core.mapping.chronicle import Chronicle
from sceneq_core.mapping.delta import CONFIRMED, STALE, TENTATIVE, Instance
from sceneq_core.mapping.doubt import Doubt, DoubtParams
from sceneq_core.mapping.lifecycle import Life
from sceneq_core.mapping.members import Members
from sceneq_core.mapping.presence import Look, Presence
from sceneq_core.mapping.recognition import Recognition


@dataclass(frozen=True, slots=True)
class Gone:
    """What is not there any more: ``voxel_id`` to be cleared, ``group`` to be dissolved, int32."""

    voxel_id: Int32
    group: Int32


class Vanishing:
    """Holds the looks of every keyframe against the instances."""

    def __init__(
        self,
        params: DoubtParams,
        presence: Presence,
        recognition: Recognition,
        chronicle: Chronicle,
    ) -> None:
        self._params = params
        self._presence = presence
        self._recognition = recognition
        self._chronicle = chronicle

    def look(self, look: Look, lives: dict[int, Life], members: Callable[[int], Members]) -> Gone:
        """Doubt the instances that the keyframe looks through; return what is not there.

        ``lives`` are those of the groups; the ones that end are left out of it.
        """
        gone_id, dissolved = [look.gone_id], []
        rows = (look.group, look.seen, look.through, look.lost)
        for group, seen, through, lost in zip(*(row.tolist() for row in rows), strict=True):
            life = lives.get(group)
            if life is None or not life.instance_id or not (through or life.doubt):
                continue
            raised = self._raise_doubt(life, seen, through, lost)
            if life.doubt and life.doubt.is_decided(self._params):
                rest_id, ended = self._decide(life, life.doubt, members(group), look.gone_id)
                gone_id.append(rest_id)
                dissolved += [group] * ended
            elif life.doubt and not raised:
                self._settle(life, life.doubt, members(group))
        for group in dissolved:
            del lives[group]
        return Gone(np.unique(np.concatenate(gone_id)), np.array(dissolved, np.int32))

    def _raise_doubt(self, life: Life, seen: int, through: int, lost: int) -> bool:
        """Return whether the keyframe contradicts the instance, and take note if so."""
        instance, now_ns = self._chronicle.instances[life.instance_id], self._chronicle.now_ns
        if not self._params.raised(seen, through, instance.voxel_count):
            if life.doubt:
                life.doubt.lost += lost
            return False
        life.doubt = life.doubt or Doubt(now_ns, instance)
        life.doubt.add(through, lost, now_ns)
        if life.state == TENTATIVE:
            life.unsettle(now_ns)
        if life.state == CONFIRMED and life.doubt.is_stale(self._params):
            self._chronicle.enter(life, STALE, "stale")
        return True

    def _decide(
        self, life: Life, doubt: Doubt, members: Members, gone_id: Int32
    ) -> tuple[Int32, bool]:
        """Return which voxels go with those that are gone, and whether the instance does."""
        voxel_id = members.voxel_id[~np.isin(members.voxel_id, gone_id)]
        seen = self._presence.seen_since(voxel_id, doubt.began_ns)
        fresh = seen & self._presence.born_since(voxel_id, doubt.began_ns)
        enough = self._params.kept_share * doubt.size
        life.doubt = None
        if fresh.sum() >= enough:
            self._move(life, doubt.before)
            return voxel_id[~seen], False
        if (seen & ~fresh).sum() >= enough:
            return voxel_id[:0], False
        self._vanish(life, doubt.before)
        return voxel_id[~seen], True

    def _move(self, life: Life, before: Instance) -> None:
        """Go on with an instance that was followed to another place."""
        if life.state != TENTATIVE:
            life.leave(before, self._chronicle.now_ns)
            self._chronicle.enter(life, CONFIRMED, "moved")

    def _vanish(self, life: Life, before: Instance) -> None:
        if life.state != TENTATIVE:
            self._recognition.vanish(before, life.placed_ns, self._chronicle.now_ns)
        self._chronicle.end(life.instance_id, "removed")

    def _settle(self, life: Life, doubt: Doubt, members: Members) -> None:
        """End the doubt when most of what is left was seen since it was last raised."""
        if self._chronicle.now_ns - doubt.last_ns < self._params.min_s * 1e9:
            return
        seen = self._presence.seen_since(members.voxel_id, doubt.last_ns + 1)
        if seen.sum() >= self._params.gone_share * len(seen):
            life.doubt = None
            if life.state == STALE:
                self._chronicle.enter(life, CONFIRMED, "seen_again")
