"""Many clients in one process: ``python -m sceneq_tools.chaos.client_worker``.

Its arguments are endpoint, scene, number of clients, questions each, seed and what to do: ``ask``
and end with a line of JSON; or ``forever``, after the line ``asking``; or ``listen`` to everything
there is, after the line ``listening``.
"""

import json
import random
import sys
import threading
import time
from collections import Counter
from typing import Any

from sceneq_nodes._client import Client
from sceneq_schemas.topics import QUERY_ASK, QUERY_INSTANCES, QUERY_STATUS

CONNECT_S = 20.0
TIMEOUT_S = 30.0
EVERYTHING = "sceneq/**"
WORDS = ("red thing", "table", "chair on the floor", "lamp", "how many boxes are there?", "mug")
ANSWERED, NOBODY = "answered", "nobody answered"


class Asking:
    """What all clients of a process were told, and how long it took, in milliseconds."""

    def __init__(self, endpoint: str, scene: str, seed: int) -> None:
        self.ends: Counter[str] = Counter()
        self.took_ms: list[float] = []
        self._endpoint = endpoint
        self._scene = scene
        self._seed = seed
        self._lock = threading.Lock()

    def ask(self, number: int, questions: int, start: threading.Barrier) -> None:
        """Be one client: connect, wait for the others, ask one question after the other."""
        with Client(self._endpoint, CONNECT_S) as client:
            start.wait()
            for selector in selectors(self._scene, questions, f"{self._seed} {number}"):
                began_s = time.perf_counter()
                end = asked(client, selector)
                took_ms = 1000 * (time.perf_counter() - began_s)
                with self._lock:
                    self.ends[end] += 1
                    self.took_ms.append(took_ms)

    def as_json(self) -> dict[str, Any]:
        """Return everything."""
        return {"ends": dict(self.ends), "took_ms": [round(ms, 1) for ms in self.took_ms]}


def asked(client: Client, selector: str) -> str:
    """Return how a question ended: answered, the code of an error, or not at all."""
    replies, errors = client.get(selector, timeout_s=TIMEOUT_S)
    if replies:
        return ANSWERED
    return errors[0].code if errors else NOBODY


def selectors(scene: str, count: int, seed: str) -> list[str]:
    """Return questions, no two clients the same: some were asked before, some never."""
    chance = random.Random(seed)
    found = []
    for number in range(count):
        topic = chance.choice((QUERY_INSTANCES, QUERY_ASK, QUERY_ASK, QUERY_STATUS))
        text = chance.choice(WORDS) + (f" {seed} {number}" if chance.random() < 0.3 else "")
        question = "" if topic is QUERY_STATUS else f"?q={text};k=3"
        found.append(f"{topic.key(scene=scene)}{question}")
    return found


def main(arguments: list[str]) -> None:
    """Do what the last argument says."""
    endpoint, scene, clients, questions, seed, what = arguments
    if what == "listen":
        _listen(endpoint)
    asking = Asking(endpoint, scene, int(seed))
    count, each = int(clients), int(questions)
    start = threading.Barrier(count + 1)
    ask = [threading.Thread(target=asking.ask, args=(n, each, start)) for n in range(count)]
    for thread in ask:
        thread.daemon = True
        thread.start()
    start.wait()
    print("asking", flush=True)
    for thread in ask:
        thread.join()
    print(json.dumps(asking.as_json()), flush=True)


def _listen(endpoint: str) -> None:
    with Client(endpoint, CONNECT_S) as client:
        client.subscribe(EVERYTHING, lambda key, encoding, payload: None)
        print("listening", flush=True)
        threading.Event().wait()


if __name__ == "__main__":
    main(sys.argv[1:])
