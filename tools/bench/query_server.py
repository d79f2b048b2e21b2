"""The map of a recording behind its real query key, for the bench of queries.

    python -m sceneq_tools.bench.query_server ENDPOINT OPTIONS   # options as JSON

Prints the scene when it answers; ends with its input.
"""

import json
import sys
from dataclasses import asdict
from pathlib import Path

from sceneq_nodes._bus import Context, Reply, Request
from sceneq_nodes._counters import Counters
from sceneq_nodes._runtime import ZenohBus
from sceneq_schemas.topics import QUERY_INSTANCES
from sceneq_tools.batch import Batch
from sceneq_tools.bench.measurement import Options
from sceneq_tools.bench.recording import open_batch, play

NODE = "bench"


def main() -> None:
    """Make the map, then answer until standard input ends."""
    batch = open_batch(options_from(sys.argv[2]))
    play(batch, options_from(sys.argv[2]))
    bus = ZenohBus(Context(NODE, batch.scene, NODE, NODE), sys.argv[1], Counters())
    bus.serve(QUERY_INSTANCES, lambda request: _answer(batch, request), scene=batch.scene)
    bus.announce(NODE)
    print(batch.scene, flush=True)
    sys.stdin.read()
    bus.close()
    batch.close()


def text_from(options: Options) -> str:
    """Return the options as one argument of a command."""
    plain = asdict(options)
    for name in ("source", "graph"):
        plain[name] = None if plain[name] is None else str(plain[name])
    return json.dumps(plain)


def options_from(text: str) -> Options:
    """Return the options in an argument."""
    plain = json.loads(text)
    for name in ("source", "graph"):
        plain[name] = None if plain[name] is None else Path(plain[name])
    return Options(**plain)


def _answer(batch: Batch, request: Request) -> Reply | None:
    return batch.get(QUERY_INSTANCES, request.parameters)


if __name__ == "__main__":
    main()
