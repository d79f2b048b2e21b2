"""Questions to a routing node, from another process, beside a bare get of as many bytes."""

import json
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import count, cycle

from sceneq_core.encoding.encoder import Encoder
from sceneq_nodes._backends import build
from sceneq_nodes._client import Client
from sceneq_schemas.topics import QUERY_INSTANCES, QUERY_STATUS
from sceneq_tools.bench.bus import bare_get
from sceneq_tools.bench.measurement import Measurement, Options, in_turns_ms, latency
from sceneq_tools.bench.processes import helper, router, running
from sceneq_tools.bench.query_feeder import FEED, Fed, text_from
from sceneq_tools.errors import UserError

QUESTIONS = ("chair", "red mug", "table", "the picture on the wall", "a book", "lamp", "sofa")
TIMEOUT_S = 10.0
READY_S, POLL_S = 30.0, 0.1
LEAST = 20
MAPPING_HZ = 10.0
"""Keyframes a second: the goal for the mapping on two cores."""
BARE, TOWER = "bare get of its bytes", "bare get + text tower"


def query(options: Options) -> Iterator[Measurement]:
    """Ask what was asked before, and what never was, at rest and while the map changes."""
    with (
        router() as endpoint,
        helper("sceneq_tools.bench.echo", endpoint),
        helper("sceneq_tools.bench.query_feeder", endpoint, text_from(options)) as told,
        Client(endpoint) as client,
    ):
        fed = Fed(**json.loads(told))
        with routing(endpoint, client, fed):
            yield from _measured(client, fed, options.seconds)


def _measured(client: Client, fed: Fed, seconds: float) -> Iterator[Measurement]:
    encoder: Encoder = build("encoder", fed.params.get("encoder", {"kind": "conse"}), ("encoder",))
    sizes = [ask(client, fed.scene, text) for text in QUESTIONS]
    size, number = round(sum(sizes) / len(sizes)), count()
    yield Measurement("answer", size / 1000, "kB")
    known = cycle(QUESTIONS)
    works = (
        lambda: bare_get(client, size),
        lambda: ask(client, fed.scene, next(known)),
        lambda: ask(client, fed.scene, f"thing number {next(number)}"),
        lambda: encoder.encode_texts([f"thing number {next(number)}"]),
    )
    for when, hz in (("", 0.0), (f" while mapping at {MAPPING_HZ:g}/s", MAPPING_HZ)):
        client.get(f"{FEED.key()}?hz={hz}", timeout_s=TIMEOUT_S)
        bare, again, fresh, tower = in_turns_ms(works, seconds, warm_ups=3, least=LEAST)
        beside = [one + other for one, other in zip(bare, tower, strict=True)]
        yield from latency(f"question asked before{when},", again, BARE, bare)
        yield from latency(f"new question{when},", fresh, TOWER, beside)


@contextmanager
def routing(endpoint: str, client: Client, fed: Fed) -> Iterator[None]:
    """Run the routing node of the graph in a process of its own, once it has caught up.

    Raises:
        ConnectionError: it ends, or does not within ``READY_S``.
    """
    said = [f"--param={name}={json.dumps(value)}" for name, value in fed.params.items()]
    command = ("routing", "--endpoint", endpoint, "--scene", fed.scene, *said)
    with running("sceneq_nodes", *command, errors=subprocess.DEVNULL) as process:
        end_s = time.monotonic() + READY_S
        while answerable(client, fed.scene) < fed.answerable:
            if (code := process.poll()) is not None:
                raise ConnectionError(f"the routing node ended with exit code {code}")
            if time.monotonic() > end_s:
                raise ConnectionError(f"the routing node is not ready after {READY_S:g} s")
            time.sleep(POLL_S)
        yield


def answerable(client: Client, scene: str) -> int:
    """Return how many instances the routing node answers with, -1 = it is not there."""
    replies, _ = client.get(QUERY_STATUS.key(scene=scene), timeout_s=TIMEOUT_S)
    return int(json.loads(replies[-1][1].payload)["answerable"]) if replies else -1


def ask(client: Client, scene: str, text: str) -> int:
    """Ask on the fast path; return the size of the answer in bytes.

    Raises:
        UserError: no answer, or an error.
    """
    selector = f"{QUERY_INSTANCES.key(scene=scene)}?q={text}"
    replies, errors = client.get(selector, timeout_s=TIMEOUT_S)
    if not replies:
        raise UserError(f"{selector}: {errors[0] if errors else 'nobody answers'}")
    return len(replies[-1][1].payload)
