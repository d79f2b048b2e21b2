"""Ingest, segmentation, mapping and views on one hub, with or without files."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from sceneq_core.mapping.mapper import MapperParams
from sceneq_core.mapping.replica import MapReplica
from sceneq_nodes._arrival_params import ArrivalParams
from sceneq_nodes._bus import Context
from sceneq_nodes._convert import map_delta_from_message
from sceneq_nodes._wire import from_bytes
from sceneq_nodes.ingest import Ingest, IngestParams
from sceneq_nodes.mapping import Mapping, MappingParams
from sceneq_nodes.segmentation import Segmentation, SegmentationParams
from sceneq_nodes.views import Views, ViewsParams
from sceneq_schemas.topics import MAP_SNAPSHOT, VISIT
from sceneq_tools.local_bus import LocalBus, LocalHub

COARSE = MapperParams(voxel_size_m=0.05)
"""Fine enough to tell boxes of half a metre, and quick."""
KEYFRAMES = {"kind": "every", "every": 1}


class KeptScene:
    """The nodes of one scene; each robot that comes has an ingest of its own.

    Robots' masks are read from ``masks`` by frame number, so robots share one folder of them.
    """

    def __init__(self, folder: Path | None, masks: Path, robots=(), **mapping) -> None:
        self.hub = LocalHub()
        self._is_closed = False
        self.context = Context("test", "room", "r1", "cam", folder)
        segmenter = {"kind": "files", "path": str(masks)}
        self._add("views", Views, ViewsParams(robots=robots))
        self._add("mapping", Mapping, MappingParams(mapper=COARSE, robots=robots, **mapping))
        self._add("segmentation", Segmentation, SegmentationParams(segmenter, robots=robots))

    def _add(self, name, node_class, params):
        context = replace(self.context, node=name)
        node = node_class(params, context)
        self.hub.add(node, context)
        return node

    def come(self, recording: Path, robot: str | None = None, rate_hz=None, **arrival) -> str:
        """Start a robot's ingest, by default without loss; return its name."""
        name = f"ingest-{robot or 'r1'}"
        params = IngestParams(
            {"kind": "folder", "path": str(recording)},
            rate_hz=rate_hz,
            keyframes=KEYFRAMES,
            arrival=ArrivalParams(**{"look_again_s": 0.0, "settle_s": 0.0} | arrival),
            robot=robot,
            wait_for=(),
        )
        self._add(name, Ingest, params)
        return name

    def play(self, *names: str) -> None:
        """Let robots play to the end, a step each in turn."""
        while not all(self.hub.reported[name]["state"] == "finished" for name in names):
            for name in names:
                self.hub.idle(name)

    def visit(self, recording: Path, robot: str | None = None, **arrival) -> dict:
        """Play one recording to its end; return what ingest reported last."""
        name = self.come(recording, robot, **arrival)
        self.play(name)
        return self.hub.reported[name]

    def ask(self, topic, payload=b"", **parameters):
        bus = LocalBus(self.hub, self.context)
        replies = bus.ask(topic, parameters=parameters, payload=payload, scene="room")
        return from_bytes(topic, replies[-1].payload)

    def visits(self):
        """Return what mapping knows of who came."""
        return self.ask(VISIT)["visits"]

    def map(self) -> MapReplica:
        """Return the map as a reader gets it."""
        replica = MapReplica()
        replica.apply(map_delta_from_message(self.ask(MAP_SNAPSHOT)))
        return replica

    def things(self):
        """Return the instances of the map that are objects."""
        return [i for i in self.map().instances.values() if i.state != "removed"]

    def frames(self):
        """Return the numbers of the frames that are in the map."""
        return set(self.hub.nodes["mapping"]._mapped._done)

    def views_of(self, instance_id: int):
        """Return the frame numbers of the views that were chosen of an instance."""
        sets = self.hub.nodes["views"]._selector.view_sets()
        return [view.seq for one in sets if one.instance_id == instance_id for view in one.views]

    def close(self) -> None:
        """Close every node, once."""
        if not self._is_closed:
            self._is_closed = True
            self.hub.close()


def surface_error_m(replica: MapReplica, room) -> float:
    """Return how far the 95th percentile of the map's surface is from the room's walls."""
    half = np.asarray(room.half)
    points = replica.points_world[replica.alive]
    outside = np.abs(points - [0, 0, half[2]]) - half
    return float(np.percentile(outside.max(axis=1), 95))
