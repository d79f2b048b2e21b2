"""A node for tests of the runtime: echoes poses, answers queries, fails and hangs on request.

Run as ``python tests/support/toy_node.py toy --endpoint ...``.
"""

import hashlib
import json
import sys
import threading
import time
from dataclasses import dataclass
from typing import Any, ClassVar

from sceneq_nodes import NODES
from sceneq_nodes._bus import Bus, Context, QueryError, Received, Reply, Request
from sceneq_nodes._lifecycle import end
from sceneq_nodes._process import main
from sceneq_schemas.topics import POSE, QUERY_INSTANCES

AGES = 10**9
"""Iterations that nobody waits for."""


@dataclass(frozen=True, slots=True)
class ToyParams:
    """``depth`` of the inbox; ``missing`` names a file that is not there."""

    depth: int = 4
    missing: str = ""


class Toy:
    """``source`` of a pose: ``sleep`` and ``compute`` never return, ``crash`` raises, ``release``
    lets the queries go that wait.
    """

    Params: ClassVar[type] = ToyParams
    idle_s: ClassVar[float] = 0.2

    def __init__(self, params: ToyParams, context: Context) -> None:
        self.params = params
        self.context = context
        self.released = threading.Event()

    def open(self, bus: Bus) -> None:
        if self.params.missing:
            raise ValueError(f"no such folder: {self.params.missing}")
        self.bus = bus
        bus.subscribe(POSE, depth=self.params.depth, robot=self.context.robot)
        bus.serve(QUERY_INSTANCES, self.answer, scene=self.context.scene)

    def step(self, received: Received | None) -> None:
        if received is None:
            self.bus.count("idle")
            return
        acts = {"sleep": sleep, "compute": compute, "crash": crash, "release": self.released.set}
        act = acts.get(received.message.source)
        if act is not None:
            act()
        self.bus.publish(POSE, received.message, robot="echo")
        self.bus.report(seq=received.message.seq)

    def answer(self, request: Request) -> Reply | None:
        match request.parameters.get("do"):
            case "nothing":
                return None
            case "refuse":
                raise QueryError("bad_request", "no question", "add ?q=")
            case "fail":
                raise RuntimeError("broken")
            case "wait":
                self.released.wait(60)
            case "alive":
                return reply(alive=sorted(self.bus.alive()))
        return reply(
            parameters=dict(request.parameters),
            wildcard=request.wildcard,
            payload=request.payload.decode(),
            encoding=request.encoding,
        )

    def close(self) -> None:
        print("closed", file=sys.stderr)


def reply(**body: Any) -> Reply:
    return Reply(json.dumps(body).encode(), QUERY_INSTANCES.encoding)


def sleep() -> None:
    time.sleep(600)


def compute() -> None:
    hashlib.pbkdf2_hmac("sha256", b"one call", b"without bytecode between", AGES)


def crash() -> None:
    raise RuntimeError("a bug")


if __name__ == "__main__":
    NODES["toy"] = "toy_node:Toy"
    end(main())
