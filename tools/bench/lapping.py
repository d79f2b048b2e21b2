"""The mapping node alone in its process, for the bench of laps.

    python -m sceneq_tools.bench.lapping NODE      # NODE: context and parameters as JSON

Reads keyframes, each a header and the bytes of a frame and of its masks; prints for each how much
processor time decoding and mapping it took, and what the process holds then. Ends with its input.
"""

import json
import struct
import sys
import time
from typing import Any, BinaryIO

from sceneq_nodes._backends import load
from sceneq_nodes._bus import Context, Node, Received
from sceneq_nodes._params import validate
from sceneq_nodes._wire import from_bytes
from sceneq_schemas.topics import FRAME, MASK, Topic
from sceneq_tools.bench.stages import held_mib
from sceneq_tools.local_bus import LocalHub

HEADER = struct.Struct("<II")
MAPPING = "mapping"


def main() -> None:
    """Map keyframes until standard input ends."""
    said = json.loads(sys.argv[1])
    node = open_node(Context(**said["context"]), said["params"])
    while header := sys.stdin.buffer.read(HEADER.size):
        frame, masks = (_read(sys.stdin.buffer, size) for size in HEADER.unpack(header))
        start_s = time.process_time()
        for topic, data in ((FRAME, frame), (MASK, masks)):
            node.step(_received(topic, data))
        taken_ms = 1000 * (time.process_time() - start_s)
        print(taken_ms, held_mib(), flush=True)


def open_node(context: Context, params: dict[str, Any]) -> Node:
    """Return the mapping node with nobody around it."""
    cls = load("nodes", MAPPING)
    node: Node = cls(validate(cls.Params, params, (MAPPING,)), context)
    LocalHub().add(node, context)
    return node


def _received(topic: Topic, data: bytes) -> Received:
    return Received(topic, topic.name, {}, from_bytes(topic, data))


def _read(stream: BinaryIO, size: int) -> bytes:
    data = stream.read(size)
    if len(data) < size:
        raise EOFError(f"{len(data)} of {size} bytes")
    return data


if __name__ == "__main__":
    main()
