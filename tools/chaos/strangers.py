"""Somebody who sends nonsense on every key, and a model server that is not there."""

import random
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from sceneq_nodes._client import Client
from sceneq_nodes._wire import from_bytes, json_bytes
from sceneq_schemas.codec import encode
from sceneq_schemas.errors import DecodeError
from sceneq_schemas.topics import QUERY_ASK, TOPICS, Delivery, Topic
from sceneq_tools.chaos.client_worker import ANSWERED, NOBODY, asked
from sceneq_tools.chaos.examples import EXAMPLES
from sceneq_tools.chaos.known import SCENE, files_of, live, settled, undisturbed
from sceneq_tools.chaos.live_graph import write_graph
from sceneq_tools.chaos.mutation import BYTES, MSGPACK, Mutator
from sceneq_tools.chaos.question_decoders import OBJECTS, SELECTORS
from sceneq_tools.chaos.scenario import NOTHING, Outcome, Plan

IDS = {"scene": SCENE, "robot": "robot", "sensor": "camera", "model": "hash-v1", "node": "mapping"}
PAUSE_S = 0.002
SILENT = (Delivery.QUERY, Delivery.LIVELINESS)
ENCODINGS = ("", "application/json", "application/msgpack")


def malformed(plan: Plan) -> Iterator[Outcome]:
    """Damaged messages on every key while a map grows, then damaged questions."""
    whole, count = undisturbed(plan), plan.pick(4_000, 400)
    with live(plan) as graph:
        graph.wait_until_begun()
        with Client(graph.endpoint, 20.0) as client:
            sent = send_nonsense(client, count, plan.seed)
            ends = ask_nonsense(client, plan.pick(1_000, 100), plan.seed)
        lost = settled(graph).lost(whole)
        nodes = graph.heard().values()
        counted = sum(node.flows["undecodable"] for node in nodes)
    detail = f"{counted} counted as undecodable by their readers"
    yield Outcome("malformed messages on every topic", sent, lost, lost == NOTHING, detail)
    hung = ends.count(NOBODY) + ends.count("timeout")
    internal = ends.count("internal")
    told = f"{ends.count(ANSWERED)} answered, {hung} hung, {internal} internal errors"
    fine = lost == NOTHING and not hung and not internal
    yield Outcome("malformed questions", len(ends), lost, fine, told)


def send_nonsense(client: Client, count: int, seed: int) -> int:
    """Publish damaged messages that no reader may take; return how many were sent."""
    chance = random.Random(seed)
    topics = [topic for topic in TOPICS if topic.message and topic.delivery not in SILENT]
    mutators = {topic.name: _mutator(topic, chance) for topic in topics}
    sent = 0
    while sent < count:
        topic = chance.choice(topics)
        data = mutators[topic.name].next()
        if _decodes(topic, data):
            continue  # what is a message might rightly change the map
        key = topic.key(**{name: IDS[name] for name in topic.id_names})
        encoding = topic.encoding if chance.random() < 0.9 else chance.choice(ENCODINGS)
        client.publish(key, data, encoding)
        sent += 1
        time.sleep(PAUSE_S)
    return sent


def ask_nonsense(client: Client, count: int, seed: int) -> list[str]:
    """Ask damaged questions; return how each of them ended."""
    chance = random.Random(seed)
    texts = Mutator(SELECTORS, BYTES, chance)
    payloads = Mutator(tuple(map(json_bytes, OBJECTS)), BYTES, chance)
    ends = []
    for _ in range(count):
        key = QUERY_ASK.key(scene=SCENE)
        said = texts.next().decode(errors="replace").replace("\0", "").replace("#", "")
        payload = payloads.next() if chance.random() < 0.5 else b""
        replies, errors = client.get(f"{key}?{said}", payload, chance.choice(ENCODINGS))
        ends.append(ANSWERED if replies else errors[0].code if errors else NOBODY)
    return ends


def no_model_server(plan: Plan) -> Iterator[Outcome]:
    """Questions for a reasoner whose server is down, or takes a call and never answers."""
    for fault, server in (("VLM server down", _nobody), ("VLM server hangs", _hanging)):
        with server() as port, live(plan, graph=_with_reasoner(plan, port)) as graph:
            settled(graph)
            question = "q=the ball on the table;mode=reason;deadline_ms=3000"
            key = f"{QUERY_ASK.key(scene=SCENE)}?{question}"
            began_s = time.monotonic()
            ends = [asked(graph.client, key) for _ in range(plan.pick(5, 2))]
            slowest_s = (time.monotonic() - began_s) / len(ends)
        fine = set(ends) == {ANSWERED}
        detail = f"answered by the encoder, {slowest_s:.2f} s each"
        yield Outcome(fault, len(ends), NOTHING if fine else "answers", fine, detail)


def _with_reasoner(plan: Plan, port: int) -> Path:
    recording, _ = files_of(plan)
    url = f"http://127.0.0.1:{port}/v1"
    reasoner = f'{{kind: openai, base_url: "{url}", model: none, key_env: ""}}'
    folder = plan.work / str(port)
    folder.mkdir()
    return write_graph(folder, recording, reasoning=f"{{reasoner: {reasoner}}}")


@contextmanager
def _nobody() -> Iterator[int]:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        yield taken.getsockname()[1]  # bound, but nobody listens


@contextmanager
def _hanging() -> Iterator[int]:
    held: list[socket.socket] = []
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        listener.listen()

        def hold() -> None:
            try:
                while True:
                    held.append(listener.accept()[0])
            except OSError:
                return

        threading.Thread(target=hold, daemon=True).start()
        yield listener.getsockname()[1]
    for connection in held:
        connection.close()


def _mutator(topic: Topic, chance: random.Random) -> Mutator:
    seeds = tuple(encode(one) for one in EXAMPLES if type(one) is topic.message)
    return Mutator(seeds, MSGPACK, chance)


def _decodes(topic: Topic, data: bytes) -> bool:
    try:
        from_bytes(topic, data)
    except DecodeError:
        return False
    return True
