"""The pages about a scene that answer no question: status, labels, list and overview."""

from collections.abc import Callable

from sceneq_core.mapping.delta import Instance
from sceneq_core.routing.labels import LabelSet
from sceneq_core.routing.scene import SceneInstance
from sceneq_nodes._answer_json import Json, listing_json
from sceneq_nodes._ask import DEFAULT_K, Ask, read_ask, reply
from sceneq_nodes._bus import Reply, Request
from sceneq_nodes._look import Look, no_such
from sceneq_nodes._stopwatch import Stopwatch

MAX_LISTED = 500
TOP_LABELS = 20

USAGE = {
    "instances": "?q=red mug (or the question as payload, or a JPEG or PNG picture); k=5; "
    "fmt=json|msgpack; without q: ?id=7 one instance, ?k=100;after=0 a page of the list",
    "ask": "?q=the mug on the table, or: how many chairs, what is on the desk, where is the mug, "
    "is there a sink, when did you last see the keys, the mug and the plate; may call the "
    "reasoner; mode=fast|reason; k=5; deadline_ms=3000",
    "label": "?id=7: what the instance is called, with probabilities; labels=mug,cup,bowl chooses "
    "among these; k=5; mode=reason asks the reasoner; deadline_ms=3000",
    "names": ": what was taught, and by whom; teach with sceneq teach 7 'my mug'",
}


class ScenePages:
    """Answers ``status`` and ``labels``, lists instances and explains how to ask."""

    def __init__(
        self,
        scene: str,
        label_set: LabelSet,
        look: Callable[[], Look],
        health: Callable[[], Json],
    ) -> None:
        self._scene = scene
        self._label_set = label_set
        self._look = look
        self._health = health

    def status(self, request: Request) -> Reply | None:
        """How the scene and its nodes are."""
        ask = read_ask(request)
        if request.wildcard and ask.text:
            return None
        body = {**self._look().scene_json(self._scene), **self._health()}
        return reply(body, "status", ask.fmt)

    def labels(self, request: Request) -> Reply | None:
        """What things may be called, and how often which name was given."""
        ask = read_ask(request)
        if request.wildcard and ask.text:
            return None
        body: Json = {
            "scene": self._scene,
            "label_set": self._label_set.name,
            "count": len(self._label_set),
            "given": self._look().given(len(self._label_set) if ask.k else TOP_LABELS),
        }
        if not request.wildcard:
            body["labels"] = list(self._label_set.labels)
        return reply(body, "labels", ask.fmt)

    def listing(self, ask: Ask, look: Look, watch: Stopwatch) -> Reply:
        """One instance, or a page of the list of all, also of those that wait."""
        snapshot = look.snapshot
        known: dict[int, SceneInstance | Instance] = {}
        known |= {one.instance_id: one for one in snapshot.waiting}
        known |= {one.instance_id: one for one in snapshot.instances}
        if ask.instance_id is None:
            behind = [key for key in sorted(known) if key > ask.after]
            listed = behind[: min(ask.k or DEFAULT_K, MAX_LISTED)]
        elif ask.instance_id in known:
            listed = [ask.instance_id]
        else:
            raise no_such(ask.instance_id, self._scene)
        stamp = look.stamp(self._scene, watch)
        body = listing_json([known[key] for key in listed], snapshot.revision, stamp)
        return reply({**body, "count": len(known)}, "instances", ask.fmt)

    def overview(self, ask: Ask, look: Look) -> Reply:
        """What is there, and how to ask."""
        body = {
            **look.scene_json(self._scene),
            "usage": {
                name: f"sceneq/query/{self._scene}/{name}{how}" for name, how in USAGE.items()
            },
            "labels": look.given(TOP_LABELS),
        }
        return reply(body, "usage", ask.fmt)
