"""What a reader of a graph can know, to be compared with what one of an undisturbed graph knew."""

import json
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, fields
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sceneq_nodes._client import Client
from sceneq_nodes._wire import from_bytes
from sceneq_schemas.topics import FEATURE_SNAPSHOT, QUERY_INSTANCES, VIEW_SNAPSHOT
from sceneq_tools.chaos.live_graph import LiveGraph, write_graph
from sceneq_tools.chaos.scenario import NOTHING, Plan
from sceneq_tools.chaos.small_recording import write_small_sample

if TYPE_CHECKING:
    from sceneq_tools.collect import Get

SCENE = "small"
QUESTIONS = ("red thing", "table", "the ball on the table", "how many boxes are there?")
CHECKPOINTS = "{store: {replay_s: 0.3, share: 1.0}}"
"""Often, so that there are some in a short run."""
VIEWS_ANEW = "nothing of the map; views chosen anew"
POLL_S, STILL_S = 0.1, 1.5
TIMEOUT_S = 20.0
SHORT_FRAMES, FRAMES = 8, 14


VARYING = ("map", "query_id", "took_ms", "cached")
"""What no two runs say alike of a question: numbers of revisions and questions, and times."""


@dataclass(frozen=True, slots=True)
class Known:
    """The digest of the map, and as JSON all that is said of its instances, their views with their
    masks, their descriptors, and answers without their times.
    """

    digest: str
    instances: str
    views: str
    descriptors: str
    answers: str

    def lost(self, whole: "Known") -> str:
        """Return what is not as in ``whole``, ``nothing`` when all is."""
        names = [field.name for field in fields(self)]
        differing = [name for name in names if getattr(self, name) != getattr(whole, name)]
        return f"{', '.join(differing)} ({self._difference(whole)})" if differing else NOTHING

    def lost_but_views(self, whole: "Known") -> str:
        """Return what is lost when views are chosen anew, and so descriptors made, in one map."""
        return VIEWS_ANEW if self.digest == whole.digest != "" else self.lost(whole)

    def _difference(self, whole: "Known") -> str:
        """Return where the first difference is."""
        if self.digest != whole.digest:
            return f"digest {self.digest}, not {whole.digest}"
        for name in ("instances", "views", "descriptors", "answers"):
            one, other = json.loads(getattr(self, name)), json.loads(getattr(whole, name))
            if found := _first_difference(one, other):
                return f"{name}{found}"
        return "nothing"


@contextmanager
def live(plan: Plan, *options: str, graph: Path | None = None, **more: Any) -> Iterator[LiveGraph]:
    """Run a graph, that of the plan by default, on its small recording until the block ends."""
    recording, usual = files_of(plan)
    with tempfile.TemporaryDirectory(prefix="sq") as runtime:
        running = LiveGraph(graph or usual, recording, Path(runtime), *options, **more)
        try:
            yield running
        finally:
            running.close()


def files_of(plan: Plan) -> tuple[Path, Path]:
    """Return recording and graph, made by the first who asks."""
    shared = plan.together
    recording, graph = shared / SCENE, shared / "graph.yaml"
    if not recording.exists():
        write_small_sample(recording, plan.pick(FRAMES, SHORT_FRAMES))
        write_graph(shared, recording, mapping=CHECKPOINTS)
    return recording, graph


def undisturbed(plan: Plan) -> Known:
    """Return what is known at the end when nothing happens; found out once in a run."""
    kept = plan.together / "undisturbed.json"
    if not kept.exists():
        with live(plan) as graph:
            kept.write_text(json.dumps(asdict(settled(graph))))
    return Known(**json.loads(kept.read_text()))


def settled(graph: LiveGraph) -> Known:
    """Wait until everything is described, and stays so, and return what is known then."""
    for _ in range(2):
        graph.wait_until_settled()
        _wait_until_still(graph)
    return known(graph.client)


def _wait_until_still(graph: LiveGraph) -> None:
    """Wait until what waited in the inboxes has gone its way, and nothing follows."""
    newest, since_s = None, time.monotonic()
    while time.monotonic() - since_s < STILL_S:
        waiting = sum(node.waiting for node in graph.heard().values())
        now = graph.value("mapping", "frame_seq")
        if waiting or now != newest:
            newest, since_s = now, time.monotonic()
        time.sleep(POLL_S)


def known(client: Client) -> Known:
    """Return what is known now."""
    from sceneq_tools.collect import collect
    from sceneq_tools.export_command import getter

    get = getter(client, SCENE)
    files = collect(get, SCENE)
    told = files.document(files.cloud())
    answers = [_lasting(asked(client, question)) for question in QUESTIONS]
    parts = told["instances"], _views(get), _descriptors(get, files.descriptors.model), answers
    return Known(told["digest"], *(json.dumps(part, sort_keys=True) for part in parts))


def asked(client: Client, question: str) -> dict[str, Any]:
    """Return the answer to a question.

    Raises:
        ConnectionError: there is none.
    """
    selector = f"{QUERY_INSTANCES.key(scene=SCENE)}?q={question};k=3"
    replies, errors = client.get(selector, timeout_s=TIMEOUT_S)
    if not replies:
        raise ConnectionError(str(errors[0]) if errors else f"nobody answers {selector}")
    answer: dict[str, Any] = json.loads(replies[0][1].payload)
    return answer


def _views(get: "Get") -> Any:
    """Return the views of every instance: keyframe, box, pixels, and the mask's digest."""
    reply = get(VIEW_SNAPSHOT, {})
    sets = from_bytes(VIEW_SNAPSHOT, reply.payload).view_sets if reply else ()
    return {
        str(one.instance_id): [
            {
                "seq": [view.seq, view.stamp_ns],
                "px": view.visible_px,
                "box": view.box_xyxy.tolist(),
                "mask": [*view.mask_shape, sha256(view.mask_bits).hexdigest()],
            }
            for view in one.views
        ]
        for one in sets
    }


def _descriptors(get: "Get", model: str) -> Any:
    """Return the digest of every descriptor, and the keyframes that it was made of."""
    reply = get(FEATURE_SNAPSHOT, {}, model=model)
    every = from_bytes(FEATURE_SNAPSHOT, reply.payload).descriptors if reply else ()
    return {
        str(one.instance_id): {
            "seq": one.view_seq.tolist(),
            "digest": sha256(one.descriptor.tobytes() + one.feature.tobytes()).hexdigest(),
        }
        for one in every
    }


def _lasting(answer: dict[str, Any]) -> dict[str, Any]:
    """Return an answer without what varies from run to run."""
    cost = {name: value for name, value in answer["cost"].items() if name != "ms"}
    kept = {name: value for name, value in answer.items() if name not in VARYING}
    return {**kept, "cost": cost}


def _first_difference(one: Any, other: Any) -> str:
    if type(one) is type(other) and isinstance(one, dict) and one.keys() == other.keys():
        pairs = [(f".{key}", one[key], other[key]) for key in one]
    elif isinstance(one, list) and isinstance(other, list) and len(one) == len(other):
        pairs = [(f"[{i}]", *both) for i, both in enumerate(zip(one, other, strict=True))]
    else:
        return "" if one == other else f": {one!r:.60} is not {other!r:.60}"
    found = ((where, _first_difference(a, b)) for where, a, b in pairs)
    return next((where + inner for where, inner in found if inner), "")
