"""A mapping node with a store, which can be killed and come back."""

from dataclasses import replace
from pathlib import Path

from sceneq_core.mapping.digest import map_digest
from sceneq_core.mapping.replica import MapReplica
from sceneq_nodes._convert import map_delta_from_message
from sceneq_nodes._images import frame_message
from sceneq_nodes._store_params import StoreParams
from sceneq_nodes._wire import from_bytes
from sceneq_nodes.mapping import Mapping, MappingParams
from sceneq_schemas.mask import Masks
from sceneq_schemas.topics import FRAME, MAP_SNAPSHOT, MASK

from support.fake_bus import CONTEXT, FakeBus
from support.killed_files import leave_as_killed
from support.open_nodes import opened
from support.room import Room
from support.surfaces import SMALL, room_frames

VIEWS = room_frames(6, Room(size=(120, 90), focal_px=97.5))
EVERY_TIME = StoreParams(replay_s=0.0, share=1.0)
"""A checkpoint after every keyframe, unless one is being written."""
NEVER = StoreParams(replay_s=1e9)


class DurableMap:
    """A node on a bus of its own, with its files in ``folder``."""

    def __init__(self, folder: Path | None, store: StoreParams = NEVER, **params) -> None:
        self.bus = FakeBus(replace(CONTEXT, store=folder))
        params = {"mapper": SMALL, **params}
        self.node = Mapping(MappingParams(store=store, **params), self.bus.context)
        opened(self.node, self.bus)

    def show(self, *numbers: int) -> "DurableMap":
        """Deliver keyframes with their masks; wait for a checkpoint if one is being written."""
        for number in numbers:
            frame, instance = VIEWS[number]
            self.bus.deliver(self.node, FRAME, frame_message(frame, "raw", "raw"))
            self.bus.deliver(self.node, MASK, Masks(frame.seq, frame.stamp_ns, instance))
            self.settle()
        return self

    def settle(self) -> None:
        """Wait for the checkpoint that is being written."""
        if hasattr(self.node._store, "_writer"):
            self.node._store._writer.wait()

    def kill(self) -> None:
        """Leave the files as a killed process does: closing them would tidy them up."""
        self.settle()
        leave_as_killed(self.bus.context.store / "map", self.node.close)

    def snapshot(self):
        """Return the whole map as a reader gets it."""
        return from_bytes(MAP_SNAPSHOT, self.bus.query(MAP_SNAPSHOT).payload)

    def digest(self) -> str:
        """Return the digest of the map as a reader knows it."""
        replica, delta = MapReplica(), map_delta_from_message(self.snapshot())
        replica.apply(delta)
        coord = replica.voxel_coord[replica.alive]
        owner = replica.instance_of_voxel()[replica.alive]
        return map_digest(coord, replica.points_world[replica.alive], owner)
