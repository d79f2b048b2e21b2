"""Questions to a map, from another process, beside a bare get of as many bytes."""

from collections.abc import Iterator
from itertools import count, cycle

from sceneq_nodes._client import Client
from sceneq_schemas.topics import QUERY_INSTANCES
from sceneq_tools.bench.bus import bare_get
from sceneq_tools.bench.measurement import Measurement, Options, latency, samples_ms
from sceneq_tools.bench.processes import helper, router
from sceneq_tools.bench.query_server import text_from
from sceneq_tools.errors import UserError

QUESTIONS = ("chair", "red mug", "table", "the picture on the wall", "a book", "lamp", "sofa")
TIMEOUT_S = 10.0
BESIDE = "bare get of its bytes"


def query(options: Options) -> Iterator[Measurement]:
    """Ask what was asked before, and what never was: that goes through the text tower."""
    with (
        router() as endpoint,
        helper("sceneq_tools.bench.echo", endpoint),
        helper("sceneq_tools.bench.query_server", endpoint, text_from(options)) as scene,
        Client(endpoint) as client,
    ):
        yield from _measured(client, scene, options.seconds)


def _measured(client: Client, scene: str, seconds: float) -> Iterator[Measurement]:
    known, number = cycle(QUESTIONS), count()
    sizes = [ask(client, scene, text) for text in QUESTIONS]
    size = round(sum(sizes) / len(sizes))
    bare = samples_ms(lambda: bare_get(client, size), seconds, warm_ups=3)
    again = samples_ms(lambda: ask(client, scene, next(known)), seconds)
    fresh = samples_ms(lambda: ask(client, scene, f"thing number {next(number)}"), seconds)
    yield Measurement("answer", size / 1000, "kB")
    yield from latency("question asked before,", again, BESIDE, bare)
    yield from latency("new question,", fresh, BESIDE, bare)


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
